//! A file's bytes, and errors that say where in it.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Component, Path, PathBuf};

use tetrascope_core::Error;

/// A file in memory.
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) bytes: Vec<u8>,
}

impl Source {
    /// Reads the whole file; an empty one is an error.
    pub(crate) fn open(path: &Path) -> Result<Source, Error> {
        let (mut file, length) = open_file(path)?;
        let mut bytes = room(usize::try_from(length).unwrap_or(usize::MAX))?;
        file.read_to_end(&mut bytes).map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        let source = Source {
            path: path.to_owned(),
            bytes,
        };
        if source.bytes.is_empty() {
            return Err(source.error("", "the file is empty"));
        }
        Ok(source)
    }

    /// An error at a place in this file.
    pub(crate) fn error(&self, at: impl Into<String>, what: impl Into<String>) -> Error {
        format_error(&self.path, at, what)
    }

    /// The same with something to try.
    pub(crate) fn error_with_help(
        &self,
        at: impl Into<String>,
        what: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        format_error_with_help(&self.path, at, what, help)
    }
}

/// An error at a place in the file at `path`.
pub(crate) fn format_error(path: &Path, at: impl Into<String>, what: impl Into<String>) -> Error {
    Error::Format {
        path: path.to_owned(),
        at: at.into(),
        what: what.into(),
        help: None,
    }
}

/// The same with something to try.
pub(crate) fn format_error_with_help(
    path: &Path,
    at: impl Into<String>,
    what: impl Into<String>,
    help: impl Into<String>,
) -> Error {
    Error::Format {
        path: path.to_owned(),
        at: at.into(),
        what: what.into(),
        help: Some(help.into()),
    }
}

/// Opens a regular file; its length comes with it.
pub(crate) fn open_file(path: &Path) -> Result<(File, u64), Error> {
    let failed = |action| {
        move |source| Error::Io {
            action,
            path: path.to_owned(),
            source,
        }
    };
    // Before opening: a pipe would wait for its other end.
    let metadata = std::fs::metadata(path).map_err(failed("cannot open"))?;
    if !metadata.is_file() {
        let source = std::io::Error::other("it is not a regular file");
        return Err(failed("cannot read")(source));
    }
    let file = File::open(path).map_err(failed("cannot open"))?;
    Ok((file, metadata.len()))
}

/// The file that the one at `path` calls `name`: in the folder of `path` or below it; `None` for
/// a name that leads out of there, by `..` or from a root.
///
/// Links are followed: whoever makes one can read what it stands for.
pub(crate) fn beside(path: &Path, name: &str) -> Option<PathBuf> {
    let is_inside = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = Path::new(name);
    name.components().all(is_inside).then(|| folder.join(name))
}

/// The help of an error about a name that [`beside`] refuses.
pub(crate) const KEEP_TOGETHER: &str =
    "a file may name others in its own folder and below: move them there";

/// Bytes of a file from `offset` on; fewer where it ends.
pub(crate) fn read_at(path: &Path, offset: u64, count: usize) -> Result<Vec<u8>, Error> {
    let failed = |source| Error::Io {
        action: "cannot read",
        path: path.to_owned(),
        source,
    };
    let (mut file, _) = open_file(path)?;
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(offset)).map_err(failed)?;
    let read = file.take(count as u64).read_to_end(&mut bytes);
    read.map_err(failed)?;
    Ok(bytes)
}

/// Byte order of the numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Endian {
    Little,
    Big,
}

impl Endian {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Endian::Little => "little-endian",
            Endian::Big => "big-endian",
        }
    }
}

/// Defines readers of one number from the `size` bytes of a slice.
macro_rules! numbers {
    ($($name:ident: $type:ty),*) => {
        impl Endian {
            $(pub(crate) fn $name(self, bytes: &[u8]) -> $type {
                let array = bytes.try_into().expect("the caller cuts the bytes to size");
                match self {
                    Endian::Little => <$type>::from_le_bytes(array),
                    Endian::Big => <$type>::from_be_bytes(array),
                }
            })*
        }
    };
}
numbers!(i16: i16, u16: u16, i32: i32, u32: u32, i64: i64, u64: u64, f32: f32, f64: f64);

/// An empty vector with room for `count` items.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, Error> {
    let mut items = Vec::new();
    match items.try_reserve_exact(count) {
        Ok(()) => Ok(items),
        Err(_) => Err(no_memory::<T>(count)),
    }
}

/// Makes room for `more` items.
///
/// # Errors
/// [`Error::Invalid`] where the system has no memory for so many.
pub(crate) fn reserve<T>(items: &mut Vec<T>, more: usize) -> Result<(), Error> {
    items.try_reserve(more).map_err(|_| no_memory::<T>(more))
}

fn no_memory<T>(count: usize) -> Error {
    Error::Invalid {
        what: format!(
            "there is no memory for {count} values of {} bytes",
            size_of::<T>()
        ),
        help: Some("close other programs, or cut the volume into parts".into()),
    }
}

/// "1 cell", "2 cells".
pub(crate) fn count(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}
