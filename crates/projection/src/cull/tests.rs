//! Lists against what each cell says for itself.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::{Association, Scalars};
use tetrascope_core::{Knot, TetMesh, TransferFunction};
use tetrascope_f32::{Domain, ScalarMap};
use tetrascope_gpu::transfer_function::knot_pairs;

use super::*;
use crate::options::CellLayout;

/// A row of cells; each has the four scalars that `of` gives it, or the first.
fn row(association: Association, cells: u32, of: impl Fn(u32) -> [f64; 4]) -> TetMesh {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let corner = |cell: u32, i: usize| match (cell % 13, i) {
        // Flat.
        (7, 3) => corners[1] + corners[2] + f64::from(cell) * DVec3::X,
        _ => corners[i] + f64::from(cell) * DVec3::X,
    };
    let points = (0..cells).flat_map(|c| (0..4).map(move |i| corner(c, i)));
    let values = match association {
        Association::Point => (0..cells).flat_map(&of).collect(),
        Association::Cell => (0..cells).map(|c| of(c)[0]).collect(),
    };
    let scalars = Scalars {
        name: "s".into(),
        association,
        values,
    };
    let cells = (0..cells)
        .map(|c| [0, 1, 2, 3].map(|i| 4 * c + i))
        .collect();
    TetMesh::from_tetrahedra(points.collect(), cells, scalars).expect("valid")
}

/// Two ramps with nothing between, a step, and one color without extinction.
fn function() -> TransferFunction {
    let knot = |scalar, extinction, color: f64| Knot {
        scalar,
        color: DVec3::splat(color),
        extinction,
    };
    let knots = vec![
        knot(0.0, 0.0, 0.0),
        knot(1.0, 1.0, 1.0),
        knot(2.0, 0.0, 0.0),
        knot(4.0, 0.0, 0.0),
        knot(4.0, 3.0, 0.0),
        knot(5.0, 3.0, 0.0),
        knot(5.0, 0.0, 0.0),
        knot(6.0, 0.0, 0.5),
        knot(7.0, 0.0, 0.0),
    ];
    TransferFunction::new(knots).expect("sorted")
}

/// Quarters, so that f32 has them and many are on knots.
fn scalars(cell: u32) -> [f64; 4] {
    let start = f64::from(cell * 7 % 41) / 4.0 - 1.0;
    let step = f64::from(cell % 5) / 4.0;
    let last = if cell % 17 == 3 {
        f64::NAN
    } else {
        start + step
    };
    [start, start + step * 0.5, last, start]
}

/// Whether a cell shows, straight from the definition at the head of `cull.rs`.
fn is_shown(mesh: &TetMesh, cell: usize, model: OpticalModel, isovalues: &[f64]) -> bool {
    let values: [f64; 4] = mesh.cell_scalars(cell);
    let low = values.into_iter().fold(f64::INFINITY, f64::min);
    let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if cell % 13 == 7 || values.iter().any(|s| s.is_nan()) {
        return false;
    }
    // Inside of the cell: what it only touches does not count, unless it is constant.
    let inside = if low < high { 1e-6 } else { 0.0 };
    let (low_in, high_in) = (low + inside, high - inside);
    match model {
        OpticalModel::Isosurfaces => isovalues.iter().any(|v| low < *v && *v <= high),
        OpticalModel::MaximumIntensity => function().max_color(low_in, high_in) > 0.0,
        _ => function().max_extinction(low_in, high_in) > 0.0,
    }
}

#[test]
fn the_list_is_that_of_the_cells_that_show() {
    let Some(gpu) = tetrascope_testing::gpu("the_list_is_that_of_the_cells_that_show") else {
        return;
    };
    let isovalues = [3.25, 0.5, 5.0];
    // On one thread and on several.
    for cells in [1, 257, 70_001] {
        for association in [Association::Point, Association::Cell] {
            let mesh = row(association, cells, scalars);
            let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
            let map = ScalarMap::of_appearance(
                &tetrascope_core::Appearance::new(function(), OpticalModel::Emission),
                mesh.scalar_range(),
            );
            let layout = CellLayout::SharedVertices;
            let field = Field::upload(&gpu, &geometry, &mesh, map, layout).expect("it fits");
            let intervals = knot_pairs(&function(), &map, &geometry.normalization);
            let intervals = intervals.expect("few knots");
            for model in OpticalModel::ALL {
                let expected =
                    (0..mesh.cell_count()).filter(|cell| is_shown(&mesh, *cell, model, &isovalues));
                let expected: Vec<u32> = expected.map(|cell| cell as u32).collect();
                for pieces in [false, true] {
                    let culled = cull(
                        &gpu,
                        &Judged {
                            geometry: &geometry,
                            field: &field,
                            model,
                            intervals: &intervals,
                            isovalues: &isovalues.map(|v| map.scalar(v)),
                            pieces,
                        },
                        true,
                        None,
                    );
                    let (culled, listed) = culled.expect("it fits");
                    let (listed, starts) = (listed.cells, listed.starts);
                    let what = format!("{cells} {association:?} {model:?} {pieces}");
                    assert_eq!(listed[..], expected, "{what}");
                    assert_eq!(culled.cells as usize, expected.len(), "{what}");
                    let Some(starts) = starts else {
                        assert_eq!(culled.items, culled.cells, "{what}");
                        continue;
                    };
                    assert!(pieces);
                    assert_eq!(starts.len(), mesh.cell_count() + 1);
                    let many = |cell: usize| starts[cell + 1] - starts[cell];
                    for cell in 0..mesh.cell_count() {
                        let drawn = expected.binary_search(&(cell as u32)).is_ok();
                        assert_eq!(many(cell) > 0, drawn, "{what} {cell}");
                    }
                    assert_eq!(starts[mesh.cell_count()], culled.items, "{what}");
                }
            }
        }
    }
}

/// Buffers of an earlier list that stay are taken over, and nothing else.
#[test]
fn what_an_edit_leaves_as_it_was_is_kept() {
    let Some(gpu) = tetrascope_testing::gpu("what_an_edit_leaves_as_it_was_is_kept") else {
        return;
    };
    let mesh = row(Association::Point, 20_000, scalars);
    let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
    let model = OpticalModel::EmissionAbsorption;
    let map = ScalarMap::of(&function());
    let layout = CellLayout::SharedVertices;
    let field = Field::upload(&gpu, &geometry, &mesh, map, layout).expect("it fits");
    // The same, other colors, a knot elsewhere, and one more that shows.
    let edits: [fn(&mut Vec<Knot>); 4] = [
        |_| {},
        |knots| knots[1].color *= 0.5,
        |knots| knots[1].scalar = 1.25,
        |knots| knots[7].extinction = 1.0,
    ];
    for pieces in [false, true] {
        let made = |edit: fn(&mut Vec<Knot>), last| {
            let mut knots = function().knots().to_vec();
            edit(&mut knots);
            let edited = TransferFunction::new(knots).expect("sorted");
            let intervals = knot_pairs(&edited, &map, &geometry.normalization);
            let judged = Judged {
                geometry: &geometry,
                field: &field,
                model,
                intervals: &intervals.expect("few knots"),
                isovalues: &[],
                pieces,
            };
            cull(&gpu, &judged, true, last).expect("it fits")
        };
        let first = made(edits[0], None);
        for (index, edit) in edits.into_iter().enumerate() {
            let next = made(edit, Some((&first.0, &first.1)));
            let fresh = made(edit, None);
            let what = format!("edit {index}, pieces {pieces}");
            assert_eq!(next.0.ranges == first.0.ranges, index != 2, "{what}");
            let is_kept = index < if pieces { 2 } else { 3 };
            assert_eq!(next.0.pieces == first.0.pieces, is_kept, "{what}");
            assert_eq!(next.1.cells, fresh.1.cells, "{what}");
            assert_eq!(next.1.starts, fresh.1.starts, "{what}");
            assert_eq!(next.0.items, fresh.0.items, "{what}");
            // All lists follow from these.
            assert_eq!(next.0.verdicts, fresh.0.verdicts, "{what}");
            assert_eq!(next.0.in_pieces, fresh.0.in_pieces, "{what}");
            assert_eq!(next.0.in_parts, fresh.0.in_parts, "{what}");
            let room = next.0.drawn.size() / 4;
            assert!(room >= u64::from(next.0.items), "{what}");
        }
    }
}
