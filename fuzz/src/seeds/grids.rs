//! Regular grids: `.vti`, MetaImage, NRRD, NIfTI, raw.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use tetrascope::core::grid::{ByteOrder, RawNumber};
use tetrascope::scene::VolumeSource;

use super::meshes::arrays;
use super::{Entry, Seed, bytes_of};
use crate::pack::{Compressor, Part, Wrap};

pub(super) const META_WORDS: &[&str] = &[
    "ObjectType = Image\n",
    "NDims = 3\n",
    "NDims = 2\n",
    "NDims = 4\n",
    "DimSize = 4 3 2\n",
    "DimSize = 2 2 2 2\n",
    "ElementSpacing = 1 1 1\n",
    "ElementSize = 1 2 3\n",
    "Offset = 0 0 0\n",
    "TransformMatrix = 0 1 0 1 0 0 0 0 1\n",
    "TransformMatrix = 0 0 0 0 0 0 0 0 0\n",
    "CenterOfRotation = 0 0 0\n",
    "AnatomicalOrientation = RAI\n",
    "BinaryData = False\n",
    "BinaryData = True\n",
    "BinaryDataByteOrderMSB = True\n",
    "CompressedData = True\n",
    "CompressedDataSize = 9\n",
    "HeaderSize = -1\n",
    "HeaderSize = 4\n",
    "ElementNumberOfChannels = 3\n",
    "MET_UCHAR",
    "MET_CHAR",
    "MET_SHORT",
    "MET_USHORT",
    "MET_INT",
    "MET_UINT",
    "MET_LONG_LONG",
    "MET_FLOAT",
    "MET_DOUBLE",
    "MET_UCHAR_ARRAY",
    "ElementDataFile = LOCAL\n",
    "ElementDataFile = grid.raw\n",
    "ElementDataFile = LIST\n",
    "ElementDataFile = LIST 2D\n",
    "ElementDataFile = s%02d.raw 1 2 1\n",
    " = ",
    "\n",
    "\r\n",
];

pub(super) const NRRD_WORDS: &[&str] = &[
    "NRRD0001\n",
    "NRRD0004\n",
    "NRRD0005\n",
    "type: uchar\n",
    "type: int8\n",
    "type: short\n",
    "type: uint16\n",
    "type: int\n",
    "type: uint64\n",
    "type: longlong\n",
    "type: float\n",
    "type: double\n",
    "type: block\n",
    "dimension: 2\n",
    "dimension: 3\n",
    "dimension: 4\n",
    "sizes: 4 3 2\n",
    "sizes: 3 4 3 2\n",
    "spacings: 1 1 2\n",
    "spacings: nan 1 1 1\n",
    "axis mins: 0 0 0\n",
    "space: left-posterior-superior\n",
    "space: RAS\n",
    "space: scanner-xyz-time\n",
    "space dimension: 3\n",
    "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
    "space directions: none (1,0,0) (0,1,0) (0,0,1)\n",
    "space origin: (0,0,0)\n",
    "kinds: domain domain domain\n",
    "kinds: vector domain domain domain\n",
    "kinds: RGB-color space space space\n",
    "kinds: space space space list\n",
    "centers: cell cell cell\n",
    "endian: little\n",
    "endian: big\n",
    "encoding: raw\n",
    "encoding: gzip\n",
    "encoding: ascii\n",
    "encoding: hex\n",
    "encoding: bzip2\n",
    "byte skip: -1\n",
    "byte skip: 4\n",
    "line skip: 1\n",
    "data file: grid.raw\n",
    "data file: LIST\n",
    "data file: LIST 2\n",
    "data file: s%d.raw 1 2 1\n",
    "content: a\n",
    "key:=value\n",
    "#\n",
    "\n",
    ": ",
    "none",
    "(",
    ")",
];

pub(super) fn vti() -> Vec<Seed> {
    const EXTENT: &str = "0 2 0 2 0 3";
    let file = |attributes: &str, image: &str, pieces: &str, tail: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt32\"{attributes}>\n\
             <ImageData WholeExtent=\"{EXTENT}\" Origin=\"0 0 -1\" Spacing=\"1 1 2\"{image}>\n\
             {pieces}</ImageData>\n{tail}</VTKFile>\n"
        )
    };
    let words = |count: usize| {
        let words: Vec<String> = (0..count).map(|i| (i * 7 % 31).to_string()).collect();
        words.join(" ")
    };
    let array = |kind: &str, name: &str, more: &str, format: &str, data: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{more} format=\"{format}\">{data}\
             </DataArray>\n"
        )
    };
    let ascii = file(
        "",
        " Direction=\"0 1 0 1 0 0 0 0 1\"",
        &format!(
            "<Piece Extent=\"{EXTENT}\"><PointData Scalars=\"s\">{}{}{}</PointData>\
             <CellData>{}</CellData></Piece>\n",
            array("Int16", "s", "", "ascii", &words(36)),
            array(
                "Float32",
                "v",
                " NumberOfComponents=\"3\"",
                "ascii",
                &words(108)
            ),
            array("UInt8", "vtkGhostType", "", "ascii", &"0 ".repeat(36)),
            array("Float64", "c", "", "ascii", &words(12)),
        ),
        "",
    );
    let pieces = file(
        "",
        "",
        &format!(
            "<Piece Extent=\"0 2 0 2 0 1\"><PointData>{}</PointData></Piece>\n\
             <Piece Extent=\"0 2 0 2 1 3\"><PointData>{}</PointData></Piece>\n",
            array("UInt8", "s", "", "ascii", &words(18)),
            array("UInt8", "s", "", "ascii", &words(27)),
        ),
        "",
    );
    // Base64 of a length and of zeros, which `arrays` cuts out again.
    let zeros = BASE64.encode([0; 40]);
    let inline = |attributes: &str| {
        file(
            attributes,
            "",
            &format!(
                "<Piece Extent=\"{EXTENT}\"><PointData>{}</PointData></Piece>\n",
                array("UInt8", "s", "", "binary", &zeros),
            ),
            "",
        )
    };
    let mut appended = file(
        "",
        "",
        &format!(
            "<Piece Extent=\"{EXTENT}\"><PointData>\
             <DataArray type=\"Float32\" Name=\"s\" format=\"appended\" offset=\"0\"/>\
             </PointData></Piece>\n"
        ),
        "<AppendedData encoding=\"raw\">_",
    )
    .into_bytes();
    appended.truncate(appended.len() - "</VTKFile>\n".len());
    appended.extend(144u32.to_le_bytes());
    appended.extend(bytes_of(36, |v| (v as f32).to_le_bytes()));
    appended.extend(b"</AppendedData></VTKFile>\n");
    // One block for 24 samples.
    let xz = include_bytes!("../../../crates/io/tests/fixtures/cells.xz");
    let header = [1, 24, 0, xz.len() as u32].map(u32::to_le_bytes).concat();
    let lzma = inline(" compressor=\"vtkLZMADataCompressor\"");
    let lzma = lzma.replace(EXTENT, "0 1 0 2 0 3");
    let lzma = lzma.replace(&zeros, &(BASE64.encode(header) + &BASE64.encode(xz)));
    let zlib = inline(" compressor=\"vtkZLibDataCompressor\"");
    let lz4 = inline(" compressor=\"vtkLZ4DataCompressor\"");
    vec![
        Seed::single("grid.vti", vec![Part::plain(ascii)]),
        Seed::single("grid.vti", vec![Part::plain(pieces)]),
        Seed::single("grid.vti", arrays(&inline(""), None)),
        Seed::single("grid.vti", arrays(&zlib, Some(Compressor::Zlib))),
        Seed::single("grid.vti", arrays(&lz4, Some(Compressor::Lz4))),
        Seed::single("grid.vti", vec![Part::plain(appended)]),
        Seed::single("grid.vti", vec![Part::plain(lzma)]),
    ]
}

pub(super) fn meta_image() -> Vec<Seed> {
    let head = |number: &str, more: &str, file: &str| {
        format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
             {more}TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\n\
             ElementSpacing = 1 1 2.5\nDimSize = 4 3 2\nElementType = {number}\n\
             ElementDataFile = {file}\n"
        )
    };
    let shorts = || bytes_of(24, |v| (v as i16).to_le_bytes());
    let text: String = (0..24).map(|i| format!("{} ", i * 5 % 17)).collect();
    vec![
        Seed::single(
            "grid.mha",
            vec![
                Part::plain(head("MET_SHORT", "", "LOCAL")),
                Part::plain(shorts()),
            ],
        ),
        Seed::single(
            "grid.mha",
            vec![
                Part::plain(head("MET_SHORT", "CompressedData = True\n", "LOCAL")),
                Part::wrapped(shorts(), Wrap::Zlib),
            ],
        ),
        Seed::single(
            "grid.mha",
            vec![
                Part::plain(
                    head("MET_UCHAR", "", "LOCAL")
                        .replace("BinaryData = True", "BinaryData = False"),
                ),
                Part::plain(text),
            ],
        ),
        Seed::of(vec![
            (
                "grid.mhd",
                vec![Part::plain(head(
                    "MET_FLOAT",
                    "ElementNumberOfChannels = 3\nHeaderSize = -1\n",
                    "grid.raw",
                ))],
            ),
            (
                "grid.raw",
                vec![Part::plain(bytes_of(72, |v| (v as f32).to_le_bytes()))],
            ),
        ]),
    ]
}

pub(super) fn nrrd() -> Vec<Seed> {
    let shorts = |count| bytes_of(count, |v| (v as i16).to_be_bytes());
    let attached =
        |head: &str, data: Part| Seed::single("grid.nrrd", vec![Part::plain(head), data]);
    let text: String = (0..24).map(|i| format!("{}\n", i * 5 % 17)).collect();
    vec![
        attached(
            "NRRD0004\n# comment\ntype: short\ndimension: 3\nspace: left-posterior-superior\n\
             sizes: 4 3 2\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nkinds: domain domain domain\n\
             endian: big\nencoding: raw\nspace origin: (0,-1,5)\n\n",
            Part::plain(shorts(24)),
        ),
        attached(
            "NRRD0005\ntype: int16\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 2\nendian: big\n\
             encoding: gzip\n\n",
            Part::wrapped(shorts(24), Wrap::Gzip),
        ),
        attached(
            "NRRD0001\ntype: float\ndimension: 3\nsizes: 4 3 2\nencoding: text\n\n",
            Part::plain(text),
        ),
        attached(
            "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 4 3 2\n\
             space directions: none (0,1,0) (1,0,0) (0,0,1)\nspace dimension: 3\n\
             kinds: RGB-color domain domain domain\nencoding: raw\nkey:=value\n\n",
            Part::plain(bytes_of(72, |v| [v as u8])),
        ),
        attached(
            "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 4 3 2 3\n\
             kinds: space space space list\nencoding: raw\n\n",
            Part::plain(bytes_of(72, |v| [v as u8])),
        ),
        Seed::of(vec![
            (
                "grid.nhdr",
                vec![Part::plain(
                    "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\
                     data file: s%d.raw 1 2 1\n",
                )],
            ),
            ("s1.raw", vec![Part::plain(bytes_of(12, |v| [v as u8]))]),
            ("s2.raw", vec![Part::plain(bytes_of(12, |v| [v as u8]))]),
        ]),
        Seed::of(vec![
            (
                "grid.nhdr",
                vec![Part::plain(
                    "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: gzip\n\
                     byte skip: 2\ndata file: LIST\ngrid.raw.gz\n",
                )],
            ),
            (
                "grid.raw.gz",
                vec![Part::wrapped(bytes_of(26, |v| [v as u8]), Wrap::Gzip)],
            ),
        ]),
    ]
}

/// 64 million samples of one value, compressed to some kilobytes.
pub(super) fn heavy_nrrd() -> Seed {
    let head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 400 400 400\nencoding: gzip\n\n";
    let samples = Part {
        zeros: 400 * 400 * 400 - 1,
        ..Part::wrapped([1], Wrap::Gzip)
    };
    Seed::single("grid.nrrd", vec![Part::plain(head), samples])
}

/// Which variant of a NIfTI file.
#[derive(Clone, Copy)]
struct Nifti {
    big: bool,
    /// Code of the samples' type.
    code: i16,
    bits: i16,
    frames: i16,
    sform: bool,
}

/// A header of 348 bytes, four of extension, and samples.
fn nifti_file(variant: Nifti, samples: Vec<u8>) -> Vec<u8> {
    let Nifti {
        big,
        code,
        bits,
        frames,
        sform,
    } = variant;
    let mut head = vec![0; 352];
    let mut put = |at: usize, little: &[u8]| {
        let place = &mut head[at..at + little.len()];
        place.copy_from_slice(little);
        if big {
            place.reverse();
        }
    };
    let rank: i16 = if frames > 1 { 4 } else { 3 };
    put(0, &348i32.to_le_bytes());
    for (i, size) in [rank, 4, 3, 2, frames, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &size.to_le_bytes());
    }
    put(70, &code.to_le_bytes());
    put(72, &bits.to_le_bytes());
    let mut floats = |at: usize, numbers: &[f32]| {
        for (i, number) in numbers.iter().enumerate() {
            put(at + 4 * i, &number.to_le_bytes());
        }
    };
    floats(76, &[1.0, 1.0, 2.0, 3.0]);
    floats(108, &[352.0, 0.5, 3.0]);
    if sform {
        let rows = [0.0, 2.0, 0.0, 9.0, 1.0, 0.0, 0.0, 8.0, 0.0, 0.0, 3.0, 7.0];
        floats(280, &rows);
        put(254, &1i16.to_le_bytes());
    } else {
        floats(256, &[0.0, 0.6, 0.0, 1.0, 2.0, 3.0]);
        put(252, &1i16.to_le_bytes());
    }
    head[344..348].copy_from_slice(b"n+1\0");
    head.extend(samples);
    head
}

pub(super) fn nifti() -> Vec<Seed> {
    let short = Nifti {
        big: false,
        code: 4,
        bits: 16,
        frames: 1,
        sform: false,
    };
    let frames = Nifti {
        code: 16,
        bits: 32,
        frames: 3,
        sform: true,
        ..short
    };
    let plain = nifti_file(short, bytes_of(24, |v| (v as i16).to_le_bytes()));
    let big = Nifti { big: true, ..short };
    let big = nifti_file(big, bytes_of(24, |v| (v as i16).to_be_bytes()));
    let frames = nifti_file(frames, bytes_of(72, |v| (v as f32).to_le_bytes()));
    vec![
        Seed::single("grid.nii", vec![Part::plain(plain.clone())]),
        Seed::single("grid.nii", vec![Part::plain(frames.clone())]),
        Seed::single("grid.nii", vec![Part::plain(big)]),
        Seed::single("grid.nii.gz", vec![Part::wrapped(plain, Wrap::Gzip)]),
        Seed::single("grid.nii.gz", vec![Part::wrapped(frames, Wrap::Gzip)]),
    ]
}

pub(super) fn raw() -> Vec<Seed> {
    RawNumber::ALL
        .into_iter()
        .map(|number| Seed {
            files: vec![(
                "grid.raw",
                vec![Part::plain(bytes_of(30, f64::to_be_bytes))],
            )],
            entry: Entry::Volume(Box::new(VolumeSource {
                dims: Some([2, 3, 5]),
                number: Some(number),
                offset: Some(4).filter(|_| number != RawNumber::F64),
                byte_order: Some(ByteOrder::Big),
                ..VolumeSource::default()
            })),
        })
        .collect()
}
