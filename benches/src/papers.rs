//! What the papers print of their own measurements, and which benchmarks measure the same here.
//!
//! Numbers are as printed, with the paper's units; nothing is read off a diagram.

/// A paper.
#[derive(Clone, Debug)]
pub struct Paper {
    /// The algorithm's name in the registry.
    pub algorithm: &'static str,
    /// Authors and year.
    pub name: &'static str,
    /// Tables and figures with numbers.
    pub tables: Vec<Table>,
    /// What the paper does not print, and what stands for it.
    pub note: &'static str,
}

/// A table, or the numbers of a figure.
#[derive(Clone, Debug)]
pub struct Table {
    /// "table 1".
    pub name: &'static str,
    /// The caption in few words.
    pub about: &'static str,
    /// The paper's hardware.
    pub hardware: &'static str,
    /// What differs here.
    pub note: &'static str,
    /// One for each number of a row.
    pub columns: Vec<Column>,
    /// One for each data set.
    pub rows: Vec<Row>,
}

/// One kind of numbers.
#[derive(Clone, Debug)]
pub struct Column {
    /// The head, with the unit.
    pub name: &'static str,
    /// How criterion's time becomes such a number.
    pub quantity: Quantity,
    /// What follows a row's [`Row::bench`] in a benchmark's id, after the size: "twelve-floats".
    /// Empty for all that there is: then the number is a range.
    pub function: &'static str,
}

/// How a benchmark's time becomes a table's number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Frames per second, where one measurement has so many frames.
    Rate(f64),
    /// Thousands of cells per second, where one measurement has so many frames.
    KiloCells(f64),
    /// Megabytes per second, of so many bytes per cell.
    Megabytes(f64),
    /// Milliseconds per frame, where one measurement has so many frames.
    Milliseconds(f64),
    /// Seconds.
    Seconds,
    /// How much greater the rate is than that of the benchmark of this name, in percent.
    GainOver(&'static str),
    /// No time, but what the benchmark keeps under its id ([`crate::results::keep`]).
    Counted,
    /// Not measured here.
    Missing,
}

/// One data set.
#[derive(Clone, Debug)]
pub struct Row {
    /// The paper's name of it, and what stands for it here.
    pub name: String,
    /// The beginning of benchmarks' ids; `None` where the data set is not at hand.
    pub bench: Option<String>,
    /// Least and greatest, as printed; empty where another row has the paper's numbers.
    pub printed: Vec<(f64, f64)>,
}

/// Whether a benchmark's id is that of a row and column: between the two may be a size.
pub fn is_of(row: &Row, column: &Column, id: &str) -> bool {
    let rest = row
        .bench
        .as_deref()
        .and_then(|bench| id.strip_prefix(bench));
    rest.is_some_and(|rest| {
        column.function.is_empty() || rest == column.function || {
            let size = rest.strip_suffix(column.function);
            size.is_some_and(|size| size.ends_with('/') && size.matches('/').count() == 1)
        }
    })
}

/// Samples on a regular grid, in figure 5 of Westermann's paper.
#[derive(Clone, Copy, Debug)]
pub struct Resampled {
    /// The mesh's name here.
    pub mesh: &'static str,
    /// Samples along each axis.
    pub dims: [usize; 3],
    /// Ael, Rnd, ToR and ToT in seconds, on an SGI Onyx IR2.
    pub seconds: [f64; 4],
}

const fn resampled(mesh: &'static str, dims: [usize; 3], seconds: [f64; 4]) -> Resampled {
    Resampled {
        mesh,
        dims,
        seconds,
    }
}

/// Figure 5 of Westermann's paper: a heat sink of 180 000 elements and the Blunt Fin in 225 000.
pub const RESAMPLED: [Resampled; 5] = [
    resampled("heat-sink", [64; 3], [0.2, 1.4, 0.2, 0.03]),
    resampled("heat-sink", [128; 3], [0.24, 2.3, 0.4, 0.1]),
    resampled("heat-sink", [256; 3], [0.3, 3.1, 1.1, 0.4]),
    resampled("blunt-fin", [256, 128, 64], [0.15, 2.2, 0.3, 0.1]),
    resampled("blunt-fin", [512, 256, 128], [0.23, 3.3, 1.0, 0.33]),
];

impl Resampled {
    /// The group of its benchmarks.
    pub fn group(&self) -> String {
        let [x, y, z] = self.dims;
        format!("resample/figure 5/{} {x}x{y}x{z}", self.mesh)
    }
}

/// All five papers.
pub fn papers() -> Vec<Paper> {
    vec![projection(), raycast(), resample(), slicing(), voxels()]
}

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

fn projection() -> Paper {
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

fn raycast() -> Paper {
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

fn resample() -> Paper {
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

fn slicing() -> Paper {
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

fn voxels() -> Paper {
    Paper {
        algorithm: "voxel-hw",
        name: "Prakash, Manohar 1995",
        tables: Vec::new(),
        note: "The paper prints no measurement: it draws a staircase of 23 cells and the Blunt Fin of 37 479 \
               hexahedra, in figures 3 to 6, and declines to estimate times. `cargo xtask figures` draws these \
               figures again, and `cargo xtask machine` simulates the proposed machine.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_whole_and_each_paper_is_of_an_algorithm() {
        for paper in papers() {
            assert!(
                tetrascope::algorithm(paper.algorithm).is_ok(),
                "{}",
                paper.name
            );
            assert!(!paper.tables.is_empty() || !paper.note.is_empty());
            for table in &paper.tables {
                assert!(table.rows.iter().any(|row| !row.printed.is_empty()));
                for row in &table.rows {
                    let count = row.printed.len();
                    assert!(count == 0 || count == table.columns.len(), "{}", row.name);
                    assert!(row.printed.iter().all(|(low, high)| low <= high));
                }
            }
        }
    }

    /// Frames per second, cells per second and megabytes per second are of one another.
    #[test]
    fn rates_of_the_projection_agree() {
        let cells = [224_874.0, 121_668.0, 148_955.0, 148_955.0];
        for table in projection().tables {
            let Quantity::Megabytes(bytes) = table.columns[2].quantity else {
                panic!("the third column has megabytes");
            };
            for (row, cells) in table.rows.iter().zip(cells) {
                let [rate, kilo, mega] = [0, 1, 2].map(|i| row.printed[i].0);
                // Printed to three digits: half of the last one of 1.08, and of 163.
                assert!(
                    (rate * cells / 1e3 / kilo - 1.0).abs() < 0.01,
                    "{}",
                    row.name
                );
                assert!(
                    (kilo * bytes / 1e3 / mega - 1.0).abs() < 0.04,
                    "{}",
                    row.name
                );
            }
        }
    }

    #[test]
    fn ids_are_those_of_a_row_and_column_whatever_the_size() {
        let paper = projection();
        let (table, shorts) = (&paper.tables[0], &paper.tables[1]);
        let id = "projection/tables/sphere/149k cells/twelve-floats";
        let sphere = &table.rows[3];
        assert!(is_of(sphere, &table.columns[0], id));
        assert!(!is_of(&table.rows[2], &table.columns[0], id));
        assert!(!is_of(sphere, &shorts.columns[0], id));
        let figure = &slicing().tables[0];
        let id = "slicing/figure 5/aneurism/hides a half/16";
        assert!(is_of(&figure.rows[3], &figure.columns[0], id));
        let other = "slicing/figure 5/aneurism/hides a half/6";
        assert!(!is_of(&figure.rows[3], &figure.columns[0], other));
    }
}
