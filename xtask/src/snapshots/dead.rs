//! Reviewed pictures and texts that no test asks for.

use std::collections::BTreeSet;
use std::path::PathBuf;

use tetrascope::core::Error;

use super::compare::Store;
use super::texts::{Text, real};

/// The files of pictures that are not `asked` for.
///
/// # Errors
/// The folder cannot be read.
pub fn pictures(store: &Store, asked: &[String]) -> Result<Vec<PathBuf>, Error> {
    let reviewed = store.reviewed()?.into_iter();
    let dead = reviewed.filter(|name| !asked.contains(name));
    Ok(dead.map(|name| store.path(&name)).collect())
}

/// The files of texts that are not `asked` for; what waits for review alone was asked for.
pub fn texts(all: &[Text], asked: &[PathBuf]) -> Vec<PathBuf> {
    let asked: BTreeSet<PathBuf> = asked.iter().map(|path| real(path)).collect();
    let reviewed = all
        .iter()
        .map(|text| &text.path)
        .filter(|path| path.is_file());
    let dead = reviewed.filter(|path| !asked.contains(&real(path)));
    dead.cloned().collect()
}

/// Deletes files.
///
/// # Errors
/// The first that cannot be deleted.
pub fn remove(files: &[PathBuf]) -> Result<(), Error> {
    for path in files {
        std::fs::remove_file(path).map_err(|source| Error::Io {
            action: "cannot delete",
            path: path.clone(),
            source,
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshots::compare::tests::{gray, store};
    use crate::snapshots::texts::all;

    #[test]
    fn what_nobody_asks_for_is_found_and_deleted() {
        let (folder, store) = store();
        for name in ["asked", "forgotten"] {
            _ = store.check(name, &gray(9), 0, true);
        }
        store.bless().expect("writable");
        let asked = ["asked".to_owned(), "not drawn yet".to_owned()];
        let mut dead = pictures(&store, &asked).expect("readable");
        assert_eq!(dead, [store.path("forgotten")]);

        for name in ["text", "old"] {
            let path = folder.path().join(format!("{name}.snap"));
            std::fs::write(path, "---\nsource: a.rs\n---\n").expect("written");
        }
        // As `insta` writes it, not in the shortest way.
        let listed = folder.path().join("left").join("..").join("text.snap");
        std::fs::create_dir_all(folder.path().join("left")).expect("made");
        let found = all(folder.path()).expect("readable");
        dead.extend(texts(&found, &[listed]));
        assert_eq!(dead[1..], [folder.path().join("old.snap")]);

        remove(&dead).expect("there are such files");
        assert!(pictures(&store, &asked).expect("readable").is_empty());
        assert_eq!(all(folder.path()).expect("readable").len(), 1);
        assert!(remove(&dead).is_err());
    }
}
