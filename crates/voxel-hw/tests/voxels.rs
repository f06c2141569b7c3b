//! Voxels of small meshes: which are written, how often, and with what.

mod common;

use std::sync::Arc;
use tetrascope_core::Unit as _;

use common::{FIXED_AND_FLOAT, lattice, options, voxelize};
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::mesh::{Association, Split};
use tetrascope_core::{Knot, Scalars, TetMesh, TransferFunction};
use tetrascope_testing::{data_set, kuhn, mesh, point_scalars};
use tetrascope_voxel_hw::{
    Arithmetic, Cells, FirstVoxel, Offsets, VoxelSize, VoxelVolume, Voxelizer, VoxelizerOptions,
    Voxels,
};

/// Every voxel of a box is in the box, so it is written once per sample: columns, edges and
/// vertices of the lattice pass exactly through voxel centers.
#[test]
fn aligned_lattices_are_written_exactly_once() {
    for (n, side) in [(1, 4), (2, 4), (4, 4), (8, 4), (3, 9), (5, 5)] {
        // Vertices at voxel corners, and at voxel centers.
        for shift in [0.0, 0.5] {
            let low = DVec3::splat(shift);
            let box_ = kuhn(n, low, low + side as f64, |_| true);
            let mesh = mesh(box_, |p| p.x);
            for arithmetic in FIXED_AND_FLOAT {
                let volume = voxelize(&mesh, [side + 2; 3], options(arithmetic));
                let counts = volume.counts();
                assert_eq!(counts.cells, 6 * (n * n * n) as u64);
                // Half-open: with vertices at centers the first are in, the last are not.
                let mut index = 0;
                for z in 0..side + 2 {
                    for y in 0..side + 2 {
                        for x in 0..side + 2 {
                            let is_in = [x, y, z].into_iter().all(|c| c < side);
                            let what = format!("{n} {side} {shift} {arithmetic:?} {x} {y} {z}");
                            assert_eq!(volume.writes()[index], u32::from(is_in), "{what}");
                            index += 1;
                        }
                    }
                }
                assert_eq!(counts.writes, (side * side * side) as u64);
            }
        }
    }
}

/// Snapped to 1/256 of a voxel, the lattices are on no voxel's center any more, and some cells
/// are turned by any matrix.
#[test]
fn turned_lattices_are_written_exactly_once() {
    for seed in 0..8 {
        let turn = common::rotation(seed);
        let (points, cells) = kuhn(5, DVec3::splat(-1.0), DVec3::ONE, |_| true);
        let points: Vec<_> = points.iter().map(|p| turn * *p * 8.0 + 16.0).collect();
        let inside = |c: DVec3| {
            let place = turn.transpose() * ((c - 16.0) / 8.0);
            1.0 - place.abs().max_element()
        };
        let mesh = mesh((points, cells), |p| p.x);
        for arithmetic in FIXED_AND_FLOAT {
            let volume = voxelize(&mesh, [32; 3], options(arithmetic));
            assert_eq!(volume.overlaps(), 0);
            for (index, &writes) in volume.writes().iter().enumerate() {
                let depth = inside(center(index, [32; 3]));
                // Snapping moves a face by at most √3/512 voxels, of which 8 are one unit here.
                if depth.abs() > 0.0005 {
                    assert_eq!(writes, u32::from(depth > 0.0), "{arithmetic:?} {index}");
                }
            }
        }
    }
}

/// A scalar is off by at most half a step of 2⁻²⁴ from its vertices' rounding, 2⁻³⁰ where a face
/// rounds it down and 2⁻³⁰ where a voxel does, and by g 2⁻¹⁹ as the depth of faces is rounded down,
/// with g the rise from one voxel to the next along z; all of the range. Vertices are on
/// multiples of 2⁻⁸ voxels, so snapping moves none.
fn bound(rise: f64, range: f64, arithmetic: Arithmetic) -> f64 {
    let fixed = range * (2f64.powi(-25) + 2.0 * 2f64.powi(-30)) + rise * 2f64.powi(-19);
    // An f64 knows 2⁻⁵⁰ of it, and is then rounded to 2⁻³⁰ and, as all are, to f32.
    let float = range * 2f64.powi(-31);
    match arithmetic {
        Arithmetic::FixedPoint => fixed,
        Arithmetic::Float => float + range * 1e-14,
    }
}

#[test]
fn linear_fields_are_exact() {
    let slope = DVec3::new(0.3, -0.7, 1.1);
    let field = |p: DVec3| 2.0 + slope.dot(p);
    for (n, side) in [(2, 8), (3, 6), (1, 7)] {
        let mesh = mesh(
            kuhn(n, DVec3::ZERO, DVec3::splat(side as f64), |_| true),
            field,
        );
        let (low, high) = mesh.scalar_range().expect("a range");
        for arithmetic in FIXED_AND_FLOAT {
            for offsets in [
                Offsets::Regular(1),
                Offsets::Regular(2),
                Offsets::Regular(4),
            ] {
                let options = VoxelizerOptions {
                    offsets,
                    ..options(arithmetic)
                };
                let volume = voxelize(&mesh, [side; 3], options);
                let bound = bound(slope.z.abs(), high - low, arithmetic);
                // Stored as f32.
                let bound = bound + high.abs().max(low.abs()) * 2f64.powi(-24);
                for index in 0..side * side * side {
                    let truth = field(center(index, [side; 3]));
                    // Samples of a voxel at the border that miss take the mean with them.
                    if volume.coverage(index) == 1.0 {
                        let scalar = volume.scalar(index).expect("written");
                        assert!((scalar - truth).abs() <= bound, "{scalar} {truth} {bound}");
                    }
                }
                assert_eq!(volume.coverage(0), 1.0);
            }
        }
    }
}

/// The first voxel takes the front face's scalar as it is, which is off by the rise over the part of
/// a voxel between them, at most one voxel; then all of the column is.
#[test]
fn rounded_first_voxels_are_off_by_less_than_a_voxel() {
    let field = |p: DVec3| p.z;
    let mesh = mesh(kuhn(3, DVec3::ZERO, DVec3::splat(8.0), |_| true), field);
    for arithmetic in FIXED_AND_FLOAT {
        let rounded = VoxelizerOptions {
            first_voxel: FirstVoxel::Rounded,
            ..options(arithmetic)
        };
        let volume = voxelize(&mesh, [8; 3], rounded);
        let errors = (0..512).map(|i| {
            let scalar = volume.scalar(i).expect("written");
            center(i, [8; 3]).z - scalar
        });
        let errors: Vec<f64> = errors.collect();
        let (least, most) = errors
            .iter()
            .fold((f64::MAX, f64::MIN), |(a, b), e| (a.min(*e), b.max(*e)));
        // Snapping moves thirds by up to 2⁻⁹.
        let snap = 2f64.powi(-9);
        assert!(
            least >= -snap && most < 1.0 + snap && most > 0.5,
            "{least} {most}"
        );
    }
}

#[test]
fn the_staircase_fills_the_voxels_whose_centers_it_contains() {
    let stairs = data_set("staircase", None);
    let dims = [12, 12, 16];
    // Four voxels per cell, shifted so that stairs begin at no voxel's center.
    let lattice = |shift: f64| tetrascope_core::grid::Lattice {
        dims,
        origin: DVec3::splat(0.125 + shift),
        spacing: DVec3::splat(0.25),
        ..common::lattice(dims)
    };
    for cells in [Cells::AsGiven, Cells::Tetrahedra] {
        for arithmetic in FIXED_AND_FLOAT {
            for shift in [0.0, 0.0625, -0.03] {
                let options = VoxelizerOptions {
                    cells,
                    ..options(arithmetic)
                };
                let lattice = lattice(shift);
                let voxelizer = Voxelizer::new(options).expect("valid");
                let volume = voxelizer.voxelize(&stairs, &lattice).expect("voxels");
                let expected = if cells == Cells::AsGiven {
                    23
                } else {
                    stairs.cell_count()
                };
                assert_eq!(volume.counts().cells, expected as u64);
                for index in 0..dims.iter().product() {
                    let [x, y, z] = voxel(index, dims).map(|c| c as f64);
                    let place = lattice.point(DVec3::new(x, y, z));
                    let stair = place.floor();
                    let is_in = place.min_element() >= 0.0
                        && stair.x.max(stair.y) < 3.0
                        && stair.z < 4.0 - stair.x.max(stair.y);
                    assert_eq!(volume.writes()[index], u32::from(is_in), "{place}");
                    assert_eq!(volume.scalar(index), is_in.then_some(1.0));
                }
            }
        }
    }
}

/// A warped hexahedron, a wedge, a pyramid: as they are and as their tetrahedra they own the same
/// voxels, as their faces are cut alike and none has a dent.
#[test]
fn cells_as_given_own_the_voxels_of_their_tetrahedra() {
    let hexahedron = [
        [1.0, 1.5, 1.0],
        [9.0, 1.0, 2.0],
        [10.0, 9.5, 1.2],
        [1.3, 9.0, 2.0],
        [1.1, 2.0, 9.0],
        [9.5, 2.1, 10.0],
        [9.0, 8.7, 9.3],
        [2.0, 9.9, 10.4],
    ];
    let wedge = [
        [1.0, 1.0, 1.0],
        [9.0, 2.0, 1.5],
        [3.0, 9.0, 1.1],
        [1.5, 1.2, 9.0],
        [9.5, 2.2, 10.0],
        [3.3, 9.4, 9.5],
    ];
    let pyramid = [
        [1.0, 1.0, 1.0],
        [9.0, 2.0, 2.0],
        [10.0, 9.0, 1.7],
        [1.5, 9.5, 2.0],
        [5.0, 5.5, 10.0],
    ];
    let cells: [(u8, &[[f64; 3]]); 3] = [(12, &hexahedron), (13, &wedge), (14, &pyramid)];
    for (cell_type, corners) in cells {
        // Also inside out.
        for mirror in [1.0, -1.0] {
            let points = corners
                .iter()
                .map(|p| DVec3::new(p[0] * mirror, p[1], p[2]));
            let points: Vec<_> = points
                .map(|p| DVec3::new(p.x.rem_euclid(12.0), p.y, p.z))
                .collect();
            let cells = tetrascope_core::Cells {
                types: vec![cell_type],
                offsets: vec![0, corners.len() as u64],
                connectivity: (0..corners.len() as u64).collect(),
            };
            let scalars = point_scalars(points.iter().map(|p| p.z).collect());
            let mesh = TetMesh::keeping_cells(points, Arc::new(cells), scalars, Split::default());
            let mesh = mesh.expect("valid");
            for arithmetic in FIXED_AND_FLOAT {
                let volume = |cells| {
                    let options = VoxelizerOptions {
                        cells,
                        ..options(arithmetic)
                    };
                    voxelize(&mesh, [12; 3], options)
                };
                let (whole, cut) = (volume(Cells::AsGiven), volume(Cells::Tetrahedra));
                assert!(whole.counts().writes > 100, "{:?}", whole.counts());
                assert_eq!(whole.writes(), cut.writes(), "{cell_type} {mirror}");
                // A linear field along z is the same between any two faces.
                for index in 0..12 * 12 * 12 {
                    if let Some(scalar) = whole.scalar(index) {
                        let z = center(index, [12; 3]).z;
                        // Vertices are snapped by 2⁻⁹ of a voxel; faces by as much.
                        assert!((scalar - z).abs() < 2f64.powi(-9) + 1e-4, "{scalar} {z}");
                    }
                }
            }
        }
    }
}

/// The far face along x is folded inward along a horizontal line: columns there are in the cell, out of
/// it, and in it again. As it was given the cell is filled all through.
#[test]
fn dents_along_columns_are_filled() {
    let points = [
        [1.0, 1.0, 1.0],
        [9.0, 1.0, 1.0],
        [5.0, 11.0, 1.0],
        [1.0, 11.0, 1.0],
        [1.0, 1.0, 11.0],
        [5.0, 1.0, 11.0],
        [9.0, 11.0, 11.0],
        [1.0, 11.0, 11.0],
    ];
    // Numbered so that the folded face, 1 2 6 5, is cut from 2 to 5.
    let order = [0, 5, 1, 4, 2, 3, 7, 6];
    let mut numbered = [DVec3::ZERO; 8];
    for (corner, point) in points.iter().enumerate() {
        numbered[order[corner]] = DVec3::from(*point);
    }
    let given = tetrascope_core::Cells {
        types: vec![12],
        offsets: vec![0, 8],
        connectivity: order.map(|i| i as u64).to_vec(),
    };
    let scalars = point_scalars(vec![1.0; 8]);
    let mesh = TetMesh::keeping_cells(
        numbered.to_vec(),
        Arc::new(given),
        scalars,
        Split::default(),
    );
    let mesh = mesh.expect("valid");
    for arithmetic in FIXED_AND_FLOAT {
        let [whole, cut] = [Cells::AsGiven, Cells::Tetrahedra].map(|cells| {
            let options = VoxelizerOptions {
                cells,
                ..options(arithmetic)
            };
            voxelize(&mesh, [12; 3], options)
        });
        let mut filled = 0;
        for pixel in 0..144 {
            let column = |volume: &VoxelVolume| -> Vec<bool> {
                let voxels = (0..12).map(|z| pixel + 144 * z);
                voxels.map(|v| volume.writes()[v] > 0).collect()
            };
            let (whole, cut) = (column(&whole), column(&cut));
            let written = |column: &[bool]| column.iter().filter(|w| **w).count();
            assert!(cut.iter().zip(&whole).all(|(cut, whole)| whole >= cut));
            if let Some(first) = whole.iter().position(|w| *w) {
                let last = whole.iter().rposition(|w| *w).expect("the first");
                assert_eq!(written(&whole), last - first + 1);
            }
            filled += written(&whole) - written(&cut);
        }
        assert!(filled > 0);
    }
}

/// Flat cells that snapping turns inside out are left out.
#[test]
fn cells_that_snapping_inverts_are_left_out() {
    let mut random = common::random(5);
    let mut inverted = 0;
    for _ in 0..200 {
        let mut point = || 4.0 + 3.5 * DVec3::new(random(), random(), random());
        let [a, b, c] = [point(), point(), point()];
        let normal = (b - a).cross(c - a).unit();
        let d = (a + b + c) / 3.0 + 1e-4 * normal;
        let mesh = mesh((vec![a, b, c, d], vec![[0, 1, 2, 3]]), |p| p.x);
        let volume = voxelize(&mesh, [8; 3], VoxelizerOptions::default());
        if volume.counts().inverted == 1 {
            inverted += 1;
            assert_eq!(volume.counts().faces, 0);
        }
    }
    assert!((20..180).contains(&inverted), "{inverted}");
}

#[test]
fn cells_as_given_need_a_mesh_that_kept_them() {
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true), |p| p.x);
    let options = VoxelizerOptions {
        cells: Cells::AsGiven,
        ..VoxelizerOptions::default()
    };
    let voxelizer = Voxelizer::new(options).expect("valid");
    let error = voxelizer
        .voxelize(&mesh, &lattice([2; 3]))
        .expect_err("refused");
    assert!(error.help().is_some(), "{error}");
}

/// Sheets of no and of next to no thickness change nothing.
#[test]
fn slivers_are_harmless() {
    let box_ = kuhn(2, DVec3::ZERO, DVec3::splat(8.0), |_| true);
    let whole = mesh(box_.clone(), |p| p.x);
    for thickness in [0.0, 1e-12, 1e-3, 2.5e-3] {
        let (mut points, mut cells) = box_.clone();
        let first = points.len() as u32;
        // In the plane x = y, in which the box's own faces lie, and across it.
        points.extend([
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(7.0, 7.0, 0.0),
            DVec3::new(1.0, 1.0, 8.0),
            DVec3::new(7.0, 7.0 + thickness, 8.0),
            DVec3::new(1.0, 5.5, 3.0),
            DVec3::new(7.0, 1.5, 3.0),
            DVec3::new(2.0, 2.5, 3.0 + thickness),
            DVec3::new(4.0, 7.5, 3.0),
        ]);
        cells.extend([0, 4].map(|i| [0, 1, 2, 3].map(|c| first + i + c)));
        // A point where its edges meet.
        cells.push([first, first, first + 1, first + 2]);
        let mesh = mesh((points, cells), |p| p.x);
        for arithmetic in FIXED_AND_FLOAT {
            let [truth, volume] =
                [&whole, &mesh].map(|mesh| voxelize(mesh, [8; 3], options(arithmetic)));
            assert_eq!(
                truth.writes(),
                volume.writes(),
                "{thickness} {arithmetic:?}"
            );
        }
    }
}

/// Sums of integers: neither the order of cells nor that of their corners matters, to the last bit.
#[test]
fn order_does_not_matter() {
    let turn = common::rotation(7);
    let (points, mut cells) = kuhn(4, DVec3::splat(-1.0), DVec3::ONE, |_| true);
    let points: Vec<_> = points.iter().map(|p| turn * *p * 5.0 + 8.0).collect();
    let options = VoxelizerOptions {
        offsets: Offsets::Regular(3),
        ..VoxelizerOptions::default()
    };
    let volume = |cells: &[[u32; 4]]| {
        let mesh = mesh((points.clone(), cells.to_vec()), |p| p.x * p.y);
        voxelize(&mesh, [16; 3], options)
    };
    let truth = volume(&cells);
    cells.reverse();
    for [a, b, c, d] in cells.iter_mut() {
        (*a, *b, *c, *d) = (*d, *c, *b, *a);
    }
    assert!(truth == volume(&cells));
    assert!(truth.counts().writes > 27 * 900);
}

#[test]
fn cells_without_a_value_are_left_out() {
    let box_ = kuhn(2, DVec3::ZERO, DVec3::splat(4.0), |_| true);
    let with = mesh(box_.clone(), |p| p.x);
    let mut values = with.scalars().values.clone();
    values[0] = f64::NAN;
    let mesh = with.with_scalars(point_scalars(values)).expect("as many");
    let volume = voxelize(&mesh, [4; 3], VoxelizerOptions::default());
    // The corner's six cells are its cube.
    assert_eq!(volume.counts().without_value, 6);
    assert_eq!(volume.counts().writes, 64 - 8);
    let nothing = with.with_scalars(point_scalars(vec![f64::NAN; 27]));
    let volume = voxelize(
        &nothing.expect("as many"),
        [4; 3],
        VoxelizerOptions::default(),
    );
    assert_eq!(volume.counts().writes, 0);
}

#[test]
fn values_of_cells_are_constant_in_them() {
    let (points, cells) = kuhn(2, DVec3::ZERO, DVec3::splat(4.0), |_| true);
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Cell,
        values: (0..cells.len()).map(|c| (c / 6) as f64).collect(),
    };
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars).expect("valid");
    for arithmetic in FIXED_AND_FLOAT {
        let volume = voxelize(&mesh, [4; 3], options(arithmetic));
        for index in 0..64 {
            let [x, y, z] = voxel(index, [4; 3]).map(|c| c / 2);
            let truth = (x + 2 * (y + 2 * z)) as f64;
            let scalar = volume.scalar(index).expect("written");
            // Half a step of the range's 7, rounded to 2⁻²⁴.
            assert!((scalar - truth).abs() <= 7.0 * 2f64.powi(-25) + 7.0 * 2f64.powi(-24));
        }
    }
}

#[test]
fn a_mesh_may_reach_beyond_its_voxels() {
    let field = |p: DVec3| p.x + 2.0 * p.y - p.z;
    let mesh = mesh(
        kuhn(3, DVec3::splat(-7.0), DVec3::splat(14.0), |_| true),
        field,
    );
    for arithmetic in FIXED_AND_FLOAT {
        for first_voxel in [FirstVoxel::Interpolated, FirstVoxel::Rounded] {
            let options = VoxelizerOptions {
                first_voxel,
                scalar_range: Some((-50.0, 50.0)),
                ..options(arithmetic)
            };
            let part = voxelize(&mesh, [5, 6, 7], options);
            assert!(part.writes().iter().all(|w| *w == 1));
            // The same as a part of all voxels.
            let origin = DVec3::splat(-6.5);
            let all = tetrascope_core::grid::Lattice {
                origin,
                ..lattice([21; 3])
            };
            let voxelizer = Voxelizer::new(options).expect("valid");
            let all = voxelizer.voxelize(&mesh, &all).expect("voxels");
            for index in 0..5 * 6 * 7 {
                let [x, y, z] = voxel(index, [5, 6, 7]).map(|c| c + 7);
                let there = x + 21 * (y + 21 * z);
                let [here, there] =
                    [part.scalar(index), all.scalar(there)].map(|s| s.expect("written"));
                match arithmetic {
                    Arithmetic::FixedPoint => assert_eq!(here, there),
                    // Places are rounded where they are.
                    Arithmetic::Float => assert!((here - there).abs() < 1e-5),
                }
            }
        }
    }
}

#[test]
fn lattices_may_be_flipped_and_turned() {
    let field = |p: DVec3| p.x + 2.0 * p.y - p.z;
    let mesh = mesh(kuhn(2, DVec3::ZERO, DVec3::splat(8.0), |_| true), field);
    let flips = [
        [DVec3::X, DVec3::Y, DVec3::Z],
        [DVec3::NEG_X, DVec3::Y, DVec3::Z],
        [DVec3::Z, DVec3::X, DVec3::Y],
        [DVec3::Y, DVec3::X, DVec3::NEG_Z],
        [DVec3::Y, DVec3::X, DVec3::Z],
    ];
    for axes in flips {
        let direction = DMat3::from_cols(axes[0], axes[1], axes[2]);
        let lattice = tetrascope_core::grid::Lattice {
            // Half a voxel from the middle of the box in the middle of the lattice.
            origin: DVec3::splat(4.0) - direction * DVec3::splat(3.5),
            direction,
            ..lattice([8; 3])
        };
        for arithmetic in FIXED_AND_FLOAT {
            let voxelizer = Voxelizer::new(options(arithmetic)).expect("valid");
            let volume = voxelizer.voxelize(&mesh, &lattice).expect("voxels");
            assert!(volume.writes().iter().all(|w| *w == 1), "{axes:?}");
            for index in 0..512 {
                let [x, y, z] = voxel(index, [8; 3]).map(|c| c as f64);
                let truth = field(lattice.point(DVec3::new(x, y, z)));
                let scalar = volume.scalar(index).expect("written");
                // The range is 32.
                let bound = bound(2.0, 32.0, arithmetic) + 24.0 * 2f64.powi(-24);
                assert!((scalar - truth).abs() <= bound, "{scalar} {truth}");
            }
        }
    }
}

/// Powers of two scale places without rounding, so the voxels are the same to the last bit; also
/// where lattices are mirrored.
#[test]
fn the_unit_of_length_does_not_matter() {
    let (points, cells) = kuhn(3, DVec3::ZERO, DVec3::splat(7.7), |_| true);
    let volume = |scale: f64, mirror: f64, options| {
        let points = points.iter().map(|p| *p * scale).collect();
        let mesh = mesh((points, cells.clone()), |p| p.x / scale);
        let lattice = tetrascope_core::grid::Lattice {
            origin: DVec3::new(4.0 - mirror * 3.5, 0.5, 0.5) * scale,
            spacing: DVec3::splat(scale),
            direction: DMat3::from_diagonal(DVec3::new(mirror, 1.0, 1.0)),
            ..lattice([8; 3])
        };
        let voxelizer = Voxelizer::new(options).expect("valid");
        voxelizer.voxelize(&mesh, &lattice).expect("voxels")
    };
    for arithmetic in FIXED_AND_FLOAT {
        for mirror in [1.0, -1.0] {
            let truth = volume(1.0, mirror, options(arithmetic));
            assert_eq!(truth.counts().writes, 512);
            for exponent in [-300, -40, 40, 300] {
                let scaled = volume(2f64.powi(exponent), mirror, options(arithmetic));
                assert_eq!(truth.counts(), scaled.counts());
                assert!(truth.voxels() == scaled.voxels() && truth.writes() == scaled.writes());
            }
        }
    }
}

#[test]
fn integers_are_of_the_range() {
    let field = |p: DVec3| 10.0 + p.x;
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::splat(4.0), |_| true), field);
    let sizes = [
        (VoxelSize::Bits8, 255.0),
        (VoxelSize::Bits16, 65535.0),
        (VoxelSize::Bits32, f64::from(u32::MAX)),
    ];
    for (voxel_size, most) in sizes {
        let options = VoxelizerOptions {
            voxel_size,
            ..VoxelizerOptions::default()
        };
        let volume = voxelize(&mesh, [4, 4, 5], options);
        let first = match volume.voxels() {
            Voxels::U8(v) => f64::from(v[0]),
            Voxels::U16(v) => f64::from(v[0]),
            Voxels::U32(v) => f64::from(v[0]),
            Voxels::F32(_) => panic!("integers"),
        };
        // 1/8 of the range, to half an integer and the scalar's own error of 2⁻²⁴.
        assert!(
            (first - most / 8.0).abs() <= 0.5 + most * 2f64.powi(-24),
            "{first}"
        );
        let grid = volume.grid().expect("a grid");
        assert_eq!(grid.dims(), [4, 4, 5]);
        let coverage = grid.coverage().expect("coverage");
        assert!(coverage[..64].iter().all(|c| *c == 1.0));
        assert!(coverage[64..].iter().all(|c| *c == 0.0));
        assert!((grid.samples().get(3) - 13.5).abs() <= 2.0 / most + 1e-6);
    }
}

#[test]
fn no_voxels_and_too_many_are_refused() {
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true), |p| p.x);
    let voxelizer = Voxelizer::new(VoxelizerOptions::default()).expect("valid");
    for dims in [[0, 4, 4], [4, 4, 1025], [1024, 1024, 1024], [usize::MAX; 3]] {
        let error = voxelizer
            .voxelize(&mesh, &lattice(dims))
            .expect_err("refused");
        assert!(!error.to_string().is_empty());
    }
    for scalar_range in [(1.0, 0.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        let options = VoxelizerOptions {
            scalar_range: Some(scalar_range),
            ..VoxelizerOptions::default()
        };
        let error = Voxelizer::new(options).expect_err("refused");
        assert!(error.help().is_some());
    }
    // Voxels so small that fixed-point numbers do not hold the cells.
    let small = tetrascope_core::grid::Lattice {
        spacing: DVec3::splat(1e-4),
        ..lattice([4; 3])
    };
    let error = voxelizer.voxelize(&mesh, &small).expect_err("refused");
    assert!(error.help().is_some(), "{error}");
    let float = Voxelizer::new(options(Arithmetic::Float)).expect("valid");
    let volume = float.voxelize(&mesh, &small).expect("voxels");
    assert!(volume.writes().iter().all(|w| *w == 1));
}

/// The mean of the samples' colors is not the color of their mean where the transfer function bends.
#[test]
fn transfer_functions_apply_before_or_after_the_mean() {
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::splat(2.0), |_| true), |p| p.x);
    let options = VoxelizerOptions {
        offsets: Offsets::Regular(2),
        ..VoxelizerOptions::default()
    };
    let voxelizer = Voxelizer::new(options).expect("valid");
    let lattice = lattice([2, 2, 3]);
    let volume = voxelizer.voxelize(&mesh, &lattice).expect("voxels");
    // A ramp is linear: both agree. The second layer of voxels has extinction 1.5.
    let ramp = transfer_function(&[(0.0, 0.0), (2.0, 2.0)]);
    let before = voxelizer
        .voxelize_colors(&mesh, &lattice, &ramp)
        .expect("voxels");
    let after = volume.classify(&ramp).expect("voxels");
    // Scalars to 2⁻²⁴ of 2, then f32.
    for (a, b) in before.voxels().iter().zip(after.voxels()) {
        assert!((a[3] - b[3]).abs() <= 2f32.powi(-21), "{a:?} {b:?}");
    }
    assert!((before.voxels()[1][3] - 1.5).abs() <= 2f32.powi(-21));
    // A step within the first layer, at 0.5: half of its samples, 0.25 and 0.75, are beyond it.
    let step = transfer_function(&[(0.6, 0.0), (0.6, 1.0)]);
    let before = voxelizer
        .voxelize_colors(&mesh, &lattice, &step)
        .expect("voxels");
    let after = volume.classify(&step).expect("voxels");
    assert_eq!((before.voxels()[0][3], after.voxels()[0][3]), (0.5, 0.0));
    assert_eq!((before.voxels()[1][3], after.voxels()[1][3]), (1.0, 1.0));
    assert_eq!(before.voxels()[1][..3], [0.5, 0.25, 1.0]);
    // Nothing beyond the mesh.
    assert_eq!(before.voxels()[8], [0.0; 4]);
    assert_eq!(after.voxels()[8], [0.0; 4]);

    // Half a voxel is half as much, both ways: the first layer goes from −1/2 to 1/2.
    let larger = tetrascope_core::grid::Lattice {
        origin: DVec3::new(0.0, 0.5, 0.5),
        ..lattice
    };
    let one = transfer_function(&[(0.0, 1.0)]);
    let before = voxelizer
        .voxelize_colors(&mesh, &larger, &one)
        .expect("voxels");
    let volume = voxelizer.voxelize(&mesh, &larger).expect("voxels");
    let after = volume.classify(&one).expect("voxels");
    assert_eq!(volume.coverage(0), 0.5);
    assert_eq!((before.voxels()[0][3], after.voxels()[0][3]), (0.5, 0.5));
    assert_eq!((before.voxels()[1][3], after.voxels()[1][3]), (1.0, 1.0));
}

/// Voxel `index`'s place along the axes.
fn voxel(index: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [index % nx, index / nx % ny, index / (nx * ny)]
}

/// The center of voxel `index` of unit voxels from the origin.
fn center(index: usize, dims: [usize; 3]) -> DVec3 {
    DVec3::from(voxel(index, dims).map(|c| c as f64 + 0.5))
}

/// Moves the inner vertices of a lattice of n³ cubes by up to `most` along each axis.
fn jitter(points: &mut [DVec3], n: usize, most: f64, seed: u64) {
    let mut random = common::random(seed);
    let side = n + 1;
    for (i, point) in points.iter_mut().enumerate() {
        let place = [i % side, i / side % side, i / (side * side)];
        if place.iter().all(|c| (1..n).contains(c)) {
            *point += most * DVec3::new(random(), random(), random());
        }
    }
}

/// One color, and extinction by scalar.
fn transfer_function(extinction: &[(f64, f64)]) -> TransferFunction {
    let knot = |&(scalar, extinction): &(f64, f64)| Knot {
        scalar,
        color: DVec3::new(0.5, 0.25, 1.0),
        extinction,
    };
    TransferFunction::new(extinction.iter().map(knot).collect()).expect("knots")
}

/// A voxel's center on the diagonal around which six cells lie, one of them folded over the others: in
/// floats, one face passed 2⁻⁵² behind the other, and the voxel between them was left out.
#[test]
fn faces_that_rounding_swaps_leave_no_gap() {
    let (mut points, tetrahedra) = kuhn(3, DVec3::ZERO, DVec3::splat(6.0), |_| true);
    jitter(&mut points, 3, 0.7434122386820307, 884324059134);
    let mesh = mesh((points, tetrahedra), common::field);
    assert_eq!(mesh.report().flipped, 1);
    for arithmetic in FIXED_AND_FLOAT {
        let volume = voxelize(&mesh, [6; 3], options(arithmetic));
        assert!(volume.writes().iter().all(|writes| *writes > 0));
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(48))]

    /// Random places for the inner vertices of a lattice: there are never gaps, and overlaps only
    /// where a cell is inside out.
    #[test]
    fn random_meshes_have_no_gaps(
        seed in 0u64..1 << 40,
        most in 0.0..0.9f64,
        cells in 1usize..5,
    ) {
        let side = 6usize;
        let (mut points, tetrahedra) =
            kuhn(cells, DVec3::ZERO, DVec3::splat(side as f64), |_| true);
        jitter(&mut points, cells, most * side as f64 / cells as f64 / 2.0, seed);
        let mesh = mesh((points, tetrahedra), common::field);
        for arithmetic in FIXED_AND_FLOAT {
            let volume = voxelize(&mesh, [side; 3], options(arithmetic));
            let flat = volume.counts().inverted == 0 && mesh.report().flipped == 0;
            for (index, &writes) in volume.writes().iter().enumerate() {
                proptest::prop_assert!(writes >= 1, "{:?} {}", arithmetic, index);
                // A center on an edge between slanted faces lies on each of them but for rounding.
                if flat && arithmetic == Arithmetic::FixedPoint {
                    proptest::prop_assert_eq!(writes, 1, "{:?} {}", arithmetic, index);
                }
            }
        }
    }

    /// Any tetrahedra at all: no panic, scalars within those of the vertices, voxels within the
    /// bounding box.
    #[test]
    fn no_tetrahedron_does_harm(
        places in proptest::collection::vec(proptest::array::uniform3(-20.0..30.0f64), 4..12),
        scale in 0usize..4,
    ) {
        let scale = [1.0, 1e-3, 1e3, 1e12][scale];
        let points: Vec<DVec3> = places.iter().map(|p| DVec3::from(*p) * scale).collect();
        let cells: Vec<[u32; 4]> = (0..points.len() as u32 - 3).map(|i| [i, i + 1, i + 2, i + 3]).collect();
        let mesh = mesh((points, cells), |p| p.x);
        for arithmetic in FIXED_AND_FLOAT {
            for offsets in [Offsets::Regular(1), Offsets::Regular(3)] {
                let options = VoxelizerOptions { offsets, ..options(arithmetic) };
                let voxelizer = Voxelizer::new(options).expect("valid");
                // Fixed point refuses cells that are too wide.
                let Ok(volume) = voxelizer.voxelize(&mesh, &lattice([8, 7, 9])) else {
                    proptest::prop_assert!(arithmetic == Arithmetic::FixedPoint && scale > 1.0);
                    continue;
                };
                let (low, high) = mesh.scalar_range().expect("a range");
                let slack = (high - low).max(low.abs().max(high.abs())) * 2f64.powi(-22);
                for index in 0..8 * 7 * 9 {
                    if let Some(scalar) = volume.scalar(index) {
                        proptest::prop_assert!(scalar >= low - slack && scalar <= high + slack);
                    }
                }
            }
        }
    }
}
