//! Where criterion leaves its results, and what is counted beside its times.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The folder of criterion's results, chosen as criterion chooses it.
pub fn folder() -> PathBuf {
    let of = |name| std::env::var_os(name).map(PathBuf::from);
    of("CRITERION_HOME")
        .or_else(|| Some(of("CARGO_TARGET_DIR")?.join("criterion")))
        .unwrap_or_else(|| {
            let package = Path::new(env!("CARGO_MANIFEST_DIR"));
            let root = package.parent().expect("in a folder of the repository");
            root.join("target").join("criterion")
        })
}

/// The file of what is counted, in criterion's folder: a benchmark's id, a tab and a number on each
/// line, of which the last counts.
const COUNTED: &str = "counted.tsv";

/// Keeps a number that a paper's table has and that is not a time.
///
/// # Panics
/// The file cannot be written: what was measured would be lost in silence.
pub fn keep(id: &str, value: f64) {
    let path = folder().join(COUNTED);
    std::fs::create_dir_all(folder()).expect("criterion's folder can be written");
    let file = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(&path);
    let written = file.and_then(|mut file| writeln!(file, "{id}\t{value}"));
    written.unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
}

/// The results kept in criterion's folder, by id; none where nothing was kept.
pub fn kept(folder: &Path) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(folder.join(COUNTED)).unwrap_or_default();
    let pairs = text.lines().filter_map(|line| line.split_once('\t'));
    pairs
        .filter_map(|(id, value)| Some((id.to_owned(), value.parse().ok()?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_number_counts() {
        let folder = std::env::temp_dir().join(format!("tetrascope-kept-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("made");
        std::fs::write(folder.join(COUNTED), "a/b\t1\nc d\t2.5\nbroken\na/b\t3\n")
            .expect("written");
        let found = kept(&folder);
        std::fs::remove_dir_all(&folder).expect("there");
        assert_eq!(found.len(), 2);
        assert_eq!((found["a/b"], found["c d"]), (3.0, 2.5));
        assert!(kept(&folder).is_empty());
    }
}
