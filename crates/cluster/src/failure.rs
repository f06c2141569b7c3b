//! The failure of one rank, as all ranks hear of it.

use std::fmt;

use tetrascope_core::{Error, ErrorKind};

/// Why the work of all ranks ended, and at which rank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The rank that failed; of several, the first.
    pub rank: usize,
    /// How many ranks there are.
    pub ranks: usize,
    /// Whether all ranks failed alike, so that it is not about one of them.
    pub everywhere: bool,
    /// Who has to act on it.
    pub kind: ErrorKind,
    /// The fault and its place, in one line.
    pub message: String,
    /// How to help, if that is known.
    pub help: Option<String>,
}

const KINDS: [ErrorKind; 4] = [
    ErrorKind::Failure,
    ErrorKind::Usage,
    ErrorKind::Input,
    ErrorKind::Gpu,
];

impl Failure {
    /// The failure of a rank by an error.
    pub fn new(rank: usize, ranks: usize, error: &Error) -> Failure {
        Failure {
            rank,
            ranks,
            everywhere: ranks == 1,
            kind: error.kind(),
            message: error.to_string(),
            help: error.help(),
        }
    }

    /// A rank ended or cannot be reached.
    pub fn lost(rank: usize, ranks: usize) -> Failure {
        Failure {
            rank,
            ranks,
            everywhere: ranks == 1,
            kind: ErrorKind::Failure,
            message: "the rank ended before the picture was complete".into(),
            help: None,
        }
    }

    /// The bytes in which ranks tell each other.
    pub(crate) fn encode(&self) -> Vec<u8> {
        let kind = KINDS.iter().position(|kind| *kind == self.kind);
        let mut bytes = vec![kind.unwrap_or(0) as u8];
        bytes.extend((self.message.len() as u32).to_le_bytes());
        bytes.extend(self.message.as_bytes());
        bytes.extend(self.help.iter().flat_map(|help| help.as_bytes()));
        bytes
    }

    /// The failure of `rank` in these bytes.
    pub(crate) fn decode(rank: usize, ranks: usize, bytes: &[u8]) -> Failure {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let length = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
        let (message, help) = bytes[5..].split_at(length as usize);
        Failure {
            rank,
            ranks,
            everywhere: ranks == 1,
            kind: KINDS[usize::from(bytes[0])],
            message: text(message),
            help: (!help.is_empty()).then(|| text(help)),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Failure {
            rank,
            ranks,
            message,
            ..
        } = self;
        match self.everywhere {
            true => write!(f, "{message}"),
            false => write!(f, "rank {rank} of {ranks}: {message}"),
        }
    }
}

impl std::error::Error for Failure {}
