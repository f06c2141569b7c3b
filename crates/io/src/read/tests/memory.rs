//! Files that say more than they hold.

use std::io::Write as _;

use super::*;
use crate::pieces;

/// The bytes of a compressed array in one block.
fn zlib(values: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(values).expect("in memory");
    let packed = encoder.finish().expect("in memory");
    let header = [1, values.len() as u32, 0, packed.len() as u32];
    let mut bytes: Vec<u8> = header.into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(packed);
    bytes
}

/// A file whose cells have the types `cells`, with all arrays compressed.
fn packed(points: u32, cells: &[u8], ends: &[u8], connectivity: &[u8]) -> Vec<u8> {
    let arrays = [
        ("Points", "UInt8", "3", zlib(&vec![0; 3 * points as usize])),
        ("types", "UInt8", "1", zlib(cells)),
        ("offsets", "UInt32", "1", zlib(ends)),
        ("connectivity", "UInt32", "1", zlib(connectivity)),
        ("t", "UInt8", "1", zlib(&vec![7; points as usize])),
    ];
    let (mut elements, mut data) = (Vec::new(), Vec::new());
    for (name, kind, components, bytes) in arrays {
        elements.push(format!(
            r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="appended" offset="{}"/>"#,
            data.len()
        ));
        data.extend(bytes);
    }
    let [position, types, offsets, indices, field] = &elements[..] else {
        unreachable!("five");
    };
    let mut bytes = format!(
        r#"<VTKFile type="UnstructuredGrid" compressor="vtkZLibDataCompressor" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="{points}" NumberOfCells="{}"><PointData>{field}</PointData>
<Points>{position}</Points><Cells>{types}{offsets}{indices}</Cells></Piece></UnstructuredGrid>
<AppendedData encoding="raw">_"#,
        cells.len()
    )
    .into_bytes();
    bytes.extend(data);
    bytes
}

fn words(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

#[test]
fn points_that_no_cell_uses_take_no_memory() {
    // 4 million points would take 96 MB, and 32 MB and 32 times the file is the bound.
    let count = 4_000_000;
    let corners = [5, 1_000_000, 2_000_000, 3_999_999];
    let bytes = packed(count, &[10], &words(&[4]), &words(&corners));
    assert!(bytes.len() < 40_000, "{} bytes", bytes.len());
    let data = read_bytes("a.vtu", bytes).expect("it is a mesh");
    assert_eq!(data.points.len(), 4);
    assert!(data.points.capacity() <= 4);
    assert_eq!(data.cells.connectivity, [0, 1, 2, 3]);
    assert_eq!(values(&data, "t"), [7.0; 4]);
    assert_eq!(data.notes, ["3999996 points left out: no cell uses them"]);
}

#[test]
fn the_kept_points_have_their_own_values() {
    // Few enough to be kept whole, for comparison; then the same with the unused left out.
    let text = |points: &str| {
        TRAPS
            .replace("NumberOfPoints=\"4\"", "NumberOfPoints=\"6\"")
            .replace(">0 1 2 3<", ">4 1 2 3<")
            .replace("0 1 nan 3", "0 1 2 3 4 5")
            .replace("0 0 0 1 0 0 0 1 0 0 0 1", points)
    };
    let data = read_bytes("a.vtu", text("9 9 9 1 0 0 0 1 0 0 0 1 0 0 0 8 8 8").into())
        .expect("it is a mesh");
    assert_eq!(data.points.len(), 6);
    assert_eq!(values(&data, "scalar"), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let kept = pieces::kept_numbers(data.arrays[0].numbers.clone(), 1, &[1, 2, 4].into());
    let mut numbers = Vec::new();
    kept.each(&mut |v| numbers.push(v)).expect("in memory");
    assert_eq!(numbers, [1.0, 2.0, 4.0]);
    let pairs = pieces::kept_numbers(data.arrays[0].numbers.clone(), 2, &[0, 2].into());
    let mut numbers = Vec::new();
    pairs.each(&mut |v| numbers.push(v)).expect("in memory");
    assert_eq!(numbers, [0.0, 1.0, 4.0, 5.0]);
}

#[test]
fn cells_that_repeat_each_other_thousands_of_times_are_refused() {
    let corners = |count: usize| words(&[0, 1, 2, 3].repeat(count));
    // A polyvertex of 4 million points: 32 MB, all there is for a small file without it.
    let bytes = packed(4, &[2], &words(&[4_000_000]), &corners(1_000_000));
    assert!(bytes.len() < 60_000, "{} bytes", bytes.len());
    assert!(read_bytes("a.vtu", bytes).is_ok());
    let bytes = packed(4, &[2], &words(&[8_000_000]), &corners(2_000_000));
    let error = read_bytes("a.vtu", bytes)
        .expect_err("too many")
        .to_string();
    let words = "1 cell with 8000000 points: so many different ones cannot be in";
    assert!(error.contains(words), "{error}");
}
