use std::fs;

use super::*;
use crate::{ReadOptions, read_mesh};

/// How a test file is written.
#[derive(Clone, Copy, Debug)]
struct Style {
    big: bool,
    wide: bool,
    records: bool,
    multiple: bool,
    blanking: bool,
}

struct Writer {
    style: Style,
    file: Vec<u8>,
    record: Vec<u8>,
}

impl Writer {
    fn int(&mut self, value: i32) {
        self.record.extend(if self.style.big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        });
    }

    fn float(&mut self, value: f64) {
        match (self.style.wide, self.style.big) {
            (true, true) => self.record.extend(value.to_be_bytes()),
            (true, false) => self.record.extend(value.to_le_bytes()),
            (false, true) => self.record.extend((value as f32).to_be_bytes()),
            (false, false) => self.record.extend((value as f32).to_le_bytes()),
        }
    }

    fn end_record(&mut self) {
        let record = std::mem::take(&mut self.record);
        let length = record.len() as i32;
        let marker = if self.style.big {
            length.to_be_bytes()
        } else {
            length.to_le_bytes()
        };
        if self.style.records {
            self.file.extend(marker);
        }
        self.file.extend(record);
        if self.style.records {
            self.file.extend(marker);
        }
    }

    fn header(style: Style, blocks: &[[u32; 3]]) -> Writer {
        let mut writer = Writer {
            style,
            file: Vec::new(),
            record: Vec::new(),
        };
        if style.multiple {
            writer.int(blocks.len() as i32);
            writer.end_record();
        }
        for &d in blocks.iter().flatten() {
            writer.int(d as i32);
        }
        writer.end_record();
        writer
    }
}

/// x = i, y = 2 j, z = 4 k + 100 block; point 0 of the last block is blanked out.
fn grid(style: Style, blocks: &[[u32; 3]]) -> Vec<u8> {
    let mut writer = Writer::header(style, blocks);
    for (b, &[ni, nj, nk]) in blocks.iter().enumerate() {
        for axis in 0..3 {
            for k in 0..nk {
                for j in 0..nj {
                    for i in 0..ni {
                        let z = f64::from(4 * k) + 100.0 * b as f64;
                        writer.float([f64::from(i), f64::from(2 * j), z][axis]);
                    }
                }
            }
        }
        if style.blanking {
            for p in 0..ni * nj * nk {
                let blanked = p == 0 && b + 1 == blocks.len();
                writer.int(if blanked { 0 } else { -1 });
            }
        }
        writer.end_record();
    }
    writer.file
}

/// Q1 = 1 + point / 8, Q2…Q4 = Q1 (0, 3, 4), Q5 = 1000.
fn solution(style: Style, blocks: &[[u32; 3]]) -> Vec<u8> {
    let mut writer = Writer::header(style, blocks);
    for &dimensions in blocks {
        for value in [2.5, 0.0, 1e6, 7.0] {
            writer.float(value);
        }
        writer.end_record();
        for scale in [1.0, 0.0, 3.0, 4.0, 0.0] {
            for p in 0..points(dimensions) {
                let density = 1.0 + p as f64 / 8.0;
                writer.float(scale * density);
            }
        }
        // Q5, the last array, is not a multiple of the density.
        let size = if style.wide { 8 } else { 4 };
        let start = writer.record.len() - size * points(dimensions) as usize;
        writer.record.truncate(start);
        for _ in 0..points(dimensions) {
            writer.float(1000.0);
        }
        writer.end_record();
    }
    writer.file
}

fn styles() -> impl Iterator<Item = Style> {
    (0..32).map(|bits| Style {
        big: bits & 1 != 0,
        wide: bits & 2 != 0,
        records: bits & 4 != 0,
        multiple: bits & 8 != 0,
        blanking: bits & 16 != 0,
    })
}

fn read_pair(grid: &[u8], solution: &[u8]) -> Result<MeshData, Error> {
    let source = |name: &str, bytes: &[u8]| Source {
        path: name.into(),
        bytes: bytes.into(),
    };
    read_sources(
        &source("testxyz.bin", grid),
        Some(&source("testq.bin", solution)),
    )
}

#[test]
fn every_layout_is_detected() {
    for style in styles() {
        let blocks: &[[u32; 3]] = if style.multiple {
            &[[3, 4, 5], [2, 3, 2]]
        } else {
            &[[3, 4, 5]]
        };
        for trailing in [0, 484] {
            // With bytes left over a file could also hold IBLANK or wider
            // floats; zeros do not look like IBLANK, and records say where they end.
            let extend = |mut file: Vec<u8>| {
                file.extend(std::iter::repeat_n(0, trailing));
                file
            };
            if trailing > 0 && !style.records && !style.wide {
                continue; // 484 bytes are more than this small grid: ambiguous
            }
            let data = read_pair(
                &extend(grid(style, blocks)),
                &extend(solution(style, blocks)),
            )
            .unwrap_or_else(|error| panic!("{style:?}: {error}"));
            let cells = if style.multiple {
                2 * 3 * 4 + 2
            } else {
                2 * 3 * 4
            };
            let blanked = if style.blanking { 1 } else { 0 };
            assert_eq!(data.cells.types.len(), cells - blanked, "{style:?}");
            assert_eq!(data.points[3 * 4 + 3 + 1], DVec3::new(1.0, 2.0, 4.0));
            if style.multiple {
                assert_eq!(data.points[60 + 11], DVec3::new(1.0, 4.0, 104.0));
            }
            let field = |name: &str| data.field(Some(name)).expect("it is derived").values;
            assert_eq!(field("density")[8], 2.0);
            assert_eq!(field("momentum-z")[8], 8.0);
            assert_eq!(field("momentum-magnitude")[8], 10.0);
            assert_eq!(field("velocity-magnitude")[8], 5.0);
            assert_eq!(field("energy")[8], 1000.0);
            // p = 0.4 (1000 − 25) to the rounding of f64 (values are exact in f32).
            assert!((field("pressure")[8] - 390.0).abs() < 1e-12);
            assert!((field("temperature")[8] - 195.0).abs() < 1e-12);
            assert!((field("mach")[8] - 5.0 / (1.4_f64 * 195.0).sqrt()).abs() < 1e-14);
        }
    }
}

#[test]
fn hexahedra_are_in_vtk_order() {
    let style = Style {
        big: true,
        wide: false,
        records: false,
        multiple: false,
        blanking: false,
    };
    let blocks = [[2, 2, 2]];
    let data = read_pair(&grid(style, &blocks), &solution(style, &blocks)).expect("a cell");
    assert_eq!(data.cells.connectivity, [0, 1, 3, 2, 4, 5, 7, 6]);
    assert_eq!(data.cells.offsets, [0, 8]);
    assert_eq!(data.cells.types, [12]);
}

#[test]
fn blanked_cells_are_left_out_and_noted() {
    let style = Style {
        big: false,
        wide: false,
        records: false,
        multiple: false,
        blanking: true,
    };
    let blocks = [[3, 3, 3]];
    let data = read_pair(&grid(style, &blocks), &solution(style, &blocks)).expect("cells");
    assert_eq!(data.cells.types.len(), 7);
    assert!(
        data.notes
            .iter()
            .any(|n| n == "1 cell left out: they touch a point that IBLANK blanks out"),
        "{:?}",
        data.notes
    );
}

#[test]
fn every_truncation_is_an_error() {
    for style in styles() {
        let blocks = [[2, 3, 2], [2, 2, 2]];
        let blocks = if style.multiple {
            &blocks[..]
        } else {
            &blocks[..1]
        };
        let (grid, solution) = (grid(style, blocks), solution(style, blocks));
        for length in 0..grid.len() {
            match read_pair(&grid[..length], &solution) {
                Err(Error::Format { .. }) => {}
                // Without IBLANK a grid that had it is still a grid, and the
                // first half of a 64-bit file can be one of 32-bit floats.
                Ok(_) => assert!(style.blanking || style.wide, "{style:?} cut to {length}"),
                Err(error) => panic!("{style:?} cut to {length}: {error}"),
            }
        }
        for length in 0..solution.len() {
            let result = read_pair(&grid, &solution[..length]);
            assert!(result.is_err() || style.wide, "{style:?} cut to {length}");
        }
    }
}

#[test]
fn what_is_wrong_is_said_with_numbers() {
    let style = Style {
        big: true,
        wide: false,
        records: false,
        multiple: false,
        blanking: false,
    };
    let (good, q) = (grid(style, &[[3, 4, 5]]), solution(style, &[[3, 4, 5]]));
    let message = |grid: &[u8], solution: &[u8]| {
        read_pair(grid, solution)
            .expect_err("it is wrong")
            .to_string()
    };
    let cut = message(&good[..good.len() - 1], &q);
    assert!(
        cut.contains(
            "says 3×4×5 points (big-endian), which needs at least 732 bytes, but the file has 731"
        ),
        "{cut}"
    );
    let other = message(&good, &solution(style, &[[3, 5, 4]]));
    assert!(
        other.contains("the solution has 3×5×4 points, but the grid has 3×4×5 points"),
        "{other}"
    );
    let mut huge = good.clone();
    huge[..12].fill(0x7f);
    let huge = message(&huge, &q);
    assert!(huge.contains("byte 0"), "{huge}");
    let text = message(b"3 4 5\n 1.0 2.0 3.0\n", &q);
    assert!(text.contains("the file is text"), "{text}");
    let flat = message(&grid(style, &[[3, 4, 1]]), &solution(style, &[[3, 4, 1]]));
    assert!(flat.contains("has no cells"), "{flat}");
    let mut infinite = good.clone();
    infinite[12..16].copy_from_slice(&f32::INFINITY.to_be_bytes());
    let infinite = message(&infinite, &q);
    assert!(
        infinite.contains("its point 0 is at (inf, 0, 0)"),
        "{infinite}"
    );
}

#[test]
fn the_pair_is_found_from_either_file() {
    let style = Style {
        big: false,
        wide: true,
        records: true,
        multiple: true,
        blanking: false,
    };
    let blocks = [[2, 2, 3]];
    for (xyz, q) in [
        ("a.xyz", "a.q"),
        ("a.x", "a.q"),
        ("a.g", "a.Q"),
        ("bxyz.bin", "bq.bin"),
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (xyz, q) = (folder.path().join(xyz), folder.path().join(q));
        fs::write(&xyz, grid(style, &blocks)).expect("it is writable");
        let alone = read_mesh(&xyz, &ReadOptions::default()).expect("a grid without fields");
        assert!(alone.fields.is_empty());
        assert!(
            alone
                .notes
                .iter()
                .any(|n| n.starts_with("no solution file: there is no "))
        );
        fs::write(&q, solution(style, &blocks)).expect("it is writable");
        let read = |path: &Path| read_mesh(path, &ReadOptions::default()).expect("a pair");
        let (of_grid, of_solution) = (read(&xyz), read(&q));
        assert_eq!(of_grid.points, of_solution.points);
        assert_eq!(of_grid.cells, of_solution.cells);
        assert_eq!(of_grid.fields, of_solution.fields);
        assert_eq!(read(&xyz).fields.len(), 13);
        // Given by hand.
        let elsewhere = folder.path().join("elsewhere.dat");
        fs::rename(&q, &elsewhere).expect("it is writable");
        let options = ReadOptions {
            solution: Some(elsewhere.clone()),
            ..ReadOptions::default()
        };
        assert_eq!(read_mesh(&xyz, &options).expect("a pair").fields.len(), 13);
        // Without its grid.
        let lone = folder.path().join("lone.q");
        fs::rename(&elsewhere, &lone).expect("it is writable");
        let error = read_mesh(&lone, &ReadOptions::default()).expect_err("no grid");
        assert!(
            error.to_string().contains("this is a Plot3D solution"),
            "{error}"
        );
    }
}

#[test]
fn pressure_is_not_made_up() {
    let style = Style {
        big: true,
        wide: false,
        records: false,
        multiple: false,
        blanking: false,
    };
    let blocks = [[2, 2, 2]];
    let mut q = solution(style, &blocks);
    let energy = q.len() - 4 * 8;
    q[energy..].fill(0);
    let data = read_pair(&grid(style, &blocks), &q).expect("a cell");
    assert!(data.field(Some("pressure")).is_err());
    assert!(
        data.notes
            .iter()
            .any(|n| n.ends_with("the energy is 0 everywhere"))
    );
}

proptest::proptest! {
    #[test]
    fn no_header_panics(head in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..64),
                        small in proptest::collection::vec(0_u8..4, 0..64)) {
        // Half of the headers are small numbers, which come closer to being good.
        let style = Style { big: true, wide: false, records: false, multiple: false, blanking: false };
        let good = solution(style, &[[2, 2, 2]]);
        let words: Vec<u8> = small.iter().flat_map(|&b| [0, 0, 0, b]).collect();
        let _ = read_pair(&head, &good);
        let _ = read_pair(&words, &words);
    }
}
