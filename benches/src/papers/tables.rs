//! The tables of each paper.

use super::{Column, Paper, Quantity, RESAMPLED, Row, Table};

fn column(name: &'static str, quantity: Quantity, function: &'static str) -> Column {
    Column {
        name,
        quantity,
        function,
    }
}

fn exact<const N: usize>(numbers: [f64; N]) -> Vec<(f64, f64)> {
    numbers.map(|number| (number, number)).to_vec()
}

pub(super) fn projection() -> Paper {
    let table = |name, about, hardware, layout, bytes, numbers: [[f64; 3]; 4]| {
        let data_sets = [
            ("Bluntfin, 224 874 cells (here 187 318)", "bluntfin"),
            ("Heat-sink, 121 668 cells (here 121 536)", "heat-sink"),
            ("Orbital, 148 955 cells", "orbital"),
            ("Sphere, 148 955 cells", "sphere"),
        ];
        let rows = data_sets.into_iter().zip(numbers);
        Table {
            name,
            about,
            hardware,
            note: "256×256 pixels here; the paper does not give its own.",
            columns: vec![
                column("frames/s", Quantity::Rate(1.0), layout),
                column("k cells/s", Quantity::KiloCells(1.0), layout),
                column("MB/s", Quantity::Megabytes(bytes), layout),
            ],
            rows: rows
                .map(|((name, mesh), numbers)| Row {
                    name: name.into(),
                    bench: Some(format!("projection/tables/{mesh}/")),
                    printed: exact(numbers),
                })
                .collect(),
        }
    };
    Paper {
        algorithm: "projection",
        name: "Weiler, Kraus, Ertl 2002",
        tables: vec![
            table(
                "table 1",
                "floats, 720 bytes per cell, unsorted",
                "GeForce3, 64 MB; Athlon 1200 MHz",
                "twelve-floats",
                720.0,
                [
                    [1.08, 242.0, 174.0],
                    [2.01, 244.0, 175.0],
                    [1.65, 245.0, 177.0],
                    [1.65, 245.0, 176.0],
                ],
            ),
            table(
                "table 2",
                "short values, 456 bytes per cell, unsorted",
                "GeForce3, 64 MB; Athlon 1200 MHz",
                "twelve-shorts",
                456.0,
                [
                    [1.67, 375.0, 167.0],
                    [3.02, 367.0, 163.0],
                    [2.53, 377.0, 168.0],
                    [2.53, 377.0, 168.0],
                ],
            ),
            table(
                "table 3",
                "short values, 456 bytes per cell, unsorted",
                "GeForce4 Ti, 128 MB; Athlon XP 1800+",
                "twelve-shorts",
                456.0,
                [
                    [2.13, 479.0, 213.0],
                    [3.81, 464.0, 207.0],
                    [3.23, 481.0, 214.0],
                    [3.23, 481.0, 214.0],
                ],
            ),
        ],
        note: "",
    }
}

/// Cameras of which `benches/raycast_peel.rs` sums the times.
const CAMERAS: f64 = 3.0;

const RADEON: &str = "Radeon 9700 Pro, 128 MB; Pentium IV 2.0 GHz";

pub(super) fn raycast() -> Paper {
    let rows = |numbers: [Vec<(f64, f64)>; 3]| {
        let data_sets = [
            ("spx1, 103K cells", "spx1"),
            ("blunt, 187K cells", "blunt"),
            (
                "f117, 240K cells, not at hand (here a sphere of as many)",
                "sphere",
            ),
        ];
        let rows = data_sets.into_iter().zip(numbers);
        rows.map(|((name, mesh), printed)| Row {
            name: name.into(),
            bench: Some(format!("raycast-peel/tables/{mesh}/")),
            printed,
        })
        .collect()
    };
    let times = |name, about, functions: [&'static str; 6], numbers| Table {
        name,
        about,
        hardware: RADEON,
        note: "The paper's are the least and greatest over cameras; ours the mean over three \
               cameras, of medians, at 256×256 pixels (the paper's tiles share 512×512).",
        columns: ["1x1", "2x2", "3x3", "4x4", "5x5", "6x6"]
            .into_iter()
            .zip(functions)
            .map(|(tiles, function)| column(tiles, Quantity::Milliseconds(CAMERAS), function))
            .collect(),
        rows: rows(numbers),
    };
    Paper {
        algorithm: "raycast-peel",
        name: "Bernardon, Pagot, Comba, Silva 2004",
        tables: vec![
            Table {
                name: "table 1",
                about: "frames and cells per second, least and greatest",
                hardware: RADEON,
                note: "The paper's are over cameras and tiles; ours over tiles and tables of the \
                       integral, mean over three cameras.",
                columns: vec![
                    column("frames/s", Quantity::Rate(CAMERAS), ""),
                    column("k cells/s", Quantity::KiloCells(CAMERAS), ""),
                ],
                rows: rows([
                    vec![(1.18, 1.68), (121.0, 173.0)],
                    vec![(2.13, 7.09), (398.0, 1320.0)],
                    vec![(1.36, 2.46), (326.0, 590.0)],
                ]),
            },
            Table {
                name: "table 2",
                about: "passes, least and greatest",
                hardware: RADEON,
                note: "The row of f117 repeats that of spx1 in the paper.",
                columns: vec![
                    column("two axes", Quantity::Counted, "table-2d-fixed/passes"),
                    column("three axes", Quantity::Counted, "table-3d/passes"),
                ],
                rows: rows([
                    vec![(571.0, 601.0), (561.0, 611.0)],
                    vec![(341.0, 439.0), (392.0, 542.0)],
                    vec![(571.0, 601.0), (561.0, 611.0)],
                ]),
            },
            times(
                "table 3",
                "milliseconds by tiles, a table with two axes",
                [
                    "table-2d-fixed/1x1",
                    "table-2d-fixed/2x2",
                    "table-2d-fixed/3x3",
                    "table-2d-fixed/4x4",
                    "table-2d-fixed/5x5",
                    "table-2d-fixed/6x6",
                ],
                [
                    vec![
                        (625.0, 812.0),
                        (625.0, 797.0),
                        (625.0, 797.0),
                        (609.0, 766.0),
                        (609.0, 750.0),
                        (594.0, 844.0),
                    ],
                    vec![
                        (203.0, 422.0),
                        (187.0, 391.0),
                        (172.0, 407.0),
                        (188.0, 406.0),
                        (141.0, 391.0),
                        (141.0, 469.0),
                    ],
                    vec![
                        (453.0, 734.0),
                        (422.0, 672.0),
                        (406.0, 641.0),
                        (406.0, 656.0),
                        (359.0, 640.0),
                        (406.0, 625.0),
                    ],
                ],
            ),
            times(
                "table 4",
                "milliseconds by tiles, a table with three axes",
                [
                    "table-3d/1x1",
                    "table-3d/2x2",
                    "table-3d/3x3",
                    "table-3d/4x4",
                    "table-3d/5x5",
                    "table-3d/6x6",
                ],
                [
                    vec![
                        (750.0, 921.0),
                        (750.0, 907.0),
                        (735.0, 906.0),
                        (734.0, 906.0),
                        (688.0, 907.0),
                        (718.0, 969.0),
                    ],
                    vec![
                        (390.0, 547.0),
                        (375.0, 547.0),
                        (375.0, 532.0),
                        (375.0, 515.0),
                        (344.0, 500.0),
                        (344.0, 562.0),
                    ],
                    vec![
                        (500.0, 812.0),
                        (484.0, 766.0),
                        (484.0, 734.0),
                        (469.0, 750.0),
                        (453.0, 719.0),
                        (500.0, 687.0),
                    ],
                ],
            ),
        ],
        note: "The mesh f117 is not at hand; a generated sphere of as many cells is measured in its place.",
    }
}

pub(super) fn resample() -> Paper {
    let rows = RESAMPLED.iter().map(|row| {
        let [x, y, z] = row.dims;
        let mesh = match row.mesh {
            "heat-sink" => "heat sink, 180K cells (here 121 536)",
            _ => "bluntfin, 225K cells (here 187 318)",
        };
        Row {
            name: format!("{mesh}, {x}x{y}x{z}"),
            bench: Some(format!("{}/", row.group())),
            printed: exact(row.seconds),
        }
    });
    Paper {
        algorithm: "resample",
        name: "Westermann 2001",
        tables: vec![Table {
            name: "figure 5",
            about: "seconds, by parts",
            hardware: "SGI Onyx IR2, one R12000 at 300 MHz, 64 MB of texture memory",
            note: "The list of active elements is the upload of the mesh here, and no 3D texture is \
                   built: samples are made where they are drawn.",
            columns: vec![
                column("Ael: list of elements", Quantity::Seconds, "list"),
                column("Rnd: rendering", Quantity::Seconds, "render"),
                column("ToR: reading back", Quantity::Seconds, "readback"),
                column("ToT: 3D texture", Quantity::Missing, ""),
            ],
            rows: rows.collect(),
        }],
        note: "Also in the paper, and not measured by a benchmark here: one arbitrary slice of the Blunt Fin in \
               0.18 s, and the heat sink drawn without a grid in 256 slices at 512×512 in 2.3 s on a GeForce2 GTS.",
    }
}

pub(super) fn slicing() -> Paper {
    let row = |name: &str, bench: &str, printed| Row {
        name: name.into(),
        bench: Some(format!("slicing/figure 5/{bench}/")),
        printed,
    };
    Paper {
        algorithm: "slicing",
        name: "Rezk Salama, Kolb 2005",
        tables: vec![Table {
            name: "figure 5, in words",
            about: "gain of frames per second by subdivision over none, shaded, percent",
            hardware: "GeForce6, 256 MB",
            note: "\"About 150% for the 16×16×8 and the 32×32×8 configuration\"; the angiography of 512×512×96 \
                   samples is not public. Ours has as many boxes along each axis.",
            columns: vec![
                column("16×16×8", Quantity::GainOver("1"), "16"),
                column("32×32×8", Quantity::GainOver("1"), "32"),
            ],
            rows: vec![
                row(
                    "angiography, 512×512×96, hides a third (here generated)",
                    "angiography/hides a third",
                    exact([150.0, 150.0]),
                ),
                row("the same, hides a half", "angiography/hides a half", vec![]),
                row(
                    "aneurism, 256³, hides a third",
                    "aneurism/hides a third",
                    vec![],
                ),
                row(
                    "aneurism, 256³, hides a half",
                    "aneurism/hides a half",
                    vec![],
                ),
            ],
        }],
        note: "Figures 4 and 5 are bar charts without numbers. Of figure 4 the text says that subdivision gains \
               nothing at low levels, and that the optimum is at 32×32×8.",
    }
}

pub(super) fn voxels() -> Paper {
    Paper {
        algorithm: "voxel-hw",
        name: "Prakash, Manohar 1995",
        tables: Vec::new(),
        note: "The paper prints no measurement: it draws a staircase of 23 cells and the Blunt Fin of 37 479 \
               hexahedra, in figures 3 to 6, and declines to estimate times. `cargo xtask figures` draws these \
               figures again, and `cargo xtask machine` simulates the proposed machine.",
    }
}
