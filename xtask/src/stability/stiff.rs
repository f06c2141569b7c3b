//! Extinctions over many decades, transfer functions with steps, needles and thousands of knots, and
//! fields that jump.

use tetrascope::core::glam::DVec3;
use tetrascope_testing::{Random, knot};

use super::case::{Case, Group, Shot};
use super::scenes::{
    ORANGE, Pieces, along_x, down_x, look, one_color, parallel, plain, seven_steps, waves, whole,
};

/// A ray through the cube along x.
const LENGTH: f64 = 2.0;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        opaque_at_once(),
        hardly_there(),
        decades(),
        steps(),
        many_knots(),
        jumps(),
        boundary_layer(),
        dense_behind_thin(),
    ];
    cases.extend([1e-3, 1e-6].map(needle));
    cases
}

/// 2²⁰ cells on each ray.
pub(super) fn long_row() -> Case {
    Case {
        is_long: true,
        ..row("2²⁰ cells on each ray", 1 << 20, 4)
    }
}

/// So many cells on each ray, or one or two more, whose lengths add up: three of the six of each cube in a row.
/// Light has one color, behind an optical depth of 1.6; the picture has `side`² pixels.
pub fn row(name: &str, cells: usize, side: u32) -> Case {
    let cubes = cells.div_ceil(3);
    let at = |i: usize| 2.0 * i as f64 / cubes as f64 - 1.0;
    let corner = |i: usize| {
        [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[y, z]| DVec3::new(at(i), y, z))
    };
    let points: Vec<DVec3> = (0..=cubes).flat_map(corner).collect();
    // Corner c of a cube: bit 0 along x, then y, then z.
    let cells = (0..cubes).flat_map(|i| {
        tetrascope_testing::CUBE.map(|cell| cell.map(|c| (4 * (i + (c & 1)) + (c >> 1)) as u32))
    });
    let pieces = Pieces::with_field(points, cells.collect(), along_x);
    let appearance = look(vec![knot(0.0, ORANGE, 0.2), knot(1.0, ORANGE, 1.4)]);
    let mut view = down_x();
    (view.width, view.height) = (side, side);
    let shot = Shot::new(pieces.volume(), appearance, view);
    Case::known(Group::Stiff, name, shot, |_| {
        one_color(ORANGE, 0.8 * LENGTH)
    })
}

fn case(name: impl Into<String>, shot: Shot) -> Case {
    Case::new(Group::Stiff, name, shot)
}

/// Opaque within a millionth of a cell, whose length along x is ½ on average: color ranges linearly
/// from the front's to the back's, and C = c_f (1 − w) + c_b (w − e^(−τ)) with w = (1 − e^(−τ)) / τ.
fn opaque_at_once() -> Case {
    let extinction = 20.0 / 0.5e-6;
    let back = DVec3::new(0.2, 0.3, 0.9);
    let appearance = look(vec![
        knot(0.0, back, extinction),
        knot(1.0, ORANGE, extinction),
    ]);
    let shot = Shot::new(Pieces::cube(4, 0.2, along_x).volume(), appearance, down_x());
    Case::known(
        Group::Stiff,
        "a cell opaque in 1e-6 of its length",
        shot,
        move |_| {
            let w = 1.0 / (extinction * LENGTH);
            (ORANGE * (1.0 - w) + back * w).extend(1.0).to_array()
        },
    )
}

fn hardly_there() -> Case {
    let depth = 1e-7;
    let appearance = look(vec![
        knot(0.0, ORANGE, depth / LENGTH),
        knot(1.0, ORANGE, depth / LENGTH),
    ]);
    let shot = Shot::new(Pieces::cube(4, 0.2, along_x).volume(), appearance, down_x());
    Case::known(Group::Stiff, "an optical depth of 1e-7", shot, move |_| {
        one_color(ORANGE, depth)
    })
    .for_all()
}

/// From 1e-6 to 1e6: a color for each decade.
fn decades() -> Case {
    let knots = (0..=12).map(|i| {
        let share = f64::from(i) / 12.0;
        let color = DVec3::new(share, 1.0 - share, f64::from(i % 2));
        knot(share, color, 10f64.powi(i - 6))
    });
    let volume = Pieces::cube(5, 0.2, waves).volume();
    let view = whole(&volume);
    case(
        "12 decades of extinction",
        Shot::new(volume, look(knots.collect()), view),
    )
}

/// Two knots at each of 7 places: what is between them is uniform.
fn steps() -> Case {
    let (knots, mean) = seven_steps();
    let depth = mean * LENGTH;
    let shot = Shot::new(
        Pieces::cube(5, 0.2, along_x).volume(),
        look(knots),
        down_x(),
    );
    Case::known(Group::Stiff, "7 steps", shot, move |_| {
        one_color(ORANGE, depth)
    })
}

/// A peak of this width in a range of 1, of an optical depth of 1 in all.
fn needle(width: f64) -> Case {
    let at = 0.637;
    let height = 2.0 / (width * LENGTH);
    let appearance = look(vec![
        knot(0.0, ORANGE, 0.0),
        knot(at - width / 2.0, ORANGE, 0.0),
        knot(at, ORANGE, height),
        knot(at + width / 2.0, ORANGE, 0.0),
        knot(1.0, ORANGE, 0.0),
    ]);
    let shot = Shot::new(Pieces::cube(5, 0.2, along_x).volume(), appearance, down_x());
    let name = format!("a needle {width:e} of the range wide");
    Case::known(Group::Stiff, name, shot, |_| one_color(ORANGE, 1.0))
}

fn many_knots() -> Case {
    let count = 4096;
    let mut random = Random(0x1234_5678_9abc_def1);
    let extinctions: Vec<f64> = (0..count).map(|_| 4.0 * random.vector().x.abs()).collect();
    let last = f64::from(count - 1);
    let knots = extinctions.iter().zip(0..);
    let knots = knots.map(|(&extinction, i)| knot(f64::from(i) / last, ORANGE, extinction));
    let mean: f64 = extinctions
        .windows(2)
        .map(|w| (w[0] + w[1]) / 2.0)
        .sum::<f64>()
        / last;
    let shot = Shot::new(
        Pieces::cube(4, 0.2, along_x).volume(),
        look(knots.collect()),
        down_x(),
    );
    Case::known(Group::Stiff, "4096 knots", shot, move |_| {
        one_color(ORANGE, mean * LENGTH)
    })
}

/// Every other cell's values are 1e6 times its neighbors'.
fn jumps() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let values = pieces.cells.iter().enumerate().map(|(i, cell)| {
        let mean = cell.iter().map(|&p| pieces.values[p as usize]).sum::<f64>() / 4.0;
        mean * if i % 2 == 0 { 1.0 } else { 1e6 }
    });
    let values = values.collect();
    let volume = pieces.with_cell_values(values);
    let view = whole(&volume);
    let appearance = look(vec![
        knot(0.0, [0.1, 0.2, 0.8], 0.2),
        knot(1.0, [0.2, 0.9, 0.4], 1.0),
        knot(1e6, [1.0, 0.3, 0.1], 3.0),
    ]);
    case(
        "a field that jumps by 1e6",
        Shot::new(volume, appearance, view),
    )
}

/// Layers that grow from 1e-6 of the length to a half, with most of the field in the first.
fn boundary_layer() -> Case {
    let n = 12;
    let thinnest = 1e-6_f64;
    let height = |z: f64| {
        // Of [−1, 1], to which power of the thinnest layer.
        let share = (1.0 - z) / 2.0;
        if z <= -1.0 { 0.0 } else { thinnest.powf(share) }
    };
    let pieces = Pieces::cube(n, 0.0, |_| 0.0).moved(|p| DVec3::new(p.x, p.y, height(p.z)));
    let field = |p: DVec3| (1.0 + p.z / thinnest).ln() / (1.0 + 1.0 / thinnest).ln();
    let volume = Pieces::with_field(pieces.points, pieces.cells, field).volume();
    let view = parallel(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.0, 0.3), 1.2);
    case(
        "layers of aspect ratio up to 1e6",
        Shot::new(volume, plain(), view),
    )
}

/// An optical depth of 1e4 behind 1e-4, and the other way round.
fn dense_behind_thin() -> Case {
    let (thin, dense) = (1e-4, 1e4);
    let color = |x: f64| {
        if x > 0.0 {
            ORANGE
        } else {
            DVec3::new(0.1, 0.4, 0.8)
        }
    };
    let appearance = look(vec![
        knot(0.0, color(-1.0), dense),
        knot(0.5, color(-1.0), dense),
        knot(0.5, color(1.0), thin),
        knot(1.0, color(1.0), thin),
    ]);
    let shot = Shot::new(Pieces::cube(4, 0.2, along_x).volume(), appearance, down_x());
    Case::known(
        Group::Stiff,
        "a depth of 1e4 behind 1e-4",
        shot,
        move |_| {
            let front = one_color(color(1.0), thin);
            let behind = one_color(color(-1.0), dense);
            [0, 1, 2, 3].map(|c| front[c] + (1.0 - front[3]) * behind[c])
        },
    )
}
