//! Files that are written whole or not at all.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tetrascope_core::Error;

/// Writes a whole file or nothing: the bytes go to a temporary file in the same
/// folder, which then takes the name.
///
/// Where the process may not write files of that size (`RLIMIT_FSIZE`), that is an error
/// only if the process handles or ignores the signal SIGXFSZ, which ends it otherwise.
///
/// # Errors
/// [`Error::Io`] when the folder or the file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_files(&[(path, bytes)])
}

/// Refuses a name under which no file can be written: in a folder that does not exist or cannot
/// be written to, or that of a folder.
pub(crate) fn check_writable(path: &Path) -> Result<(), Error> {
    let writable = match path.is_dir() {
        true => Err(std::io::ErrorKind::IsADirectory.into()),
        false => temporary_file(path).map(drop),
    };
    writable.map_err(cannot_write(path))
}

/// Writes what `write` makes of an empty file, whole or not at all; see [`write_file`].
pub(crate) fn write_with(
    path: &Path,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> Result<(), Error> {
    take_names(vec![complete(path, write)?])
}

/// Writes all files or none of them; see [`write_file`].
pub(crate) fn write_files(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let files = files.iter().map(|(path, bytes)| {
        // Each is complete before any takes its name.
        complete(path, |file| file.write_all(bytes))
    });
    take_names(files.collect::<Result<_, _>>()?)
}

/// A file that is written, beside the one whose name it is to take.
type Complete<'a> = (&'a Path, Temporary<File>);

fn complete(
    path: &Path,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> Result<Complete<'_>, Error> {
    let written = temporary_file(path).and_then(|mut temporary| {
        write(temporary.file.as_file_mut())?;
        temporary.file.as_file().sync_all()?;
        Ok(temporary)
    });
    Ok((path, written.map_err(cannot_write(path))?))
}

/// Gives all files their names, or none.
fn take_names(complete: Vec<Complete>) -> Result<(), Error> {
    // Names alone change. What they stood for is kept until all have.
    let mut replaced: Vec<(&Path, Option<Temporary<()>>)> = Vec::new();
    let _held = hold_names();
    let several = complete.len() > 1;
    for (path, file) in complete {
        let taken = match several {
            true => keep(path),
            false => Ok(None),
        }
        .and_then(|kept| {
            file.persist(path)?;
            Ok(kept)
        });
        match taken {
            Ok(kept) => replaced.push((path, kept)),
            Err(source) => {
                for (path, kept) in replaced {
                    // As well as can be: the first failure is what is told.
                    let _ = match kept {
                        Some(kept) => kept.persist(path),
                        None => std::fs::remove_file(path),
                    };
                }
                return Err(cannot_write(path)(source));
            }
        }
    }
    Ok(())
}

/// Keeps the file at `path`, if there is one, by a second name.
fn keep(path: &Path) -> std::io::Result<Option<Temporary<()>>> {
    if !path.exists() {
        return Ok(None);
    }
    let link = |name: &Path| match std::fs::hard_link(path, name) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            // Not every file system has links.
            std::fs::copy(path, name).map(drop)
        }
        done => done,
    };
    let kept = tempfile::Builder::new()
        .prefix(PREFIX)
        .make_in(folder(path), link)?;
    Ok(Some(Temporary::new(kept)))
}

pub(crate) fn cannot_write(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    |source| Error::Io {
        action: "cannot write",
        path: path.to_owned(),
        source: without_path(source),
    }
}

/// The error without the path of a temporary file, which is nobody's business.
///
/// `tempfile` 3.27 adds it to the words of the operating system's error, which it then
/// hides.
fn without_path(error: std::io::Error) -> std::io::Error {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((words, path)) if path.contains(PREFIX) => {
            std::io::Error::new(error.kind(), words.to_owned())
        }
        _ => error,
    }
}

/// The folder that a file lies in.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// How names of temporary files begin.
pub(crate) const PREFIX: &str = ".tetrascope-";

/// A file in the folder of `path`, removed again unless it takes that name.
fn temporary_file(path: &Path) -> std::io::Result<Temporary<File>> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // As any new file: readable by whom the umask lets read it.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let _held = hold_names();
    let file = builder.prefix(PREFIX).tempfile_in(folder(path))?;
    Ok(Temporary::new(file))
}

/// The temporary files and folders of this process.
static PENDING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Locked, for a moment, after [`hold_names`] if both are.
fn pending() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Held while a temporary file is made and noted, while files take their names, and for good once
/// the process ends.
fn hold_names() -> MutexGuard<'static, ()> {
    static HELD: Mutex<()> = Mutex::new(());
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of all that is being written, and then does `end`, which ends the
/// process, before another file is made or takes its name.
///
/// For a program that is told to end, such as by a signal: a file that is being written does not
/// appear, and nothing is left of it. Call it in a thread that waits for signals, as locks cannot
/// be taken while a signal is handled.
pub fn remove_temporary_files_and<T>(end: impl FnOnce() -> T) -> T {
    let _held = hold_names();
    let paths = std::mem::take(&mut *pending());
    for path in paths {
        // A file that cannot be removed stays: the process ends all the same.
        let _ = match path.is_dir() {
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
    }
    end()
}

/// A file that is removed when it is dropped, or by [`remove_temporary_files_and`].
struct Temporary<F> {
    /// Dropped before its note.
    file: tempfile::NamedTempFile<F>,
    _note: Note,
}

/// A path in [`PENDING`].
struct Note(PathBuf);

impl Note {
    fn new(path: &Path) -> Note {
        pending().insert(path.to_owned());
        Note(path.to_owned())
    }
}

impl Drop for Note {
    fn drop(&mut self) {
        pending().remove(&self.0);
    }
}

impl<F> Temporary<F> {
    /// Takes note of a file while names are held.
    fn new(file: tempfile::NamedTempFile<F>) -> Temporary<F> {
        let note = Note::new(file.path());
        Temporary { file, _note: note }
    }

    /// Gives the file this name while names are held.
    fn persist(self, path: &Path) -> std::io::Result<()> {
        let persisted = self.file.persist(path);
        persisted.map(drop).map_err(|error| error.error)
    }
}

/// A folder in the system's place for such, removed when it is dropped or by
/// [`remove_temporary_files_and`].
pub struct TemporaryFolder {
    /// Dropped before its note.
    folder: tempfile::TempDir,
    _note: Note,
}

impl TemporaryFolder {
    /// Makes one.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be made.
    pub fn new() -> Result<TemporaryFolder, Error> {
        let _held = hold_names();
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir();
        let folder = folder.map_err(cannot_write(&std::env::temp_dir()))?;
        let note = Note::new(folder.path());
        Ok(TemporaryFolder {
            folder,
            _note: note,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

#[cfg(test)]
mod tests;
