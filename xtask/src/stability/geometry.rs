//! Cells and meshes without the shape that algorithms like.

use std::f64::consts::TAU;
use tetrascope::core::Unit as _;

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::mesh::{Association, Cells};
use tetrascope::core::{Scalars, TetMesh, View, Volume};
use tetrascope_testing::{Random, kuhn, mismatched, split, stacked_plates, tetrahedra_of};

use super::case::{Case, Group, Shot};
use super::scenes::{
    Pieces, look, one_color, parallel, perspective, plain, plain_over, slope, waves, whole,
};
use tetrascope_testing::knot;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        sizes(),
        far_from_the_origin(),
        flat_and_inverted(),
        needles_and_caps(),
        duplicates(),
        unshared_points(),
        collapsed_hexahedra(),
        twisted_hexahedra(),
        cycle("three cells that hide each other", 3),
        cycle("a ring of 64 cells that hide each other", 64),
        edges_without_a_disk(),
        alone("coincident boundary faces", mismatched(6)),
        blocks(),
        hanging_nodes(),
        shells(),
        alone("64 plates with gaps", stacked_plates(64)),
        torus_knot(),
        swiss_cheese(),
        one_cell(),
        no_cell(),
        fan(),
    ];
    cases.extend([DVec3::new(1.0, 1.0, 1e-6), DVec3::new(1e6, 1.0, 1.0)].map(anisotropic));
    cases
}

fn case(name: impl Into<String>, shot: Shot) -> Case {
    Case::new(Group::Geometry, name, shot)
}

/// As its values say, from a corner.
fn alone(name: &str, volume: Volume) -> Case {
    let (low, high) = volume.scalar_range().expect("a field");
    let length = volume.bounds().diagonal() / 2.0;
    let view = whole(&volume);
    case(name, Shot::new(volume, plain_over(low, high, length), view))
}

/// A view of what is `k` times as large and moved by `by`.
fn scaled(view: &View, k: f64, by: DVec3) -> View {
    use tetrascope::core::Projection;
    let mut view = *view;
    view.camera.position = view.camera.position * k + by;
    view.camera.focal_point = view.camera.focal_point * k + by;
    if let Projection::Orthographic { parallel_scale } = &mut view.camera.projection {
        *parallel_scale *= k;
    }
    view
}

/// Lengths times k and extinction by k: the same picture.
fn sizes() -> Case {
    let pieces = Pieces::cube(4, 0.3, waves);
    let view = whole(&pieces.clone().volume());
    let shots = [1.0, 1e-30, 1e-12, 1e12, 1e30].map(|k| {
        let volume = pieces.clone().moved(|p| k * p).volume();
        Shot::new(
            volume,
            plain_over(0.0, 1.0, k),
            scaled(&view, k, DVec3::ZERO),
        )
    });
    Case::same(Group::Geometry, "lengths times 1e-30 to 1e30", shots.into()).for_each()
}

/// 1e7 sizes away, as meters on a map: points keep 9 digits of f64, 2⁻³⁰ of the size.
fn far_from_the_origin() -> Case {
    // In steps that a double has there, too.
    let on_steps = |p: DVec3| (p * 1024.0).round() / 1024.0;
    let pieces = Pieces::cube(4, 0.3, waves).moved(on_steps);
    let view = parallel(DVec3::new(2.0, 3.0, 2.5), DVec3::ZERO, 1.75);
    let shots = [DVec3::ZERO, DVec3::new(5e6, -2e7, 1e7)].map(|by| {
        let volume = pieces.clone().moved(|p| p + by).volume();
        Shot::new(volume, plain(), scaled(&view, 1.0, by))
    });
    Case::same(Group::Geometry, "1e7 sizes from the origin", shots.into()).for_each()
}

/// Lengths of the axes apart by 1e6.
fn anisotropic(lengths: DVec3) -> Case {
    let volume = Pieces::cube(4, 0.3, waves).moved(|p| p * lengths).volume();
    let across = lengths.min_element();
    let appearance = plain_over(0.0, 1.0, across);
    // Along an axis on which it is thin, a little from the side.
    let from = match lengths.z < 1.0 {
        true => DVec3::new(0.3, 0.2, 3.0) * lengths.max_element(),
        false => DVec3::new(0.0, 0.4, 3.0),
    };
    let view = parallel(from, DVec3::ZERO, 0.8);
    let name = format!("cells {:?} wide", lengths.to_array());
    case(name, Shot::new(volume, appearance, view))
}

/// Jittered until cells are flat or inside out, on layers without thickness.
fn flat_and_inverted() -> Case {
    let flat = |p: DVec3| {
        DVec3::new(
            p.x,
            p.y,
            if p.z < 0.0 {
                -1.0 + 1e-9 * (p.z + 1.0)
            } else {
                p.z
            },
        )
    };
    let mut pieces = Pieces::cube(4, 0.0, waves).moved(flat);
    for cell in pieces.cells.iter_mut().step_by(3) {
        cell.swap(1, 2);
    }
    let volume = pieces.volume();
    let view = whole(&volume);
    case("flat and inverted cells", Shot::new(volume, plain(), view))
}

/// Cells a millionth as wide as long, and such whose corners are nearly in one plane.
fn needles_and_caps() -> Case {
    let squeezed = |p: DVec3| {
        let near = |x: f64| {
            if (x * 2.0).rem_euclid(2.0) == 1.0 {
                x - 0.5 + 1e-6
            } else {
                x
            }
        };
        DVec3::new(near(p.x), near(p.y), p.z)
    };
    let volume = Pieces::cube(4, 0.0, waves).moved(squeezed).volume();
    let view = whole(&volume);
    case("needles and caps", Shot::new(volume, plain(), view))
}

/// Cells that are there twice count once.
fn duplicates() -> Case {
    let pieces = Pieces::cube(3, 0.3, waves);
    let mut twice = pieces.clone();
    twice.cells.extend_from_within(..);
    let shots = [pieces, twice].map(|pieces| {
        let volume = pieces.volume();
        let view = whole(&volume);
        Shot::new(volume, plain(), view)
    });
    Case::same(Group::Geometry, "cells that are there twice", shots.into()).for_each()
}

/// Each cell with points of its own, and points that no cell names.
fn unshared_points() -> Case {
    let pieces = Pieces::cube(3, 0.3, waves);
    let mut more = pieces.clone();
    more.points.extend([DVec3::splat(50.0), DVec3::splat(-1e9)]);
    more.values.extend([1e9, -1e9]);
    let volume = pieces.volume();
    let volumes = [volume.clone(), split(tetrahedra_of(&volume)), more.volume()];
    let shots = volumes.map(|volume| {
        let view = whole(&volume);
        Shot::new(volume, plain(), view)
    });
    Case::same(
        Group::Geometry,
        "points that are not shared or not used",
        shots.into(),
    )
    .for_each()
}

/// Hexahedra on the cells of the cube, in each of which `corners` may exchange some.
fn hexahedra(n: usize, points: Vec<DVec3>, corners: impl Fn(usize, &mut [u64; 8])) -> Volume {
    let side = n + 1;
    let mut connectivity = Vec::new();
    for cube in 0..n * n * n {
        let [x, y, z] = [cube % n, cube / n % n, cube / (n * n)];
        // VTK's order: around the lower face, then around the upper.
        let around = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let corner = |i: usize| {
            let [dx, dy] = around[i % 4];
            (x + dx + side * (y + dy + side * (z + i / 4))) as u64
        };
        let mut cell = std::array::from_fn(corner);
        corners(cube, &mut cell);
        connectivity.extend(cell);
    }
    let count = n * n * n;
    let cells = Cells {
        types: vec![12; count],
        offsets: (0..=count as u64).map(|i| 8 * i).collect(),
        connectivity,
    };
    let values = points.iter().map(|p| waves(*p)).collect();
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values,
    };
    Volume::Mesh(TetMesh::from_cells(points, cells, scalars).expect("the suite's meshes are valid"))
}

/// Hexahedra with an edge or a face in one point, as wedges and pyramids are often written.
fn collapsed_hexahedra() -> Case {
    let (points, _) = kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |_| true);
    let volume = hexahedra(3, points, |cube, cell| match cube % 3 {
        0 => cell[6] = cell[5],
        1 => {
            for top in 5..8 {
                cell[top] = cell[4];
            }
        }
        _ => (),
    });
    let view = whole(&volume);
    case("collapsed hexahedra", Shot::new(volume, plain(), view))
}

/// Hexahedra whose faces are not flat.
fn twisted_hexahedra() -> Case {
    let (points, _) = kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |_| true);
    let turned = points
        .into_iter()
        .map(|p| DMat3::from_rotation_z(0.6 * p.z) * p);
    let volume = hexahedra(3, turned.collect(), |_, _| ());
    let view = whole(&volume);
    case("twisted hexahedra", Shot::new(volume, plain(), view))
}

/// Slats around the z axis, each of which is before the next and the last before the first.
fn cycle(name: &str, count: u32) -> Case {
    let mut pieces = Pieces::with_field(Vec::new(), Vec::new(), |_| 0.0);
    for k in 0..count {
        let turn = DMat3::from_rotation_z(TAU * f64::from(k) / f64::from(count));
        // From one neighbor to the other, and on its way from above to below.
        let reach = 1.2_f64.min(6.0 / f64::from(count));
        let slat = [
            [-reach, 0.35, 1.0],
            [-reach, 0.5, 0.9],
            [reach, 0.35, -0.9],
            [reach, 0.5, -0.8],
        ];
        let points = slat.map(|p| turn * DVec3::from(p)).to_vec();
        let share = f64::from(k) / f64::from(count - 1);
        pieces = pieces.and(Pieces::with_field(points, vec![[0, 1, 2, 3]], |_| share));
    }
    let view = parallel(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 1.2);
    let appearance = look(vec![
        knot(0.0, [1.0, 0.1, 0.1], 20.0),
        knot(0.5, [0.1, 1.0, 0.1], 20.0),
        knot(1.0, [0.1, 0.1, 1.0], 20.0),
    ]);
    case(name, Shot::new(pieces.volume(), appearance, view))
}

/// Two cubes that share an edge, and two that share a corner.
fn edges_without_a_disk() -> Case {
    let keep = |c: [usize; 3]| c[0] == c[1] && (c[0] + c[2]).is_multiple_of(2);
    let (points, cells) = kuhn(3, DVec3::NEG_ONE, DVec3::ONE, keep);
    let volume = Pieces::with_field(points, cells, waves).volume();
    let view = whole(&volume);
    case(
        "cubes that share an edge or a corner",
        Shot::new(volume, plain(), view),
    )
}

/// 27 bodies that touch nowhere.
fn blocks() -> Case {
    let keep = |c: [usize; 3]| c.iter().all(|i| i.is_multiple_of(2));
    let (points, cells) = kuhn(5, DVec3::NEG_ONE, DVec3::ONE, keep);
    let volume = Pieces::with_field(points, cells, waves).volume();
    let view = whole(&volume);
    case("27 blocks", Shot::new(volume, plain(), view))
}

/// Small cubes beside large ones: points in the middle of faces. The field is linear, so that both
/// sides of a face agree.
fn hanging_nodes() -> Case {
    let half = |n: usize, min: DVec3| {
        let (points, cells) = kuhn(n, min, min + DVec3::new(1.0, 2.0, 2.0), |_| true);
        Pieces::with_field(points, cells, slope)
    };
    let fine = half(6, DVec3::new(-1.0, -1.0, -1.0));
    let coarse = half(2, DVec3::new(0.0, -1.0, -1.0));
    let volumes = [Pieces::cube(4, 0.0, slope), fine.and(coarse)].map(Pieces::volume);
    let shots = volumes.map(|volume| {
        let view = whole(&volume);
        Shot::new(volume, plain(), view)
    });
    Case::same(Group::Geometry, "hanging nodes", shots.into())
}

/// 64 hollow cubes in each other.
fn shells() -> Case {
    let mut pieces = Pieces::with_field(Vec::new(), Vec::new(), |_| 0.0);
    for k in 1..=64 {
        let outer = f64::from(k) / 64.0;
        // A cube of 3³ whose middle is left out, and whose walls are half as thick as the way to
        // the next shell.
        let wall = 0.5 / 64.0;
        let (points, cells) = kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |c| c != [1; 3]);
        let place = |x: f64| x.signum() * if x.abs() == 1.0 { outer } else { outer - wall };
        let points = points
            .into_iter()
            .map(|p| DVec3::new(place(p.x), place(p.y), place(p.z)));
        pieces = pieces.and(Pieces::with_field(points.collect(), cells, |_| outer));
    }
    let volume = pieces.volume();
    let view = whole(&volume);
    case("64 shells in each other", Shot::new(volume, plain(), view))
}

/// A tube around a trefoil: rays leave and enter again, in no order of cells along it.
fn torus_knot() -> Case {
    let around = 96;
    let center = |i: usize| {
        let t = TAU * i as f64 / around as f64;
        let r = 0.6 + 0.25 * (3.0 * t).cos();
        DVec3::new(
            r * (2.0 * t).cos(),
            r * (2.0 * t).sin(),
            0.25 * (3.0 * t).sin(),
        )
    };
    let corner = |i: usize, j: usize| {
        let tangent = (center(i + 1) - center(i + around - 1)).unit();
        let normal = tangent.cross(DVec3::Z).unit();
        let angle = TAU * j as f64 / 4.0;
        center(i) + 0.12 * (normal * angle.cos() + normal.cross(tangent) * angle.sin())
    };
    let points = (0..around).flat_map(|i| (0..4).map(move |j| corner(i, j)));
    // Corner c of a piece: bit 0 and 1 around its square, bit 2 along the tube.
    let square = [0, 1, 3, 2];
    let cells = (0..around).flat_map(|i| {
        let corner = |c: usize| ((4 * ((i + (c >> 2)) % around)) + square[c & 3]) as u32;
        tetrascope_testing::CUBE.map(|cell| cell.map(corner))
    });
    let volume =
        Pieces::with_field(points.collect(), cells.collect(), |p| 0.5 + 0.5 * p.x).volume();
    let view = whole(&volume);
    case(
        "a trefoil knot",
        Shot::new(volume, plain_over(0.0, 1.0, 0.3), view),
    )
}

/// A cube with 1 000 voids.
fn swiss_cheese() -> Case {
    let keep = |c: [usize; 3]| !c.iter().all(|i| i % 2 == 1);
    let (points, cells) = kuhn(21, DVec3::NEG_ONE, DVec3::ONE, keep);
    let volume = Pieces::with_field(points, cells, waves).volume();
    let view = whole(&volume);
    case("1 000 voids", Shot::new(volume, plain(), view))
}

/// Seen along z, its height over (x, y) is 1 − x − y.
fn one_cell() -> Case {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let volume = Pieces::with_field(points, vec![[0, 1, 2, 3]], |_| 0.5).volume();
    let color = DVec3::new(0.3, 0.6, 0.9);
    let appearance = look(vec![knot(0.0, color, 2.0), knot(1.0, color, 2.0)]);
    let view = parallel(
        DVec3::new(0.31, 0.29, 5.0),
        DVec3::new(0.31, 0.29, 0.0),
        0.6,
    );
    let shot = Shot::new(volume, appearance, view);
    Case::known(Group::Geometry, "one cell", shot, move |ray| {
        let [x, y] = [ray.origin.x, ray.origin.y];
        let is_outside = x < 0.0 || y < 0.0 || x + y > 1.0;
        one_color(color, if is_outside { 0.0 } else { 2.0 * (1.0 - x - y) })
    })
}

fn no_cell() -> Case {
    let volume = Pieces::with_field(Vec::new(), Vec::new(), |_| 0.0).volume();
    let view = perspective(DVec3::new(3.0, 1.0, 2.0), DVec3::ZERO, 30.0);
    let shot = Shot::new(volume, plain(), view);
    Case::known(Group::Geometry, "no cell", shot, |_| [0.0; 4])
}

/// 1 000 cells around one edge.
fn fan() -> Case {
    let count = 1000_u32;
    let mut points = vec![DVec3::NEG_Z, DVec3::Z];
    points.extend((0..count).map(|i| {
        let angle = TAU * f64::from(i) / f64::from(count);
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    }));
    let cells = (0..count).map(|i| [0, 1, 2 + i, 2 + (i + 1) % count]);
    let volume = Pieces::with_field(points, cells.collect(), waves).volume();
    let view = whole(&volume);
    case(
        "1 000 cells around an edge",
        Shot::new(volume, plain(), view),
    )
}

/// Hard meshes of the walks' own tests, with a field.
pub(super) fn hard() -> Vec<Case> {
    let mut random = Random(0xfeed_beef_dead_cafe);
    let of = |mesh: &tetrascope_testing::HardMesh| {
        let plain = mesh.mesh();
        let values = plain
            .points()
            .iter()
            .map(|_| random.vector().x.abs())
            .collect();
        let scalars = Scalars {
            values,
            ..plain.scalars().clone()
        };
        let volume = Volume::Mesh(plain.with_scalars(scalars).expect("as many"));
        let case = alone(mesh.name, volume);
        match mesh.jitter > 0.5 {
            true => case.allowing(
                1.0,
                "cells overlap, and which of them is in front is nowhere defined",
            ),
            false => case,
        }
    };
    tetrascope_testing::HARD_MESHES.iter().map(of).collect()
}
