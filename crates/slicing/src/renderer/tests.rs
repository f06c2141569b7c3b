use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Region, Samples as Values};
use tetrascope_core::{Grid, Isosurface, Knot, OpticalModel, TransferFunction};
use tetrascope_f32::Domain;
use tetrascope_testing as testing;

use super::*;

/// Samples along each axis.
const SIDE: usize = 9;

#[test]
fn parts_with_the_domain_of_the_whole_have_its_numbers() {
    let Some(gpu) = testing::gpu("parts_with_the_domain_of_the_whole_have_its_numbers") else {
        return;
    };
    let sample = |i: usize| 0.1 + (i * 7919 % 731) as f32;
    let samples = Values::F32((0..SIDE.pow(3)).map(sample).collect());
    let (origin, spacing) = (DVec3::new(0.3, 0.1, 7.0), DVec3::new(0.1, 0.2, 0.3));
    let grid = Grid::new([SIDE; 3], origin, spacing, DMat3::IDENTITY, samples).expect("valid");
    let knot = Knot {
        scalar: 0.0,
        color: DVec3::ONE,
        extinction: 1.0,
    };
    let function = TransferFunction::new(vec![knot]).expect("one knot");
    let mut appearance = Appearance::new(function, OpticalModel::Isosurfaces);
    appearance.isosurfaces = vec![Isosurface {
        value: 300.0,
        color: DVec3::ONE,
    }];
    let made = |grid: &Grid, domain| {
        let options = SlicingOptions {
            domain,
            ..SlicingOptions::default()
        };
        let volume = Volume::Grid(grid.clone());
        Slicing::new(&gpu, &volume, &appearance, &options).expect("it fits")
    };
    let whole = made(&grid, None).style;
    let domain = Domain {
        bounds: grid.bounds(),
        scalar_range: grid.scalar_range(),
    };
    assert_eq!(whole.volume.domain, domain);
    for [x, y] in [[0, 0], [4, 0], [0, 4], [4, 4]] {
        let region = Region {
            low: [x, y, 0],
            size: [5, 5, SIDE],
        };
        let samples = grid.read(region).expect("inside");
        let at = origin + spacing * DVec3::new(x as f64, y as f64, 0.0);
        let part = Grid::new(region.size, at, spacing, DMat3::IDENTITY, samples);
        let part = part.expect("valid");
        let drawn = made(&part, Some(domain)).style;
        assert_eq!(drawn.volume.normalization, whole.volume.normalization);
        assert_eq!(drawn.map, whole.map);
        let alone = made(&part, None).style;
        assert_ne!(alone.volume.normalization, whole.volume.normalization);
    }
}
