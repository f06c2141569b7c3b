//! Names of frames: `frame_%04d.png` has the step's number in it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use tetrascope::core::{Error, text};

/// The names of all frames of a series.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameName {
    folder: PathBuf,
    before: String,
    /// A shorter number has zeros before it.
    digits: usize,
    after: String,
}

impl FrameName {
    /// Reads a name in which `%d` or `%04d` stands for the number and `%%` for `%`. A folder's
    /// name is taken as it is.
    pub(crate) fn parse(path: &Path) -> Result<FrameName, Error> {
        let refuse = |what: &str| {
            let name = text::name(&path.to_string_lossy()).into_owned();
            Err(Error::Usage {
                what: format!("'{name}' {what}"),
                help: Some(format!("give -o {}", example(path))),
            })
        };
        let Some(name) = path.file_name().and_then(OsStr::to_str) else {
            return refuse("is not a name for frames");
        };
        let (mut texts, mut digits) = (vec![String::new()], 1);
        let mut rest = name;
        while let Some((text, after)) = rest.split_once('%') {
            push(&mut texts, text);
            if let Some(after) = after.strip_prefix('%') {
                push(&mut texts, "%");
                rest = after;
                continue;
            }
            let Some((format, after)) = after.split_once('d') else {
                return refuse("has a % that is neither %d nor %04d nor %%");
            };
            digits = match (format, format.strip_prefix('0')) {
                ("", _) => 1,
                (_, Some(count)) if matches!(count.as_bytes(), [b'1'..=b'9']) => {
                    usize::from(count.as_bytes()[0] - b'0')
                }
                _ => return refuse("has a % that is neither %d nor %04d nor %%"),
            };
            texts.push(String::new());
            rest = after;
        }
        push(&mut texts, rest);
        match <[String; 2]>::try_from(texts) {
            Ok([before, after]) => Ok(FrameName {
                folder: path.parent().unwrap_or(Path::new("")).to_owned(),
                before,
                digits,
                after,
            }),
            Err(texts) if texts.len() == 1 => {
                refuse("is one name for the frames of a series, which need a number each")
            }
            Err(_) => refuse("has more than one number"),
        }
    }

    /// The name of frame `number`.
    pub(crate) fn path(&self, number: usize) -> PathBuf {
        let FrameName {
            folder,
            before,
            digits,
            after,
        } = self;
        folder.join(format!("{before}{number:0digits$}{after}"))
    }
}

fn push(texts: &mut [String], text: &str) {
    texts.last_mut().expect("never empty").push_str(text);
}

/// A name for frames like `path`: without its numbers, and one at the end.
fn example(path: &Path) -> String {
    let part = |part: Option<&OsStr>, otherwise: &str| match part {
        Some(part) => part.to_string_lossy().into_owned(),
        None => otherwise.into(),
    };
    let stem = part(path.file_stem(), "frame");
    let stem = stem.split('%').next().unwrap_or_default();
    let stem = match stem.trim_end_matches(['_', '-', '.', ' ']) {
        "" => "frame",
        stem => stem,
    };
    let name = format!("{stem}_%04d.{}", part(path.extension(), "png"));
    text::name(&path.with_file_name(name).to_string_lossy()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_stands_where_it_is_wanted() {
        for (name, expected) in [
            ("%d.png", "7.png"),
            ("a_%04d.png", "a_0007.png"),
            ("x/y%%/a%%_%02d_%%d.exr", "x/y%%/a%_07_%d.exr"),
            ("%d%%", "7%"),
            ("100%%%d", "100%7"),
        ] {
            let name = FrameName::parse(Path::new(name)).expect(name);
            assert_eq!(name.path(7), Path::new(expected));
        }
        let name = FrameName::parse(Path::new("%02d")).expect("a number");
        assert_eq!(name.path(123), Path::new("123"));
    }

    #[test]
    fn other_names_are_refused_with_one_to_type() {
        for (name, help) in [
            ("a.png", "a_%04d.png"),
            ("out/a%%.exr", "out/a_%04d.exr"),
            ("a_%d_%d.png", "a_%04d.png"),
            ("%4d.png", "frame_%04d.png"),
            ("a%s.png", "a_%04d.png"),
            ("a%", "a_%04d.png"),
            ("a%00d.png", "a_%04d.png"),
            ("a%010d.png", "a_%04d.png"),
            ("a%-1d.png", "a_%04d.png"),
            ("a%0d.png", "a_%04d.png"),
            ("50%.png", "50_%04d.png"),
        ] {
            let error = FrameName::parse(Path::new(name)).expect_err(name);
            let found = error.help().expect("a name");
            assert_eq!(found, format!("give -o {help}"), "{error}");
            FrameName::parse(Path::new(help)).expect("a name that is taken");
        }
    }
}
