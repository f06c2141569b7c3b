//! Files that are packed here, so that changes lie behind lengths, checksums and base64.

use arbitrary::Unstructured;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use tetrascope::core::Error;

use super::{Bench, unpacked};
use crate::pack::{Compressor, Part, Wrap, pack};
use crate::seeds::Seed;

const TYPES: [(&str, usize); 10] = [
    ("UInt8", 1),
    ("Int8", 1),
    ("Int16", 2),
    ("UInt16", 2),
    ("Int32", 4),
    ("UInt32", 4),
    ("Int64", 8),
    ("UInt64", 8),
    ("Float32", 4),
    ("Float64", 8),
];

/// How the arrays of a file are written.
struct Style {
    compressor: Option<Compressor>,
    wide: bool,
    big: bool,
    /// Inline, appended in base64, appended as they are.
    place: u8,
    block: usize,
    /// In the headers of compressed data: which word, and what it is.
    edits: Vec<(usize, u64)>,
}

impl Style {
    fn of(bytes: &mut Unstructured) -> Style {
        let options = byte(bytes);
        let edits = (0..byte(bytes) % 3).map(|_| {
            let word = usize::from(byte(bytes));
            let number = match byte(bytes) {
                0 => bytes.arbitrary().unwrap_or(u64::MAX),
                small @ 1..192 => u64::from(small - 1),
                large => u64::MAX >> (large - 192),
            };
            (word, number)
        });
        let edits = edits.collect();
        Style {
            compressor: match options & 3 {
                0 => None,
                1 => Some(Compressor::Lz4),
                _ => Some(Compressor::Zlib),
            },
            wide: options & 4 != 0,
            big: options & 8 != 0,
            place: options >> 4 & 3,
            block: 1 + usize::from(byte(bytes)),
            edits,
        }
    }

    fn attributes(&self) -> String {
        let compressor = match self.compressor {
            None => "",
            Some(Compressor::Lz4) => " compressor=\"vtkLZ4DataCompressor\"",
            Some(Compressor::Zlib) => " compressor=\"vtkZLibDataCompressor\"",
        };
        let header = if self.wide { "UInt64" } else { "UInt32" };
        let order = if self.big { "Big" } else { "Little" };
        format!("byte_order=\"{order}Endian\" header_type=\"{header}\"{compressor}")
    }

    /// Header and data, still apart, as base64 has them.
    fn array(&mut self, bytes: &[u8]) -> (Vec<u8>, Vec<u8>) {
        let (mut words, mut data) = (vec![bytes.len() as u64], bytes.to_vec());
        if let Some(compressor) = self.compressor {
            let blocks = bytes.chunks(self.block);
            let packed: Vec<Vec<u8>> = blocks.map(|block| compressor.pack(block)).collect();
            words = vec![
                packed.len() as u64,
                self.block as u64,
                (bytes.len() % self.block) as u64,
            ];
            words.extend(packed.iter().map(|block| block.len() as u64));
            data = packed.concat();
        }
        // Each edit is for the array in which its word lies, counted through all of them.
        for (word, number) in &mut self.edits {
            match words.get_mut(*word) {
                Some(place) => (*place, *word) = (*number, usize::MAX),
                None => *word = word.saturating_sub(words.len()),
            }
        }
        let header = words
            .into_iter()
            .flat_map(|word| match (self.wide, self.big) {
                (true, true) => word.to_be_bytes().to_vec(),
                (true, false) => word.to_le_bytes().to_vec(),
                (false, true) => (word as u32).to_be_bytes().to_vec(),
                (false, false) => (word as u32).to_le_bytes().to_vec(),
            });
        (header.collect(), data)
    }
}

fn byte(bytes: &mut Unstructured) -> u8 {
    bytes.arbitrary().unwrap_or(0)
}

/// A file's arrays so far.
struct File {
    style: Style,
    appended: Vec<u8>,
}

impl File {
    /// The element of an array of `numbers`, which the input may replace, and how many
    /// numbers it has.
    fn array(
        &mut self,
        bytes: &mut Unstructured,
        (name, components): (&str, u8),
        numbers: &[u8],
    ) -> (String, usize) {
        let (kind, size) = TYPES[usize::from(byte(bytes)) % TYPES.len()];
        let length = usize::from(byte(bytes));
        let own = bytes.bytes(length.min(bytes.len())).unwrap_or_default();
        let content: Vec<u8> = match own {
            [] => numbers.iter().flat_map(|n| self.number(kind, *n)).collect(),
            own => own.to_vec(),
        };
        let (header, data) = self.style.array(&content);
        let (format, inline) = match self.style.place {
            0 | 1 => {
                let text = BASE64.encode(header) + &BASE64.encode(data);
                ("format=\"binary\"".to_owned(), text)
            }
            2 => {
                let at = self.appended.len();
                let text = BASE64.encode(header) + &BASE64.encode(data);
                self.appended.extend(text.into_bytes());
                (
                    format!("format=\"appended\" offset=\"{at}\""),
                    String::new(),
                )
            }
            _ => {
                let at = self.appended.len();
                self.appended.extend(header);
                self.appended.extend(data);
                (
                    format!("format=\"appended\" offset=\"{at}\""),
                    String::new(),
                )
            }
        };
        let element = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             {format}>{inline}</DataArray>\n"
        );
        (element, content.len() / size)
    }

    fn number(&self, kind: &str, number: u8) -> Vec<u8> {
        let mut bytes = match kind {
            "UInt8" | "Int8" => vec![number],
            "Int16" | "UInt16" => u16::from(number).to_le_bytes().to_vec(),
            "Int32" | "UInt32" => u32::from(number).to_le_bytes().to_vec(),
            "Int64" | "UInt64" => u64::from(number).to_le_bytes().to_vec(),
            "Float32" => f32::from(number).to_le_bytes().to_vec(),
            _ => f64::from(number).to_le_bytes().to_vec(),
        };
        if self.style.big {
            bytes.reverse();
        }
        bytes
    }

    fn write(self, kind: &str, body: &str) -> Vec<u8> {
        let encoding = if self.style.place == 2 {
            "base64"
        } else {
            "raw"
        };
        let mut file = format!(
            "<VTKFile type=\"{kind}\" {}>\n{body}<AppendedData encoding=\"{encoding}\">_",
            self.style.attributes()
        )
        .into_bytes();
        file.extend(self.appended);
        file.extend(b"</AppendedData></VTKFile>\n");
        file
    }
}

/// A number that the input may replace.
fn or_edited(bytes: &mut Unstructured, number: u64) -> u64 {
    match byte(bytes) {
        0..250 => number,
        250..254 => u64::from(byte(bytes)),
        _ => bytes.arbitrary().unwrap_or(number),
    }
}

/// A `.vtu` file: a tetrahedron, as far as the input says nothing else.
pub(super) fn mesh(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let mut bytes = Unstructured::new(bytes);
    let style = Style::of(&mut bytes);
    let mut file = File {
        style,
        appended: Vec::new(),
    };
    let mut pieces = String::new();
    for _ in 0..1 + byte(&mut bytes) / 128 {
        let mut array =
            |name, components, numbers: &[u8]| file.array(&mut bytes, (name, components), numbers);
        let (position, coordinates) = array("Points", 3, &[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
        let (types, cells) = array("types", 1, &[10]);
        let (offsets, _) = array("offsets", 1, &[4]);
        let (connectivity, _) = array("connectivity", 1, &[0, 1, 2, 3]);
        let (field, _) = array("t", 1, &[0, 1, 2, 3]);
        let (other, _) = array("v", 3, &[1, 2, 3]);
        let points = or_edited(&mut bytes, coordinates as u64 / 3);
        let cells = or_edited(&mut bytes, cells as u64);
        pieces += &format!(
            "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\"><PointData>{field}\
             </PointData><CellData>{other}</CellData><Points>{position}</Points>\
             <Cells>{connectivity}{offsets}{types}</Cells></Piece>\n"
        );
    }
    let body = format!("<UnstructuredGrid>{pieces}</UnstructuredGrid>\n");
    bench.file("mesh.vtu", &file.write("UnstructuredGrid", &body))
}

/// A `.vti` file.
pub(super) fn image(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let mut bytes = Unstructured::new(bytes);
    let style = Style::of(&mut bytes);
    let mut file = File {
        style,
        appended: Vec::new(),
    };
    let sizes: [u8; 3] = [(); 3].map(|()| 1 + byte(&mut bytes) % 4);
    let [x, y, z] = sizes;
    let whole = format!("0 {x} 0 {y} 0 {z}");
    let samples: u8 = sizes.iter().map(|size| size + 1).product();
    let cells: u8 = sizes.iter().product();
    // One piece, or two that meet or overlap.
    let parts = match byte(&mut bytes) {
        0..128 => vec![(whole.clone(), samples, cells)],
        cut => {
            let at = cut % (z + 1);
            let layer = (x + 1) * (y + 1);
            vec![
                (format!("0 {x} 0 {y} 0 {at}"), layer * (at + 1), x * y * at),
                (
                    format!("0 {x} 0 {y} {at} {z}"),
                    layer * (z - at + 1),
                    x * y * (z - at),
                ),
            ]
        }
    };
    let hides = byte(&mut bytes) & 1 == 1;
    let mut pieces = String::new();
    for (extent, samples, cells) in parts {
        let ramp: Vec<u8> = (0..samples).collect();
        let (field, _) = file.array(&mut bytes, ("s", 1), &ramp);
        let (constant, _) = file.array(&mut bytes, ("c", 1), &ramp[..usize::from(cells)]);
        let marks = vec![0; usize::from(samples)];
        let (ghosts, _) = match hides {
            true => file.array(&mut bytes, ("vtkGhostType", 1), &marks),
            false => Default::default(),
        };
        pieces += &format!(
            "<Piece Extent=\"{extent}\"><PointData>{field}{ghosts}</PointData>\
             <CellData>{constant}</CellData></Piece>\n"
        );
    }
    let body = format!("<ImageData WholeExtent=\"{whole}\">{pieces}</ImageData>\n");
    bench.file("grid.vti", &file.write("ImageData", &body))
}

/// Styles of both VTK formats.
pub(super) fn mesh_seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![Vec::new()];
    for options in 0..64 {
        if options & 3 != 3 && options >> 4 != 1 {
            seeds.push(vec![options, 0, options]);
        }
    }
    seeds
}

/// A first byte for the format; one for how many bytes to cut from the packed end; then a
/// header, and samples that are packed.
pub(super) fn grid(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let [format, cut, rest @ ..] = bytes else {
        return Ok(());
    };
    let (name, end, wrap) = match format % 3 {
        0 => ("grid.nrrd", &b"\n\n"[..], Wrap::Gzip),
        1 => ("grid.mha", &b"LOCAL\n"[..], Wrap::Zlib),
        _ => ("grid.nii.gz", &b""[..], Wrap::Gzip),
    };
    let header = match end {
        [] => 0,
        end => {
            let found = rest.windows(end.len()).position(|window| window == end);
            found.map_or(0, |at| at + end.len())
        }
    };
    let (header, samples) = rest.split_at(header);
    let mut file = pack(&[Part::plain(header), Part::wrapped(samples, wrap)]);
    file.truncate(file.len() - usize::from(cut / 8).min(file.len()));
    bench.file(name, &file)
}

/// Packed files, unpacked.
pub(super) fn grid_seeds(nrrd: &[Seed]) -> Vec<Vec<u8>> {
    let own = |format: u8, seeds: &[Seed], word: &str| {
        let files = seeds.iter().map(|seed| unpacked(&seed.files[0].1));
        let files = files.filter(|file| file.windows(word.len()).any(|w| w == word.as_bytes()));
        let files = files.map(|file| [vec![format, 0], file].concat());
        files.collect::<Vec<_>>()
    };
    let mut all = own(0, nrrd, "gzip");
    all.extend(own(
        1,
        &crate::seeds::meta_images(),
        "CompressedData = True",
    ));
    all.extend(own(2, &crate::seeds::niftis(), "n+1"));
    all
}
