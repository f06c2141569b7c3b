//! Compressed arrays of many blocks.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::*;

/// How arrays are cut and written.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Bytes of a block.
    block: usize,
    lz4: bool,
    inline: bool,
}

/// VTK's default.
const VTK: Way = Way {
    block: 32 << 10,
    lz4: false,
    inline: false,
};

/// The cells of a mesh, of which number i has the points i to i + 3.
const CELLS: usize = 100_000;

fn connectivity() -> Vec<i64> {
    let cells = 0..CELLS as i64;
    cells.flat_map(|i| [i, i + 1, i + 2, i + 3]).collect()
}

/// The header of an array, and its blocks.
fn array(way: Way, bytes: &[u8], change: &dyn Fn(usize, &mut Vec<u8>)) -> [Vec<u8>; 2] {
    let mut blocks = Vec::new();
    for (number, block) in bytes.chunks(way.block).enumerate() {
        let mut compressed = match way.lz4 {
            true => lz4_flex::block::compress(block),
            false => {
                let fast = flate2::Compression::fast();
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), fast);
                encoder.write_all(block).expect("in memory");
                encoder.finish().expect("in memory")
            }
        };
        change(number, &mut compressed);
        blocks.push(compressed);
    }
    let mut header = vec![blocks.len(), way.block, bytes.len() % way.block];
    header.extend(blocks.iter().map(Vec::len));
    let words = header.into_iter().map(|n| (n as u32).to_le_bytes());
    [words.flatten().collect(), blocks.concat()]
}

/// Reads a mesh that was written in this way; `change` may damage blocks of the connectivity.
fn read(
    way: Way,
    connectivity: &[i64],
    change: &dyn Fn(usize, &mut Vec<u8>),
) -> Result<MeshData, Error> {
    let points = CELLS + 3;
    let long = |numbers: &[i64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let ends: Vec<i64> = (1..=CELLS as i64).map(|cell| 4 * cell).collect();
    let numbers = |count: usize| (0..count).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let arrays: [(_, _, _, Vec<u8>); 5] = [
        ("t", "Float32", "1", numbers(points)),
        ("Points", "Float32", "3", numbers(3 * points)),
        ("types", "UInt8", "1", vec![10; CELLS]),
        ("offsets", "Int64", "1", long(&ends)),
        ("connectivity", "Int64", "1", long(connectivity)),
    ];
    let mut data = Vec::new();
    let elements = arrays.map(|(name, kind, components, bytes)| {
        let same = |_: usize, _: &mut Vec<u8>| {};
        let is_changed = name == "connectivity";
        let parts = array(way, &bytes, if is_changed { change } else { &same });
        let (place, text) = match way.inline {
            true => ("binary".into(), parts.each_ref().map(|part| STANDARD.encode(part)).concat()),
            false => (format!("appended\" offset=\"{}", data.len()), String::new()),
        };
        if !way.inline {
            data.extend(parts.concat());
        }
        format!(
            r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="{place}">{text}</DataArray>"#
        )
    });
    let [field, position, types, offsets, indices] = elements;
    let compressor = if way.lz4 { "LZ4" } else { "ZLib" };
    let text = format!(
        r#"<VTKFile type="UnstructuredGrid" compressor="vtk{compressor}DataCompressor" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="{points}" NumberOfCells="{CELLS}"><PointData>{field}</PointData>
<Points>{position}</Points><Cells>{types}{offsets}{indices}</Cells></Piece></UnstructuredGrid>
<AppendedData encoding="raw">_"#
    );
    let mut bytes = text.into_bytes();
    bytes.extend(data);
    read_bytes("a.vtu", bytes)
}

/// As [`read`], by so many threads; the error's line.
fn error(threads: usize, connectivity: &[i64], change: fn(usize, &mut Vec<u8>)) -> String {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().expect("threads");
    let read = pool.install(|| read(VTK, connectivity, &change));
    read.expect_err("damaged").to_string()
}

#[test]
fn blocks_of_any_size_are_joined() {
    let expected: Vec<u64> = connectivity().iter().map(|&point| point as u64).collect();
    for (block, lz4, inline) in [
        (32 << 10, false, false),
        (32 << 10, true, true),
        (32 << 10, false, true),
        // Numbers lie in two blocks.
        (4099, false, false),
        // Too large for several at a time, but for the last.
        (300_000, false, false),
        (300_000, true, false),
        (1 << 24, false, true),
    ] {
        let way = Way { block, lz4, inline };
        let data = read(way, &connectivity(), &|_, _| {}).expect("it is whole");
        assert!(data.cells.connectivity == expected, "{way:?}");
        assert_eq!(data.cells.types, vec![10; CELLS]);
        assert_eq!(data.points[777].to_array(), [2331.0, 2332.0, 2333.0]);
        let values = data.scalars(0).expect("it is whole").values;
        assert!(
            values
                .iter()
                .zip(0..)
                .all(|(&value, i)| value == f64::from(i))
        );
    }
}

/// A block of so many zeros.
fn zeros(count: usize) -> Vec<u8> {
    let way = Way {
        block: 1 << 20,
        ..VTK
    };
    let [_, block] = array(way, &vec![0; count], &|_, _| {});
    block
}

#[test]
fn the_first_broken_block_is_named_by_any_number_of_threads() {
    let changes: [fn(usize, &mut Vec<u8>); 4] = [
        |number, block| {
            if [40, 41, 70].contains(&number) {
                block.truncate(9);
            }
        },
        // The checksum.
        |number, block| {
            if number == 40 {
                *block.last_mut().expect("it ends") ^= 1;
            }
        },
        // A byte too many, and one too few.
        |number, block| {
            if number == 40 {
                *block = zeros((32 << 10) + 1);
            }
        },
        |number, block| {
            if number == 40 {
                *block = zeros((32 << 10) - 1);
            }
        },
    ];
    for threads in [1, 2, 5] {
        for change in changes {
            let line = error(threads, &connectivity(), change);
            let words = "compressed block 40 is damaged or does not hold 32768 bytes, in a.vtu at array 'connectivity'";
            assert!(line.contains(words), "{line}");
        }
    }
}

#[test]
fn what_is_wrong_first_is_said() {
    let broken = |number, block: &mut Vec<u8>| {
        if number == 20 {
            block.clear();
        }
    };
    // 4096 numbers are in a block. Before the broken one:
    let mut before = connectivity();
    before[80_000] = -5;
    before[80_001] = 1 << 40;
    let line = error(2, &before, broken);
    assert!(line.contains("value 80000 is -5"), "{line}");
    before[70_000] = 1 << 40;
    let line = error(2, &before, broken);
    assert!(
        line.contains("value 70000 is point 1099511627776"),
        "{line}"
    );
    // Behind it:
    let mut behind = connectivity();
    behind[90_000] = -5;
    let line = error(2, &behind, broken);
    assert!(line.contains("block 20 is damaged"), "{line}");
}
