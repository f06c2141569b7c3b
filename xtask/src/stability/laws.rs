//! Laws of physics about two pictures or more.

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::{Appearance, Camera, OpticalModel, TransferFunction, View, Volume};
use tetrascope_testing::{Random, knot, kuhn};

use super::case::{Case, Group, Shot};
use super::scenes::{Pieces, along_x, look, parallel, plain, slope, under, waves, whole};

pub(super) fn cases() -> Vec<Case> {
    vec![
        rigid_motion(),
        mirror_image(),
        permutations(),
        orientations(),
        slivers_put_in(),
        splitting(),
        refinement(),
        cell_values(),
        field_in_other_units(),
        knots_that_change_nothing(),
        white_furnace(),
        energy(),
        colors_that_complete_each_other(),
        front_to_back(OpticalModel::Emission),
        front_to_back(OpticalModel::Absorption),
        powers_of_transmittance(),
        monotone_maximum(),
        halves(),
        backgrounds(),
    ]
}

fn same(name: &str, shots: impl Into<Vec<Shot>>) -> Case {
    Case::same(Group::Laws, name, shots.into())
}

/// These meshes look alike from a corner of the first.
fn alike(name: &str, pieces: impl IntoIterator<Item = Pieces>) -> Case {
    let volumes: Vec<Volume> = pieces.into_iter().map(Pieces::volume).collect();
    let view = whole(&volumes[0]);
    let shots = volumes
        .into_iter()
        .map(|volume| Shot::new(volume, plain(), view));
    same(name, shots.collect::<Vec<_>>())
}

/// These appearances look alike on a mesh of `field`.
fn alike_looks(name: &str, looks: impl IntoIterator<Item = Appearance>) -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = whole(&volume);
    let shots = looks
        .into_iter()
        .map(|look| Shot::new(volume.clone(), look, view));
    same(name, shots.collect::<Vec<_>>())
}

fn moved(view: &View, to: impl Fn(DVec3) -> DVec3) -> View {
    let camera = view.camera;
    let [position, focal_point] = [camera.position, camera.focal_point].map(&to);
    View {
        camera: Camera {
            position,
            focal_point,
            view_up: to(camera.view_up) - to(DVec3::ZERO),
            ..camera
        },
        ..*view
    }
}

fn rigid_motion() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let view = whole(&pieces.clone().volume());
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, -0.48, 0.64), 2.1);
    let to = move |p: DVec3| turn * p + DVec3::new(3.0, -7.0, 11.0);
    let shots = [
        Shot::new(pieces.clone().volume(), plain(), view),
        Shot::new(pieces.moved(to).volume(), plain(), moved(&view, to)),
    ];
    same("turned and moved", shots)
}

fn mirror_image() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let view = whole(&pieces.clone().volume());
    let to = |p: DVec3| DVec3::new(-p.x, p.y, p.z);
    let mirrored = Shot {
        mirrored: true,
        ..Shot::new(pieces.clone().moved(to).volume(), plain(), moved(&view, to))
    };
    same(
        "mirrored",
        [Shot::new(pieces.volume(), plain(), view), mirrored],
    )
}

/// Cells, cells' corners and points in another order.
fn permutations() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let mut random = Random(0x0123_4567_89ab_cdef);
    let mut shuffled = |count: usize| {
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            order.swap(i, random.bits() as usize % (i + 1));
        }
        order
    };
    let mut other_cells = pieces.clone();
    other_cells.cells = shuffled(pieces.cells.len())
        .into_iter()
        .map(|i| pieces.cells[i])
        .collect();
    for cell in &mut other_cells.cells {
        cell.rotate_left(1);
    }
    let order = shuffled(pieces.points.len());
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new as u32;
    }
    let other_points = Pieces {
        points: order.iter().map(|&i| pieces.points[i]).collect(),
        values: order.iter().map(|&i| pieces.values[i]).collect(),
        cells: pieces
            .cells
            .iter()
            .map(|cell| cell.map(|p| place[p as usize]))
            .collect(),
    };
    alike(
        "cells and points in another order",
        [pieces, other_cells, other_points],
    )
    .for_each()
}

fn orientations() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let mut turned = pieces.clone();
    for cell in turned.cells.iter_mut().step_by(2) {
        cell.swap(0, 3);
    }
    alike("cells' orientation", [pieces, turned]).for_each()
}

/// A flat cell in the middle of each edge's cells: between two cells, along the edge that they share.
fn slivers_put_in() -> Case {
    let pieces = Pieces::cube(3, 0.2, waves);
    let mut more = pieces.clone();
    for cell in &pieces.cells {
        // Flat: the fourth corner is in the middle of the first edge, and is a point of its own.
        let [a, b, c, d] = *cell;
        let middle = more.points.len() as u32;
        let [p, q] = [a, b].map(|i| i as usize);
        more.points
            .push((pieces.points[p] + pieces.points[q]) / 2.0);
        more.values
            .push((pieces.values[p] + pieces.values[q]) / 2.0);
        more.cells.push([a, b, c, middle]);
        more.cells.push([a, b, d, middle]);
    }
    alike("cells without volume put in", [pieces, more])
}

/// Each cell in four around its middle; values are linear in it all the same.
fn splitting() -> Case {
    let pieces = Pieces::cube(3, 0.2, waves);
    let mut split = pieces.clone();
    split.cells.clear();
    for cell in &pieces.cells {
        let corners = cell.map(|p| p as usize);
        let middle = split.points.len() as u32;
        let sum: DVec3 = corners.iter().map(|&p| pieces.points[p]).sum();
        split.points.push(sum / 4.0);
        split
            .values
            .push(corners.iter().map(|&p| pieces.values[p]).sum::<f64>() / 4.0);
        for left_out in 0..4 {
            let mut part = *cell;
            part[left_out] = middle;
            split.cells.push(part);
        }
    }
    alike("each cell in four", [pieces, split])
}

fn refinement() -> Case {
    alike(
        "finer cells of a linear field",
        [2, 4, 6].map(|n| Pieces::cube(n, 0.0, slope)),
    )
}

/// One value a cell, and the same value at each of its own corners.
fn cell_values() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let values: Vec<f64> = (0..pieces.cells.len())
        .map(|i| (i % 7) as f64 / 7.0)
        .collect();
    let own = Pieces {
        points: pieces
            .cells
            .iter()
            .flatten()
            .map(|&p| pieces.points[p as usize])
            .collect(),
        cells: (0..pieces.cells.len() as u32)
            .map(|i| [0, 1, 2, 3].map(|c| 4 * i + c))
            .collect(),
        values: values.iter().flat_map(|v| [*v; 4]).collect(),
    };
    let volumes = [pieces.with_cell_values(values), own.volume()];
    let shots = volumes.map(|volume| {
        let view = whole(&volume);
        Shot::new(volume, plain(), view)
    });
    same("values of cells and of their own corners", shots)
}

/// In other units, with another sign.
fn field_in_other_units() -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let view = whole(&pieces.clone().volume());
    let shots = [(1.0, 0.0), (1.8, 32.0), (-1.0, 0.0)].map(|(factor, offset)| {
        let mut pieces = pieces.clone();
        for scalar in &mut pieces.values {
            *scalar = offset + factor * *scalar;
        }
        let mut knots = plain().transfer_function.knots().to_vec();
        for knot in &mut knots {
            knot.scalar = offset + factor * knot.scalar;
        }
        if factor < 0.0 {
            knots.reverse();
        }
        Shot::new(pieces.volume(), look(knots), view)
    });
    // With the sign the greatest becomes the least.
    same("the field in other units", shots)
        .for_each()
        .in_its_model()
}

fn knots_that_change_nothing() -> Case {
    let knots = plain().transfer_function.knots().to_vec();
    let function = TransferFunction::new(knots.clone()).expect("valid knots");
    let mut more = knots.clone();
    for scalar in [0.1, 0.2, 0.5, 0.93] {
        let (color, extinction) = function.sample(scalar).expect("a value");
        more.push(knot(scalar, color, extinction));
    }
    more.sort_by(|a, b| a.scalar.total_cmp(&b.scalar));
    alike_looks("knots between knots", [look(knots), look(more)]).for_each()
}

/// White before white is white, whatever the extinction (numerics: the white furnace).
fn white_furnace() -> Case {
    let mut knots = plain().transfer_function.knots().to_vec();
    for knot in &mut knots {
        knot.color = DVec3::ONE;
    }
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = View {
        background: [1.0; 4],
        ..whole(&volume)
    };
    let shot = Shot::new(volume, look(knots), view);
    Case::known(Group::Laws, "white before white", shot, |_| [1.0; 4]).for_all()
}

/// No more light than what hides what is behind it could send, and no opacity above 1.
fn energy() -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = whole(&volume);
    Case::law(
        "light within opacity",
        vec![Shot::new(volume, plain(), view)],
        |pixels| {
            let [r, g, b, a] = pixels[0];
            let beyond = |c: f64| (c - a).max(-c).max(0.0);
            [beyond(r), beyond(g), beyond(b), (a - 1.0).max(0.0)]
        },
        2.0,
    )
}

/// Colors c and 1 − c sum to white light of the same opacity.
fn colors_that_complete_each_other() -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = whole(&volume);
    let knots = plain().transfer_function.knots().to_vec();
    let mut others = knots.clone();
    for knot in &mut others {
        knot.color = DVec3::ONE - knot.color;
    }
    let shots = [knots, others].map(|knots| Shot::new(volume.clone(), look(knots), view));
    Case::law(
        "colors that add up to white",
        shots.into(),
        |pixels| {
            [0, 1, 2, 3].map(|c| match c {
                3 => pixels[0][3] - pixels[1][3],
                _ => pixels[0][c] + pixels[1][c] - pixels[0][3],
            })
        },
        3.0,
    )
}

/// A medium in which nothing hides looks the same from behind.
fn front_to_back(model: OpticalModel) -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let from = DVec3::new(2.0, 3.0, 2.5);
    let shots = [from, -from].map(|from| {
        let view = parallel(from, DVec3::ZERO, 1.75);
        Shot {
            mirrored: from.x < 0.0,
            ..Shot::new(volume.clone(), under(model, plain()), view)
        }
    });
    // Up stays up: seen from behind, left and right change places, and above and below do not only if
    // the camera is level. This one is not, so it is turned upside down, which the rows show.
    let [front, mut back] = shots;
    let up = front.view.camera.axes().1;
    back.view.camera.view_up = up;
    same(&format!("front to back in {}", model.name()), [front, back])
}

/// Three times the extinction lets the third power of the light through.
fn powers_of_transmittance() -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = whole(&volume);
    let shots = [1.0, 3.0].map(|k| {
        let mut knots = plain().transfer_function.knots().to_vec();
        for knot in &mut knots {
            knot.extinction *= k;
        }
        Shot::new(
            volume.clone(),
            under(OpticalModel::Absorption, look(knots)),
            view,
        )
    });
    Case::law(
        "three times the extinction",
        shots.into(),
        |pixels| {
            [
                0.0,
                0.0,
                0.0,
                (1.0 - pixels[0][3]).powi(3) - (1.0 - pixels[1][3]),
            ]
        },
        4.0,
    )
}

/// More cells never lower the greatest value, whose colors here rise with it.
fn monotone_maximum() -> Case {
    let keep = |c: [usize; 3]| c[0] != 2;
    let (points, cells) = kuhn(4, DVec3::NEG_ONE, DVec3::ONE, keep);
    let part = Pieces::with_field(points, cells, waves);
    let pieces = Pieces::cube(4, 0.0, waves);
    let view = whole(&pieces.clone().volume());
    let rising = look(vec![
        knot(0.0, [0.0; 3], 1.0),
        knot(1.0, [1.0, 0.7, 0.4], 1.0),
    ]);
    let shots = [part, pieces].map(|pieces| {
        let appearance = under(OpticalModel::MaximumIntensity, rising.clone());
        Shot::new(pieces.volume(), appearance, view)
    });
    Case::law(
        "more cells, no lower maximum",
        shots.into(),
        |pixels| [0, 1, 2, 3].map(|c| (pixels[0][c] - pixels[1][c]).max(0.0)),
        2.0,
    )
}

/// The half in front over the one behind is the whole.
fn halves() -> Case {
    let cube = Pieces::cube(4, 0.0, waves);
    let half = |in_front: bool| {
        let mut pieces = cube.clone();
        let points = cube.points.clone();
        let is_in = |cell: &[u32; 4]| {
            let x: f64 = cell
                .iter()
                .map(|&p| along_x(points[p as usize]) - 0.5)
                .sum();
            (x > 0.0) == in_front
        };
        pieces.cells.retain(is_in);
        pieces
    };
    let view = parallel(DVec3::new(3.0, 0.5, 0.7), DVec3::ZERO, 1.6);
    let shots = [cube.clone(), half(true), half(false)];
    let shots = shots.map(|pieces| Shot::new(pieces.volume(), plain(), view));
    Case::law(
        "one half over the other",
        shots.into(),
        |pixels| {
            [0, 1, 2, 3].map(|c| pixels[0][c] - pixels[1][c] - (1.0 - pixels[1][3]) * pixels[2][c])
        },
        3.0,
    )
}

/// A background shines through by what is not hidden.
fn backgrounds() -> Case {
    let volume = Pieces::cube(4, 0.2, waves).volume();
    let view = whole(&volume);
    let backgrounds = [[0.0; 4], [0.25, 0.5, 0.75, 0.5]];
    let shots = backgrounds
        .map(|background| Shot::new(volume.clone(), plain(), View { background, ..view }));
    Case::law(
        "a background behind",
        shots.into(),
        |pixels| {
            let behind = [0.125, 0.25, 0.375, 0.5];
            [0, 1, 2, 3].map(|c| pixels[1][c] - pixels[0][c] - (1.0 - pixels[0][3]) * behind[c])
        },
        3.0,
    )
}
