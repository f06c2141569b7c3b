//! Patterns of file names: `*` is any characters, `?` any one of them.

use std::path::{Path, PathBuf};

use tetrascope::core::{Error, text};
use tetrascope::scene::nearest;

use super::natural;

/// Whether a word stands for the files that match it: a file of that very name is itself.
pub(crate) fn is_pattern(word: &Path) -> bool {
    has_wildcard(&word.to_string_lossy()) && !word.exists()
}

fn has_wildcard(text: &str) -> bool {
    text.contains(['*', '?'])
}

/// The files that match `word`, in natural order; without any, the error says what there is.
pub(crate) fn expand(word: &Path) -> Result<Vec<PathBuf>, Error> {
    let folder = word.parent().unwrap_or(Path::new(""));
    let pattern = word.file_name().unwrap_or_default().to_string_lossy();
    if has_wildcard(&folder.to_string_lossy()) && !folder.exists() {
        return Err(Error::Usage {
            what: format!("'{}' is a pattern of folders", word.display()),
            help: Some("* and ? stand for characters of a file's name alone".into()),
        });
    }
    let mut names: Vec<(String, PathBuf)> = Vec::new();
    let mut others: Vec<String> = Vec::new();
    for path in files(folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match matches(&pattern, &name) {
            true => names.push((name.into_owned(), path)),
            false => others.push(name.into_owned()),
        }
    }
    if names.is_empty() {
        return Err(no_match(word, &pattern, others));
    }
    names.sort_by(|a, b| natural::compare(&a.0, &b.0));
    Ok(names.into_iter().map(|(_, path)| path).collect())
}

/// The files in a folder, without hidden ones.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let here = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let failed = |source| Error::Io {
        action: "cannot open",
        path: here.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(here).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        let path = folder.join(&name);
        if !name.to_string_lossy().starts_with('.') && path.is_file() {
            files.push(path);
        }
    }
    Ok(files)
}

fn no_match(word: &Path, pattern: &str, others: Vec<String>) -> Error {
    /// So many names are listed.
    const MOST: usize = 4;
    let extension = Path::new(pattern).extension();
    let start = pattern.split(['*', '?']).next().unwrap_or_default();
    let is_similar = |name: &&String| {
        let starts_alike = !start.is_empty() && name.starts_with(start);
        starts_alike || (extension.is_some() && Path::new(name).extension() == extension)
    };
    let mut similar: Vec<&str> = others
        .iter()
        .filter(is_similar)
        .map(String::as_str)
        .collect();
    if similar.is_empty() {
        similar.extend(nearest(pattern, &others));
    }
    similar.sort_by(|a, b| natural::compare(a, b));
    let listed: Vec<_> = similar.iter().take(MOST).map(|n| text::name(n)).collect();
    let more = match similar.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Error::Invalid {
        what: format!("no file matches '{}'", word.display()),
        help: Some(match listed.is_empty() {
            true => "no file in that folder has such a name".into(),
            false => format!("that folder has {}{more}", listed.join(", ")),
        }),
    }
}

/// Whether `pattern` stands for `name`: in time that grows with the product of their lengths.
fn matches(pattern: &str, name: &str) -> bool {
    let name: Vec<char> = name.chars().collect();
    // Which beginnings of the name the pattern so far stands for, by length.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    for letter in pattern.chars() {
        if letter == '*' {
            let first = reached.iter().position(|&is| is).unwrap_or(reached.len());
            reached[first..].fill(true);
            continue;
        }
        for end in (1..=name.len()).rev() {
            reached[end] = reached[end - 1] && (letter == '?' || letter == name[end - 1]);
        }
        reached[0] = false;
    }
    reached[name.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_and_question_marks_match() {
        for (pattern, yes, no) in [
            ("a*.vtu", "a.vtu a1.vtu a.b.vtu", "b.vtu a.vti a.vtux"),
            ("*", "a é.vtu", ""),
            ("a?c", "abc aéc", "ac abbc"),
            (
                "*_??.vtu",
                "step_10.vtu __01.vtu",
                "step_1.vtu step_100.vtu",
            ),
            ("**a**b**", "ab xaxbx", "ba a b"),
            ("[a].vtu", "[a].vtu", "a.vtu"),
        ] {
            for name in yes.split_whitespace() {
                assert!(matches(pattern, name), "{pattern} {name}");
            }
            for name in no.split_whitespace() {
                assert!(!matches(pattern, name), "{pattern} {name}");
            }
        }
        // No pattern takes forever.
        assert!(!matches(&"*a".repeat(100), &"a".repeat(99)));
    }
}
