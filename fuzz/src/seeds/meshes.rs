//! Meshes: VTK XML behind compressions, legacy VTK, Plot3D.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use super::{Seed, fixture_folder};
use crate::pack::{Compressor, Part, Wrap};

pub(super) const XML_WORDS: &[&str] = &[
    "<VTKFile",
    "</VTKFile>",
    "UnstructuredGrid",
    "ImageData",
    "<Piece",
    "</Piece>",
    "NumberOfPoints",
    "NumberOfCells",
    "WholeExtent",
    "Extent",
    "Spacing",
    "Origin",
    "Direction",
    "<PointData>",
    "</PointData>",
    "<CellData>",
    "</CellData>",
    "<Points>",
    "</Points>",
    "<Cells>",
    "</Cells>",
    "<DataArray",
    "</DataArray>",
    "<AppendedData",
    "</AppendedData>",
    "Float32",
    "Float64",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
    "String",
    "ascii",
    "binary",
    "appended",
    "raw",
    "base64",
    "offset=\"0\"",
    "NumberOfComponents=\"3\"",
    "ComponentName0=\"a\"",
    "NumberOfTuples",
    "connectivity",
    "offsets",
    "types",
    "faces",
    "faceoffsets",
    "vtkGhostType",
    "vtkGhostLevels",
    "Scalars=",
    "Vectors=",
    "byte_order",
    "LittleEndian",
    "BigEndian",
    "header_type",
    "compressor=\"vtkZLibDataCompressor\"",
    "vtkLZ4DataCompressor",
    "vtkLZMADataCompressor",
    "TimeStep=\"1\"",
    "&lt;",
    "&#0;",
    "&#x1b;",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
    "_",
    "/>",
    "\"",
    "=",
];

pub(super) const LEGACY_WORDS: &[&str] = &[
    "# vtk DataFile Version 1.0",
    "# vtk DataFile Version 2.0",
    "# vtk DataFile Version 3.0",
    "# vtk DataFile Version 4.2",
    "# vtk DataFile Version 5.1",
    "ASCII\n",
    "BINARY\n",
    "DATASET ",
    "UNSTRUCTURED_GRID\n",
    "STRUCTURED_GRID\n",
    "STRUCTURED_POINTS\n",
    "RECTILINEAR_GRID\n",
    "POLYDATA\n",
    "POINTS ",
    "CELLS ",
    "CELL_TYPES ",
    "OFFSETS ",
    "CONNECTIVITY ",
    "DIMENSIONS ",
    "SPACING ",
    "ASPECT_RATIO ",
    "ORIGIN ",
    "POINT_DATA ",
    "CELL_DATA ",
    "SCALARS ",
    "VECTORS ",
    "NORMALS ",
    "TENSORS ",
    "TENSORS6 ",
    "COLOR_SCALARS ",
    "LOOKUP_TABLE default\n",
    "LOOKUP_TABLE ",
    "TEXTURE_COORDINATES ",
    "GLOBAL_IDS ",
    "PEDIGREE_IDS ",
    "FIELD FieldData ",
    "METADATA\n",
    "INFORMATION ",
    "NAME ",
    "DATA ",
    "COMPONENT_NAMES\n",
    "EDGE_FLAGS ",
    " float\n",
    " double\n",
    " int\n",
    " long\n",
    " vtktypeint64\n",
    " vtkIdType\n",
    " char\n",
    " unsigned_char\n",
    " bit\n",
    " string\n",
    " variant\n",
    "BLANKING ",
    "\n",
    "\n\n",
    "\r\n",
    " ",
];

/// An uncompressed fixture whose arrays are packed anew: as they are, by zlib and by LZ4.
pub(super) fn packed_vtu() -> std::io::Result<Vec<Seed>> {
    let text = std::fs::read_to_string(fixture_folder().join("lattice-inline-none-32.vtu"))?;
    let packed = |compressor: Option<(Compressor, &str)>| {
        let mut text = text.clone();
        if let Some((_, name)) = compressor {
            text = text.replacen(
                "header_type",
                &format!("compressor=\"{name}\" header_type"),
                1,
            );
        }
        Seed::single("mesh.vtu", arrays(&text, compressor.map(|(c, _)| c)))
    };
    Ok(vec![
        packed(None),
        packed(Some((Compressor::Zlib, "vtkZLibDataCompressor"))),
        packed(Some((Compressor::Lz4, "vtkLZ4DataCompressor"))),
    ])
}

/// One tetrahedron and millions of points that no cell uses, compressed to some kilobytes.
pub(super) fn heavy_vtu() -> Vec<Seed> {
    const POINTS: usize = 6_000_000;
    let head = |compressor: &str| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt32\" compressor=\"{compressor}\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{POINTS}\" NumberOfCells=\"1\">\n<Points>\
             <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"binary\">"
        )
    };
    let field = "</DataArray></Points>\n<PointData>\
        <DataArray type=\"Float32\" Name=\"s\" format=\"binary\">";
    let tail = "</DataArray></PointData>\n<Cells>\
        <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
        <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>\
        <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray>\
        </Cells>\n</Piece></UnstructuredGrid></VTKFile>\n";
    let corners = [
        [0.0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let bytes = |numbers: &[f32]| -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    };
    let seed = |(compressor, name): (Compressor, &str)| {
        let array = |first: Vec<u8>, numbers: usize| Part {
            zeros: 4 * numbers - first.len(),
            ..Part::wrapped(
                first,
                Wrap::Vtk {
                    compressor: Some(compressor),
                    edit: None,
                },
            )
        };
        let parts = vec![
            Part::plain(head(name)),
            array(bytes(corners.as_flattened()), 3 * POINTS),
            Part::plain(field),
            array(bytes(&[1.0, 2.0, 3.0, 4.0]), POINTS),
            Part::plain(tail),
        ];
        Seed::single("mesh.vtu", parts)
    };
    [
        (Compressor::Zlib, "vtkZLibDataCompressor"),
        (Compressor::Lz4, "vtkLZ4DataCompressor"),
    ]
    .map(seed)
    .into()
}

/// Cuts inline arrays out of a file: every text between tags that is base64.
pub(super) fn arrays(text: &str, compressor: Option<Compressor>) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut plain = String::new();
    for (i, piece) in text.split_inclusive(['<', '>']).enumerate() {
        let word = piece.trim_end_matches('<').trim();
        let data = BASE64.decode(word).ok().filter(|data| data.len() > 4);
        match data {
            Some(data) if i > 0 => {
                parts.push(Part::plain(std::mem::take(&mut plain)));
                let wrap = Wrap::Vtk {
                    compressor,
                    edit: None,
                };
                parts.push(Part::wrapped(&data[4..], wrap));
                plain.push('<');
            }
            _ => plain += piece,
        }
    }
    parts.push(Part::plain(plain));
    parts
}

const POINTS: &str = "POINTS 8 float\n0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1\n";

pub(super) fn legacy() -> Vec<Seed> {
    let text = |version: &str, rest: &str| {
        let head = format!("# vtk DataFile Version {version}\ntitle\nASCII\n");
        Seed::single("mesh.vtk", vec![Part::plain(head + rest)])
    };
    let unstructured = format!(
        "DATASET UNSTRUCTURED_GRID\n{POINTS}\
         CELLS 2 14\n8 0 1 3 2 4 5 7 6\n4 0 1 2 4\nCELL_TYPES 2\n12\n10\n\
         CELL_DATA 2\nSCALARS c int 1\nLOOKUP_TABLE mine\n1 2\nLOOKUP_TABLE mine 2\n\
         0 0 0 1\n1 1 1 1\n\
         POINT_DATA 8\nSCALARS s float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n\
         VECTORS v double\n0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1\n\
         COLOR_SCALARS rgb 3\n0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1\n\
         FIELD more 2\nt 1 8 double\n0 1 2 3 4 5 6 7\n\
         METADATA\nCOMPONENT_NAMES\nt%20one\n\nu 2 8 int\n0 1 2 3 4 5 6 7 0 1 2 3 4 5 6 7\n"
    );
    let structured = format!(
        "DATASET STRUCTURED_GRID\nDIMENSIONS 2 2 2\n{POINTS}POINT_DATA 8\nSCALARS s short\n\
         LOOKUP_TABLE default\n0 1 2 3 4 5 6 7\nCELL_DATA 1\nSCALARS c float\n\
         LOOKUP_TABLE default\n5\n"
    );
    let image = "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\nSPACING 1 1 2\nORIGIN 0 0 -1\n\
        POINT_DATA 27\nSCALARS s unsigned_char\nLOOKUP_TABLE default\n\
        0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26\n\
        CELL_DATA 8\nFIELD f 1\nc 1 8 float\n1 2 3 4 5 6 7 8\n";
    let mut binary = b"# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\n\
        DIMENSIONS 3 4 5\nASPECT_RATIO 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 60\n\
        SCALARS s short 1\nLOOKUP_TABLE default\n"
        .to_vec();
    binary.extend(super::bytes_of(60, |v| (v as i16).to_be_bytes()));
    // No points, and one layer of them: no cells.
    let nothing = "DATASET STRUCTURED_GRID\nDIMENSIONS 0 0 0\nPOINTS 0 float\n";
    let flat = "DATASET STRUCTURED_GRID\nDIMENSIONS 3 1 1\nPOINTS 3 float\n0 0 0 1 0 0 2 0 0\n\
        POINT_DATA 3\nSCALARS s float\nLOOKUP_TABLE default\n0 1 2\n";
    let empty = "DATASET UNSTRUCTURED_GRID\nPOINTS 0 float\nCELLS 0 0\nCELL_TYPES 0\n\
        POINT_DATA 0\nSCALARS s float\nLOOKUP_TABLE default\n";
    vec![
        text("3.0", nothing),
        text("3.0", flat),
        text("4.2", empty),
        text("1.0", &structured),
        text("2.0", &unstructured),
        text("3.0", &unstructured),
        text("3.0", image),
        Seed::single("mesh.vtk", vec![Part::plain(binary)]),
    ]
}

/// How a Plot3D file is written.
#[derive(Clone, Copy)]
struct Style {
    big: bool,
    wide: bool,
    records: bool,
    multiple: bool,
    blanking: bool,
}

impl Style {
    fn int(self, value: i32) -> Vec<u8> {
        match self.big {
            true => value.to_be_bytes().to_vec(),
            false => value.to_le_bytes().to_vec(),
        }
    }

    fn float(self, value: f64) -> Vec<u8> {
        let mut bytes = match self.wide {
            true => value.to_le_bytes().to_vec(),
            false => (value as f32).to_le_bytes().to_vec(),
        };
        if self.big {
            bytes.reverse();
        }
        bytes
    }

    fn record(self, content: Vec<u8>) -> Vec<u8> {
        match self.records {
            true => {
                let marker = self.int(content.len() as i32);
                [marker.clone(), content, marker].concat()
            }
            false => content,
        }
    }

    fn header(self, blocks: &[[i32; 3]]) -> Vec<u8> {
        let mut file = Vec::new();
        if self.multiple {
            file = self.record(self.int(blocks.len() as i32));
        }
        let dims = blocks.iter().flatten().flat_map(|n| self.int(*n));
        file.extend(self.record(dims.collect()));
        file
    }

    fn grid(self, blocks: &[[i32; 3]]) -> Vec<u8> {
        let mut file = self.header(blocks);
        for (b, &[ni, nj, nk]) in blocks.iter().enumerate() {
            let mut block = Vec::new();
            for axis in 0..3 {
                for point in 0..ni * nj * nk {
                    let place = [point % ni, point / ni % nj, point / ni / nj + 9 * b as i32];
                    block.extend(self.float(place[axis].into()));
                }
            }
            if self.blanking {
                block.extend((0..ni * nj * nk).flat_map(|_| self.int(1)));
            }
            file.extend(self.record(block));
        }
        file
    }

    fn solution(self, blocks: &[[i32; 3]]) -> Vec<u8> {
        let mut file = self.header(blocks);
        for &[ni, nj, nk] in blocks {
            let conditions = [0.5, 0.0, 1000.0, 0.0].into_iter();
            file.extend(self.record(conditions.flat_map(|v| self.float(v)).collect()));
            let values = (0..5 * ni * nj * nk).map(|i| 1.0 + f64::from(i % 17));
            file.extend(self.record(values.flat_map(|v| self.float(v)).collect()));
        }
        file
    }
}

pub(super) fn plot3d() -> Vec<Seed> {
    let plain = Style {
        big: false,
        wide: false,
        records: false,
        multiple: false,
        blanking: false,
    };
    let several = Style {
        multiple: true,
        ..plain
    };
    let styles = [
        (plain, 1),
        (Style { big: true, ..plain }, 1),
        (
            Style {
                wide: true,
                ..plain
            },
            1,
        ),
        (several, 2),
        (
            Style {
                blanking: true,
                ..several
            },
            2,
        ),
        (
            Style {
                records: true,
                ..plain
            },
            1,
        ),
        (
            Style {
                big: true,
                wide: true,
                records: true,
                blanking: true,
                ..several
            },
            2,
        ),
    ];
    let seed = |(style, count): (Style, usize)| {
        let blocks = &[[3, 3, 2], [2, 4, 2]][..count];
        Seed::of(vec![
            ("meshxyz.bin", vec![Part::plain(style.grid(blocks))]),
            ("meshq.bin", vec![Part::plain(style.solution(blocks))]),
        ])
    };
    styles.map(seed).into()
}
