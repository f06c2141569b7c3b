//! Arrays of the VTK XML files that we write: appended raw, little-endian, with headers of 64
//! bits, and compressed by zlib if that is asked for.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use flate2::write::ZlibEncoder;

/// How a file's numbers are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// Not at all: the numbers can be read from the file a few at a time.
    #[default]
    None,
    /// zlib, in blocks (`vtkZLibDataCompressor`).
    Zlib,
}

/// Bytes of a block before it is compressed: a multiple of every number's size, and large
/// beside the 8 bytes that a block takes in the header.
pub(crate) const BLOCK: usize = 1 << 18;

/// Digits that suffice for any offset.
const DIGITS: usize = 20;

/// A function that writes the bytes of an array.
type Content<'a> = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()> + 'a>;

/// A file's arrays, whose elements come first and whose bytes come last.
pub(crate) struct Appended<'a> {
    compression: Compression,
    /// Where an array's offset stands, how many bytes it has, and what writes them.
    arrays: Vec<(u64, u64, Content<'a>)>,
}

impl<'a> Appended<'a> {
    /// Begins a file of this type and version.
    pub(crate) fn begin(
        out: &mut impl Write,
        (kind, version): (&str, &str),
        compression: Compression,
    ) -> io::Result<Appended<'a>> {
        let compressor = match compression {
            Compression::None => "",
            Compression::Zlib => " compressor=\"vtkZLibDataCompressor\"",
        };
        writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
        writeln!(
            out,
            "<VTKFile type=\"{kind}\" version=\"{version}\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\"{compressor}>"
        )?;
        Ok(Appended {
            compression,
            arrays: Vec::new(),
        })
    }

    /// Writes the element of an array with these attributes; its `bytes` bytes come later.
    pub(crate) fn element(
        &mut self,
        out: &mut (impl Write + Seek),
        attributes: &str,
        bytes: u64,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> io::Result<()> {
        write!(out, "<DataArray {attributes} format=\"appended\" ")?;
        let place = out.stream_position()?;
        writeln!(out, "{}/>", " ".repeat("offset=\"\"".len() + DIGITS))?;
        self.arrays.push((place, bytes, Box::new(content)));
        Ok(())
    }

    /// Writes all arrays, whose offsets are known once those before them are compressed, and
    /// ends the file.
    pub(crate) fn finish<W: Write + Seek>(self, out: &mut BufWriter<W>) -> io::Result<()> {
        write!(out, "<AppendedData encoding=\"raw\">\n_")?;
        let start = out.stream_position()?;
        for (place, bytes, content) in self.arrays {
            let offset = out.stream_position()? - start;
            overwrite(out, place, format!("offset=\"{offset}\"").as_bytes())?;
            match self.compression {
                Compression::None => {
                    out.write_all(&bytes.to_le_bytes())?;
                    content(out)?;
                }
                Compression::Zlib => write_compressed(out, bytes, content)?,
            }
        }
        write!(out, "\n</AppendedData>\n</VTKFile>\n")
    }
}

/// Writes `bytes` at `place` and goes on behind what is there.
fn overwrite(out: &mut (impl Write + Seek), place: u64, bytes: &[u8]) -> io::Result<()> {
    let end = out.stream_position()?;
    out.seek(SeekFrom::Start(place))?;
    out.write_all(bytes)?;
    out.seek(SeekFrom::Start(end)).map(drop)
}

/// The number of blocks, their size, that of the last if it is shorter (else 0), how long each
/// is compressed, and the blocks (*VTK XML Formats*).
fn write_compressed(out: &mut (impl Write + Seek), bytes: u64, content: Content) -> io::Result<()> {
    let count = bytes.div_ceil(BLOCK as u64);
    for number in [count, BLOCK as u64, bytes % BLOCK as u64] {
        out.write_all(&number.to_le_bytes())?;
    }
    let sizes = out.stream_position()?;
    let room = vec![0; 8 * count as usize];
    out.write_all(&room)?;
    let mut blocks = Blocks {
        out: &mut *out,
        block: Vec::with_capacity(BLOCK),
        lengths: Vec::with_capacity(room.len()),
    };
    content(&mut blocks)?;
    blocks.flush()?;
    let lengths = blocks.lengths;
    overwrite(out, sizes, &lengths)
}

/// Compresses what is written to it, block by block.
struct Blocks<'a, W> {
    out: &'a mut W,
    /// The bytes of the block that is not full yet.
    block: Vec<u8>,
    /// How long each block has become, as a file has it.
    lengths: Vec<u8>,
}

impl<W: Write> Write for Blocks<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(BLOCK - self.block.len());
        self.block.extend_from_slice(&bytes[..taken]);
        if self.block.len() == BLOCK {
            self.flush()?;
        }
        Ok(taken)
    }

    /// Ends a block.
    fn flush(&mut self) -> io::Result<()> {
        if self.block.is_empty() {
            return Ok(());
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&self.block)?;
        self.block.clear();
        let packed = encoder.finish()?;
        self.lengths.extend((packed.len() as u64).to_le_bytes());
        self.out.write_all(&packed)
    }
}
