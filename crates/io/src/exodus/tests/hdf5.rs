//! Exodus in HDF5 files.

use super::*;
use crate::hdf5::tests::Files;
use crate::read::{ReadOptions, read_mesh};
use crate::read_steps;

fn read_step(name: &str, step: Option<StepChoice>) -> MeshData {
    let files = Files::of(&[name]);
    let options = ReadOptions {
        step,
        ..ReadOptions::default()
    };
    read_mesh(&files.path(name), &options).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn a_file_of_netcdf_4_is_read_as_a_classic_one() {
    let data = read_step("lattice.e", None);
    let other = read_bytes(&fixture("lattice-axes.e")).expect("a mesh");
    assert_eq!(data.points, other.points);
    assert_eq!(data.cells.types, other.cells.types);
    assert_eq!(data.cells.connectivity, other.cells.connectivity);
    assert_eq!(data.notes, other.notes);
    for name in ["f", "c"] {
        assert_eq!(values(&data, name), values(&other, name), "{name}");
    }
}

#[test]
fn blocks_have_the_values_that_the_truth_table_says() {
    let files = Files::of(&["steps.e"]);
    let times = read_steps(&files.path("steps.e")).expect("times");
    assert_eq!(times, [0.0, 0.5, 1.0]);
    for (step, factor) in [(0, 1.0), (2, 3.0)] {
        let data = read_step("steps.e", Some(StepChoice::Number(step)));
        let c: Vec<f64> = (0..40).map(|c| factor * f64::from(c)).collect();
        assert_eq!(values(&data, "c"), c);
        // The file has values for the second block, too.
        let masked = values(&data, "masked");
        assert_eq!(masked[..25], c[..25]);
        assert!(masked[25..].iter().all(|value| value.is_nan()));
        let f: Vec<f64> = data
            .points
            .iter()
            .map(|p| factor * (p.x + 10.0 * p.y + 100.0 * p.z))
            .collect();
        assert_eq!(values(&data, "f"), f);
        let ids = values(&data, "block id");
        assert_eq!((ids[24], ids[25]), (10.0, 20.0));
    }
}
