//! Regular grids of public collections, where they are; see `real_data.rs`.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::SampleType;
use tetrascope_core::{Grid, Volume};
use tetrascope_io::{FileData, ReadOptions, read_file};

/// The grid in a file, or `None` with a word about it when the file is absent.
fn read(name: &str) -> Option<Grid> {
    let path = tetrascope_testing::file("real grids", name)?;
    let data = read_file(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let FileData::Grid(data) = data else {
        panic!("{name} is a grid");
    };
    match data.into_volume(None).unwrap_or_else(|e| panic!("{e}")) {
        (Volume::Grid(grid), _) => Some(grid),
        _ => panic!("{name} fits in memory"),
    }
}

/// Whether `level`, rounded to a whole number, is the percentile `share` of the samples.
fn is_percentile(grid: &Grid, share: f64, level: f64) -> bool {
    let samples = grid.samples();
    let count = |limit: f64| {
        (0..samples.len())
            .filter(|i| samples.get(*i) < limit)
            .count()
    };
    let share = share * samples.len() as f64;
    (count(level - 0.5) as f64) <= share && share <= count(level + 0.5) as f64
}

/// The share of samples that are 0.
fn zeros(grid: &Grid) -> f64 {
    let samples = grid.samples();
    let zeros = (0..samples.len()).filter(|i| samples.get(*i) == 0.0);
    zeros.count() as f64 / samples.len() as f64
}

// Dims, types, ranges and percentiles as measured with NumPy and VTK 9.7, to the digits
// that were noted.
#[test]
fn every_format_gives_what_others_read() {
    if let Some(grid) = read("aneurism.vti") {
        assert_eq!(grid.dims(), [256; 3]);
        assert_eq!(grid.samples().sample_type(), SampleType::U8);
        assert_eq!(grid.scalar_range(), Some((0.0, 255.0)));
        assert!((zeros(&grid) - 0.990).abs() < 5e-4);
    }
    if let Some(grid) = read("CT_AVM.nii.gz") {
        assert_eq!(grid.dims(), [256, 242, 154]);
        // 0 to 255, times a slope of 2.2086275.
        let (low, high) = grid.scalar_range().expect("numbers");
        assert!(low == 0.0 && (high - 563.2).abs() < 0.05, "{high}");
        let spacing = DVec3::new(0.71994, 0.72091, 1.0);
        assert!(
            grid.spacing().abs_diff_eq(spacing, 5e-6),
            "{}",
            grid.spacing()
        );
        assert!((zeros(&grid) - 0.959).abs() < 5e-4);
    }
    if let Some(grid) = read("aorta.mha") {
        assert_eq!(grid.dims(), [157, 393, 34]);
        assert_eq!(grid.samples().sample_type(), SampleType::F32);
        let (low, high) = grid.scalar_range().expect("numbers");
        assert!(low == 0.0 && (high - 2570.2).abs() < 0.05);
        assert!(is_percentile(&grid, 0.95, 618.0));
        assert_eq!(grid.spacing(), DVec3::new(0.878906, 0.878906, 1.50009));
        let flip = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
        assert_eq!(grid.direction(), flip);
        assert_eq!(grid.origin(), DVec3::new(-156.445, -24.6094, 0.0));
    }
    if let Some(grid) = read("headsq/quarter.nhdr") {
        assert_eq!(grid.dims(), [64, 64, 93]);
        assert_eq!(grid.samples().sample_type(), SampleType::I16);
        assert_eq!(grid.scalar_range(), Some((0.0, 3926.0)));
        assert_eq!(grid.spacing(), DVec3::new(3.2, 3.2, 1.5));
        assert!(is_percentile(&grid, 0.75, 1060.0));
    }
    if let Some(grid) = read("engine.vti") {
        assert_eq!(grid.dims(), [256, 256, 128]);
        assert!(is_percentile(&grid, 0.95, 144.0));
    }
    if let Some(grid) = read("tooth.nrrd") {
        assert_eq!(grid.dims(), [103, 94, 161]);
        assert_eq!(grid.samples().sample_type(), SampleType::U8);
        assert!(is_percentile(&grid, 0.95, 220.0));
    }
    if let Some(grid) = read("ironProt.vtk") {
        assert_eq!(grid.dims(), [68; 3]);
        assert_eq!(grid.scalar_range(), Some((0.0, 255.0)));
        assert!(is_percentile(&grid, 0.95, 83.0));
    }
    if let Some(grid) = read("HeadMRVolume.mhd") {
        assert_eq!(grid.dims(), [48, 62, 42]);
        assert_eq!(grid.spacing(), DVec3::splat(4.0));
        assert!(is_percentile(&grid, 0.95, 95.0));
    }
}
