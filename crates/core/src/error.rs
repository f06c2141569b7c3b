//! The one error type of the workspace.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::text::{self, clipped};

/// An error while a volume is read, uploaded or drawn.
///
/// `Display` says what and where in one line, lower case, without a full stop;
/// [`Error::help`] says what to do about it. Both hold text of files: whatever is in there,
/// they are of [printable](text::printable) characters, and of a length that a person reads.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be opened, read or written.
    #[error("{action} {}: {}", place(path), sentence(source))]
    Io {
        /// "cannot open", "cannot read", "cannot write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A file's contents are not what its format says.
    #[error("{}, in {}{}", sentence(what), place(path), within(at))]
    Format {
        /// The file.
        path: PathBuf,
        /// Where in it: "byte 12", "line 3, column 7", "array 'Temperature'"; empty for the whole of it.
        at: String,
        /// The fault, with the numbers.
        what: String,
        /// A hint, if there is one.
        help: Option<String>,
    },
    /// A mesh, grid or transfer function was built from values that make no sense.
    #[error("{}", sentence(what))]
    Invalid {
        /// The fault, with the numbers and the index of the offending item.
        what: String,
        /// A hint, if there is one.
        help: Option<String>,
    },
    /// A scene file or a scene option is wrong.
    #[error("{}, in {}", sentence(what), clipped(at, LONGEST_PLACE))]
    Scene {
        /// The file with line and column, or the option.
        at: String,
        /// The fault.
        what: String,
        /// A hint.
        help: Option<String>,
    },
    /// Values that are out of range, or do not go with the rest.
    #[error("{}", sentence(what))]
    Usage {
        /// The fault, with the numbers.
        what: String,
        /// A hint, if there is one.
        help: Option<String>,
    },
    /// A named field is not in the volume.
    #[error("no field '{}'{}", text::name(name), fields(available))]
    NoSuchField {
        /// The name that was asked for.
        name: String,
        /// The names that exist, with their ranges.
        available: Vec<String>,
    },
    /// A name given by the user is not one of those that exist.
    #[error("no {kind} '{}'; valid: {}", text::name(name), list(valid))]
    Unknown {
        /// "algorithm", "setting", "data set", …
        kind: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        valid: Vec<String>,
    },
    /// The renderer cannot draw this scene.
    #[error("{renderer} does not draw {}: {}", sentence(what), sentence(reason))]
    Unsupported {
        /// The renderer's name.
        renderer: &'static str,
        /// The work that was asked of it.
        what: String,
        /// Why it cannot.
        reason: String,
    },
    /// No graphics adapter fits.
    #[error("no suitable graphics adapter: {}", sentence(reason))]
    NoAdapter {
        /// The adapter that was looked for, and those that were found.
        reason: String,
        /// The command to type.
        help: Option<String>,
    },
    /// Something is larger than the device allows.
    #[error("{} needs {needed} {unit}, this device holds {limit}", sentence(what))]
    TooLarge {
        /// "the cell buffer", "the image", …
        what: String,
        /// How much was needed.
        needed: u64,
        /// How much the device allows.
        limit: u64,
        /// "bytes", "pixels", "cells".
        unit: &'static str,
    },
    /// The device ran out of memory.
    #[error("out of device memory while making {} ({bytes} bytes)", sentence(what))]
    OutOfMemory {
        /// The thing that was being made.
        what: String,
        /// Its size.
        bytes: u64,
    },
    /// This machine, not the device, lacks the memory.
    #[error("{} needs {} MB of memory, more than there is", sentence(what), bytes / 1_000_000)]
    NoMemory {
        /// "an image of 8192x8192 pixels", …
        what: String,
        /// How much was needed.
        bytes: u64,
    },
    /// The device was lost, or the driver refused a command.
    #[error("the graphics device failed: {}", sentence(reason))]
    Device {
        /// The driver's words.
        reason: String,
    },
    /// A frame was given up, as [`Stop`](crate::Stop) asked.
    #[error("stopped before the picture was complete")]
    Stopped,
}

impl Error {
    /// An [`Error::Invalid`] without help.
    pub fn invalid(what: impl Into<String>) -> Error {
        Error::Invalid {
            what: what.into(),
            help: None,
        }
    }

    /// How to help, one line, in words of no program: it names a parameter of a scene in
    /// backticks, and a front end says how to give it.
    pub fn help(&self) -> Option<String> {
        self.advice().map(sentence)
    }

    fn advice(&self) -> Option<String> {
        match self {
            Error::Format { help, .. }
            | Error::Invalid { help, .. }
            | Error::Scene { help, .. }
            | Error::Usage { help, .. }
            | Error::NoAdapter { help, .. } => help.clone(),
            Error::NoSuchField { available, .. } if !available.is_empty() => {
                Some("choose one of these fields".into())
            }
            Error::TooLarge { .. } | Error::OutOfMemory { .. } => Some(
                "ask for a smaller image or mesh, or fewer samples, or draw without a GPU".into(),
            ),
            Error::NoMemory { .. } => Some("draw a smaller image".into()),
            Error::Io {
                action: "cannot write",
                path,
                source,
            } if source.kind() == std::io::ErrorKind::NotFound => {
                let folder = path.parent()?;
                Some(format!("make the folder {} first", place(folder)))
            }
            Error::Unsupported { .. } => Some("choose another algorithm".into()),
            Error::NoSuchField { .. }
            | Error::Unknown { .. }
            | Error::Io { .. }
            | Error::Device { .. }
            | Error::Stopped => None,
        }
    }

    /// Who has to act on this error; a program's exit codes can follow it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::Io { action, .. } if *action == "cannot write" => ErrorKind::Failure,
            Error::Io { .. }
            | Error::Format { .. }
            | Error::Invalid { .. }
            | Error::Scene { .. }
            | Error::NoSuchField { .. } => ErrorKind::Input,
            Error::Usage { .. } | Error::Unknown { .. } | Error::Unsupported { .. } => {
                ErrorKind::Usage
            }
            Error::NoAdapter { .. } | Error::TooLarge { .. } | Error::OutOfMemory { .. } => {
                ErrorKind::Gpu
            }
            Error::NoMemory { .. } | Error::Device { .. } | Error::Stopped => ErrorKind::Failure,
        }
    }
}

/// Who has to act on an [`Error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The run failed through no fault of the input.
    Failure,
    /// Something that does not exist or cannot be combined was asked for.
    Usage,
    /// A file, mesh or scene is wrong.
    Input,
    /// There is no GPU that can do this.
    Gpu,
}

/// The most characters of free text in a message: the longest of ours, which lists all
/// formats, has half as many.
const LONGEST_SENTENCE: usize = 800;

/// The most characters of a file's path in a message.
const LONGEST_PLACE: usize = 300;

/// Bytes of a list in a message after which names are only counted: two or three times the
/// settings of the algorithm with most of them.
const LONGEST_LIST: usize = 3000;

fn sentence(text: impl Display) -> String {
    clipped(text, LONGEST_SENTENCE)
}

fn place(path: &Path) -> String {
    clipped(path.display(), LONGEST_PLACE)
}

/// " at byte 12"; nothing where the whole file is meant.
fn within(at: &str) -> String {
    match at {
        "" => String::new(),
        at => format!(" at {}", text::name(at)),
    }
}

fn fields(available: &[String]) -> String {
    match available {
        [] => "; the volume has no fields".into(),
        available => format!("; there are {}", list(available)),
    }
}

/// The names, of which each may be as long as a file wants, and as many.
fn list(names: &[String]) -> String {
    let mut text = String::new();
    for (i, name) in names.iter().enumerate() {
        if text.len() > LONGEST_LIST {
            return format!("{text} and {} more", names.len() - i);
        }
        let comma = if i > 0 { ", " } else { "" };
        text += &format!("{comma}{}", clipped(name, LONGEST_ITEM));
    }
    text
}

/// A name and what is said of it: a range of two numbers, or the values of a setting.
const LONGEST_ITEM: usize = 2 * text::LONGEST_NAME;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_a_file_says_a_message_is_a_short_printable_line() {
        let long = "\x1b[31m\n".repeat(1 << 16);
        let path = PathBuf::from("a\x1b]0;b\x07.vtu");
        let errors = [
            Error::Format {
                path: path.clone(),
                at: long.clone(),
                what: long.clone(),
                help: Some(long.clone()),
            },
            Error::Io {
                action: "cannot read",
                path: PathBuf::from(&long),
                source: std::io::Error::other(long.clone()),
            },
            Error::Scene {
                at: long.clone(),
                what: "x".into(),
                help: None,
            },
            Error::NoSuchField {
                name: long.clone(),
                available: vec![long.clone(); 1000],
            },
            Error::Unknown {
                kind: "setting",
                name: long.clone(),
                valid: vec![long.clone()],
            },
            Error::Device { reason: long },
        ];
        for error in errors {
            let texts = [Some(error.to_string()), error.help()];
            for text in texts.into_iter().flatten() {
                assert!(!text.contains(text::is_unprintable), "{text}");
                assert!(text.chars().count() < 6000, "{}", text.len());
            }
        }
        let named = Error::Io {
            action: "cannot read",
            path,
            source: std::io::ErrorKind::NotFound.into(),
        };
        let text = named.to_string();
        assert!(
            text.starts_with("cannot read a\\u{1b}]0;b\\u{7}.vtu: "),
            "{text}"
        );
    }
}
