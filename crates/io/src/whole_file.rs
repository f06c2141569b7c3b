//! Files that are written whole or not at all.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

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
type Complete<'a> = (&'a Path, tempfile::NamedTempFile);

fn complete(
    path: &Path,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> Result<Complete<'_>, Error> {
    let written = temporary_file(path).and_then(|mut file| {
        write(file.as_file_mut())?;
        file.as_file().sync_all()?;
        Ok(file)
    });
    Ok((path, written.map_err(cannot_write(path))?))
}

/// Gives all files their names, or none.
fn take_names(complete: Vec<Complete>) -> Result<(), Error> {
    // Names alone change. What they stood for is kept until all have.
    let mut replaced: Vec<(&Path, Option<Kept>)> = Vec::new();
    let several = complete.len() > 1;
    for (path, file) in complete {
        let taken = match several {
            true => keep(path),
            false => Ok(None),
        }
        .and_then(|kept| {
            file.persist(path).map_err(|error| error.error)?;
            Ok(kept)
        });
        match taken {
            Ok(kept) => replaced.push((path, kept)),
            Err(source) => {
                for (path, kept) in replaced {
                    // As well as can be: the first failure is what is told.
                    let _ = match kept {
                        Some(kept) => kept.persist(path).map(drop).map_err(|error| error.error),
                        None => std::fs::remove_file(path),
                    };
                }
                return Err(cannot_write(path)(source));
            }
        }
    }
    Ok(())
}

/// A second name of a file, removed again unless it takes the first one's place.
type Kept = tempfile::NamedTempFile<()>;

/// Keeps the file at `path`, if there is one.
fn keep(path: &Path) -> std::io::Result<Option<Kept>> {
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
    Ok(Some(kept))
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
pub(crate) fn temporary_file(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // As any new file: readable by whom the umask lets read it.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.prefix(PREFIX).tempfile_in(folder(path))
}
