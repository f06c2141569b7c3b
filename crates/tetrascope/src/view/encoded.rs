//! A picture on its way to a page.

use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::json;
use tetrascope_core::{Error, Frame};
use tetrascope_io::image::encode_png_fast;

use super::renderers::Setup;

/// The use of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Drawn fast, while a hand moves and first of all afterwards.
    Quick,
    /// On the way to the complete one.
    Refining,
    /// The picture that `tetrascope render` draws of the scene.
    Complete,
    /// The complete picture's difference to the truth, in false colors.
    Difference,
}

/// A picture as a page gets it: the length of a header in JSON as 32 bits, little-endian, the
/// header, and a PNG file.
#[derive(Debug)]
pub struct Encoded {
    /// Counts pictures.
    pub id: u64,
    /// The version of its state.
    pub version: u64,
    /// Its use.
    pub kind: Kind,
    /// Pixels.
    pub size: [u32; 2],
    /// The message.
    pub bytes: Vec<u8>,
    /// The header, as in the message.
    pub header: serde_json::Value,
}

/// The texts that go with a picture.
pub(crate) struct Caption<'a> {
    pub(crate) id: u64,
    pub(crate) version: u64,
    pub(crate) kind: Kind,
    /// The size at which it is shown.
    pub(crate) full: [u32; 2],
    pub(crate) setup: &'a Setup,
    /// The client and the number of its input that led to this.
    pub(crate) input: Option<(u64, u64)>,
    /// Seconds from there until the picture was begun.
    pub(crate) waited: Duration,
    pub(crate) draw: Duration,
    pub(crate) adapter: Option<String>,
    /// More of the header.
    pub(crate) more: serde_json::Value,
}

impl Encoded {
    pub(crate) fn new(frame: &Frame, caption: Caption) -> Result<Encoded, Error> {
        let start = Instant::now();
        let png = encode_png_fast(frame)?;
        let encode = start.elapsed();
        let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
        let Setup {
            algorithm,
            settings,
        } = caption.setup;
        let size = [frame.width, frame.height];
        let (client, seq) = caption.input.unzip();
        let header = json!({
            "id": caption.id,
            "version": caption.version,
            "kind": caption.kind,
            "size": size,
            "full": caption.full,
            "client": client,
            "seq": seq,
            "algorithm": algorithm.name,
            "settings": settings.to_string(),
            "adapter": caption.adapter.filter(|_| algorithm.needs_gpu),
            "wait_ms": milliseconds(caption.waited),
            "draw_ms": milliseconds(caption.draw),
            "encode_ms": milliseconds(encode),
            "statistics": frame.stats,
            "more": caption.more,
        });
        let text = header.to_string();
        let mut bytes = Vec::with_capacity(4 + text.len() + png.len());
        bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
        bytes.extend_from_slice(&png);
        Ok(Encoded {
            id: caption.id,
            version: caption.version,
            kind: caption.kind,
            size,
            bytes,
            header,
        })
    }

    /// The PNG file.
    pub fn png(&self) -> &[u8] {
        let (length, rest) = self.bytes.split_at(4);
        let length = u32::from_le_bytes(length.try_into().expect("four bytes"));
        &rest[length as usize..]
    }
}
