//! The files of `insta`: `snapshots/NAME.snap` beside a test, and `NAME.snap.new` where the test's
//! text is another.

use std::fs;
use std::path::{Path, PathBuf};

use tetrascope::core::Error;

/// A reviewed text, or one that waits for review.
#[derive(Debug, PartialEq)]
pub struct Text {
    /// The reviewed file, whether it exists or not.
    pub path: PathBuf,
}

/// Folders without sources.
const SKIPPED: [&str; 2] = ["target", ".git"];

/// All texts below a folder, sorted.
///
/// # Errors
/// A folder that cannot be read.
pub fn all(root: &Path) -> Result<Vec<Text>, Error> {
    let mut texts = Vec::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries =
            fs::read_dir(&folder).map_err(|source| failed("cannot read", &folder, source))?;
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = entry.path();
            let kind = entry.file_type();
            if kind.is_ok_and(|kind| kind.is_dir()) {
                if !SKIPPED.contains(&name.as_str()) {
                    folders.push(path);
                }
            } else if name.ends_with(".snap") {
                texts.push(Text { path });
            } else if name.ends_with(".snap.new") {
                texts.push(Text {
                    path: path.with_extension(""),
                });
            }
        }
    }
    texts.sort_by(|a, b| a.path.cmp(&b.path));
    texts.dedup();
    Ok(texts)
}

impl Text {
    /// "cli__usage__help-render".
    pub fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// The file that waits for review, where there is one.
    pub fn pending(&self) -> Option<PathBuf> {
        let pending = self.path.with_extension("snap.new");
        pending.is_file().then_some(pending)
    }

    /// The text that waits for review and the one that it would replace, both without headers.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn difference(&self) -> Result<Option<(Option<String>, String)>, Error> {
        let Some(pending) = self.pending() else {
            return Ok(None);
        };
        let read = |path: &Path| {
            fs::read_to_string(path).map_err(|source| failed("cannot read", path, source))
        };
        let expected = match self.path.is_file() {
            true => Some(body(&read(&self.path)?).to_owned()),
            false => None,
        };
        Ok(Some((expected, body(&read(&pending)?).to_owned())))
    }

    /// Takes what waits for review as the reviewed text; whether there was any.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub fn accept(&self) -> Result<bool, Error> {
        let Some(pending) = self.pending() else {
            return Ok(false);
        };
        let text = fs::read_to_string(&pending)
            .map_err(|source| failed("cannot read", &pending, source))?;
        crate::output::write(&self.path, without_lines(&text))?;
        fs::remove_file(&pending).map_err(|source| failed("cannot delete", &pending, source))?;
        Ok(true)
    }
}

/// The file without its header, which is between two lines of "---".
fn body(file: &str) -> &str {
    let after = file.strip_prefix("---\n");
    let parts = after.and_then(|rest| rest.split_once("\n---\n"));
    parts.map_or(file, |(_, body)| body)
}

/// The file as `insta` keeps it: which line asked, in the header, waits for review only.
fn without_lines(file: &str) -> String {
    let header = file.len() - body(file).len();
    let (header, body) = file.split_at(header);
    let kept = header
        .lines()
        .filter(|line| !line.starts_with("assertion_line:"));
    kept.map(|line| format!("{line}\n")).collect::<String>() + body
}

/// The files that `insta` has listed, one per line.
///
/// # Errors
/// The list cannot be read.
pub fn listed(list: &Path) -> Result<Vec<PathBuf>, Error> {
    let lines = fs::read_to_string(list).map_err(|source| failed("cannot read", list, source))?;
    Ok(lines.lines().map(|line| real(Path::new(line))).collect())
}

/// The path without links and "..", where there is such a file.
pub(crate) fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.into())
}

fn failed(action: &'static str, path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        action,
        path: path.into(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEW: &str =
        "---\nsource: a.rs\nassertion_line: 9\nexpression: text\n---\nnew\n---\nend\n";

    #[test]
    fn what_waits_for_review_is_found_and_accepted() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let place = folder.path().join("crates").join("snapshots");
        fs::create_dir_all(&place).expect("made");
        fs::create_dir_all(folder.path().join("target")).expect("made");
        let write = |path: &Path, text: &str| fs::write(path, text).expect("written");
        write(&folder.path().join("target").join("built.snap"), NEW);
        write(&place.join("kept.snap"), "---\nsource: a.rs\n---\nkept\n");
        write(&place.join("first.snap.new"), NEW);
        let texts = all(folder.path()).expect("readable");
        let names: Vec<String> = texts.iter().map(Text::name).collect();
        assert_eq!(names, ["first", "kept"]);
        assert_eq!(texts[1].difference().expect("readable"), None);
        let (expected, actual) = texts[0].difference().expect("readable").expect("differs");
        assert_eq!((expected, actual.as_str()), (None, "new\n---\nend\n"));
        assert!(texts[0].accept().expect("writable") && !texts[1].accept().expect("writable"));
        let accepted = fs::read_to_string(&texts[0].path).expect("written");
        assert_eq!(accepted, NEW.replace("assertion_line: 9\n", ""));
        assert_eq!(texts[0].pending(), None);
    }
}
