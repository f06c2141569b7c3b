//! Numbers that the papers print of their own measurements, and the benchmarks that measure the same here.
//!
//! Numbers are as printed, with the paper's units; nothing is read off a diagram.

mod tables;

/// A paper.
#[derive(Clone, Debug)]
pub struct Paper {
    /// The algorithm's name in the registry.
    pub algorithm: &'static str,
    /// Authors and year.
    pub name: &'static str,
    /// Tables and figures with numbers.
    pub tables: Vec<Table>,
    /// A note on what the paper does not print, and on what stands for it.
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
    /// A note on what differs here.
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
    /// The end of a benchmark's id, behind a row's [`Row::bench`] and the size: "twelve-floats".
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
    vec![
        tables::projection(),
        tables::raycast(),
        tables::resample(),
        tables::slicing(),
        tables::voxels(),
    ]
}

#[cfg(test)]
mod tests {
    use super::tables::{projection, slicing};
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
