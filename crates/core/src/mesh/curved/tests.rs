use crate::Unit as _;
use glam::DVec3;

use super::form::Form;
use super::shapes::{Curved, Family};
use super::*;
use crate::TetMesh;
use std::collections::HashMap;

mod lagrange;
mod neighbors;

/// Where VTK has the nodes of each type, in steps of half an edge (`GetParametricCoords`).
const NODES: [(u8, &str); 8] = [
    (24, "000 200 020 002 100 110 010 001 101 011"),
    (25, HEXAHEDRON_20),
    (
        26,
        "000 200 020 002 202 022 100 110 010 102 112 012 001 201 021",
    ),
    (27, "000 200 220 020 002 100 210 120 010 001 201 221 021"),
    (29, HEXAHEDRON_27),
    (31, "000 200 020 002 202 022 100 110 010 102 112 012"),
    (
        32,
        "000 200 020 002 202 022 100 110 010 102 112 012 001 201 021 101 111 011",
    ),
    (33, HEXAHEDRON_24),
];

const HEXAHEDRON_20: &str =
    "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021";
const HEXAHEDRON_24: &str = "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021 011 211 101 121";
const HEXAHEDRON_27: &str = "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021 011 211 101 121 110 112 111";

/// The nodes of the reference cell; a pyramid's are those of a cube whose top is one point.
fn reference(cell_type: u8) -> Vec<DVec3> {
    let (_, nodes) = NODES.iter().find(|(t, _)| *t == cell_type).expect("a type");
    let digit = |c: u8| f64::from(c - b'0') / 2.0;
    let nodes = nodes.split(' ').map(|n| {
        let &[x, y, z] = n.as_bytes() else {
            panic!("three digits");
        };
        DVec3::new(digit(x), digit(y), digit(z))
    });
    match cell_type {
        // From VTK's square at every height to a pyramid over [0, 1]² with its top above the middle.
        27 => nodes
            .map(|p| {
                DVec3::new(
                    0.5 + (p.x - 0.5) * (1.0 - p.z),
                    0.5 + (p.y - 0.5) * (1.0 - p.z),
                    p.z,
                )
            })
            .collect(),
        _ => nodes.collect(),
    }
}

/// The kind of a cell of order 2.
fn kind(cell_type: u8) -> Curved {
    let nodes = reference(cell_type).len();
    let form = Form::of(cell_type, nodes, None).expect("an order");
    Curved::new(&form.expect("a curved type"))
}

/// The report of a cut into so many parts, as if there was no bound.
fn blank(parts: usize) -> CurvedReport {
    CurvedReport {
        cells: 1,
        parts,
        shape: 0.0,
        field: 0.0,
        is_kept: true,
        is_estimate: false,
        apart: 0,
        gap: 0.0,
        hanging: 0,
    }
}

/// A mesh cut into so many parts along each edge.
fn cut_into(
    parts: usize,
    points: Vec<DVec3>,
    cells: &Cells,
    scalars: Vec<Scalars>,
    extra: &Extra,
) -> Straightened {
    let forms = Forms::new(cells, extra).expect("they have forms");
    let cutter = Cutter::new(&forms, cells, extra, parts);
    cutter
        .cut(points, scalars, blank(parts))
        .expect("it is cut")
}

/// The tetrahedra of a mesh that was cut, with a field that is 0.
fn mesh_of(cut: Straightened) -> TetMesh {
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values: vec![0.0; cut.points.len()],
    };
    TetMesh::new(cut.points, &cut.cells, scalars).expect("a mesh")
}

/// The weights of the corners at a point of the reference cell.
fn shares(family: Family, p: DVec3) -> [f64; 8] {
    let [x, y, z] = p.to_array();
    let [u, v, w] = [1.0 - x, 1.0 - y, 1.0 - z];
    match family {
        Family::Tetrahedron => [1.0 - x - y - z, x, y, z, 0.0, 0.0, 0.0, 0.0],
        Family::Hexahedron => [
            u * v * w,
            x * v * w,
            x * y * w,
            u * y * w,
            u * v * z,
            x * v * z,
            x * y * z,
            u * y * z,
        ],
        Family::Wedge => {
            let b = 1.0 - x - y;
            [b * w, x * w, y * w, b * z, x * z, y * z, 0.0, 0.0]
        }
        Family::Pyramid => {
            let side = |t: f64| if w == 0.0 { 0.5 } else { 0.5 + (t - 0.5) / w };
            let [x, y] = [side(x), side(y)];
            let [u, v] = [1.0 - x, 1.0 - y];
            [u * v * w, x * v * w, x * y * w, u * y * w, z, 0.0, 0.0, 0.0]
        }
    }
}

/// A function with these values at the cell's nodes, at a point of the reference cell.
fn value(curved: &Curved, values: &[DVec3], p: DVec3) -> DVec3 {
    let functions = functions(curved, p);
    let full = curved.fill(values);
    functions.iter().zip(full).map(|(f, v)| v * *f).sum()
}

/// So where nodes have weights.
fn rational_value(curved: &Curved, values: &[DVec3], weights: &[f64], p: DVec3) -> DVec3 {
    let weighted = values.iter().zip(weights).map(|(v, w)| *v * *w);
    let weights = weights.iter().map(|w| DVec3::X * *w);
    let sum = value(curved, &weights.collect::<Vec<_>>(), p).x;
    value(curved, &weighted.collect::<Vec<_>>(), p) / sum
}

/// The functions of the full set at a point of the reference cell.
fn functions(curved: &Curved, p: DVec3) -> Vec<f64> {
    let shares = shares(curved.family, p);
    let scaled = |corners: &[usize], order: usize| {
        order as f64 * corners.iter().map(|&corner| shares[corner]).sum::<f64>()
    };
    curved.functions(&scaled)
}

/// Numbers in [−1, 1] that are as random as a sine makes them.
fn noise(seed: f64) -> f64 {
    let x = (seed * 12.9898).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

fn vector(seed: f64) -> DVec3 {
    DVec3::new(noise(seed), noise(seed + 0.37), noise(seed + 0.71))
}

/// One cell whose nodes are at `points`, with a scalar at each.
fn one(cell_type: u8, points: Vec<DVec3>, values: Vec<f64>) -> (Vec<DVec3>, Cells, Scalars) {
    let cells = Cells {
        types: vec![cell_type],
        offsets: vec![0, points.len() as u64],
        connectivity: (0..points.len() as u64).collect(),
    };
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values,
    };
    (points, cells, scalars)
}

#[test]
fn functions_are_one_at_their_node_and_zero_at_the_others() {
    for (cell_type, _) in NODES {
        let curved = kind(cell_type);
        let nodes = reference(cell_type);
        assert_eq!(nodes.len(), curved.nodes);
        for (i, &p) in nodes.iter().enumerate() {
            for j in 0..nodes.len() {
                let mut values = vec![DVec3::ZERO; nodes.len()];
                values[j] = DVec3::X;
                let expected = if i == j { 1.0 } else { 0.0 };
                let found = value(&curved, &values, p).x;
                assert!(
                    (found - expected).abs() < 1e-14,
                    "{cell_type}: {i} {j}: {found}"
                );
            }
        }
    }
}

#[test]
fn what_is_linear_stays_linear() {
    for (cell_type, _) in NODES {
        let curved = kind(cell_type);
        let nodes = reference(cell_type);
        for seed in 0..50 {
            let q = (vector(f64::from(seed)) + 1.0) / 2.0;
            let z = q.z * 0.999;
            let p = match curved.family {
                Family::Tetrahedron => q / 3.0,
                Family::Hexahedron => q,
                Family::Wedge => DVec3::new(q.x / 2.0, q.y / 2.0, z),
                Family::Pyramid => DVec3::new(
                    0.5 + (q.x - 0.5) * (1.0 - z),
                    0.5 + (q.y - 0.5) * (1.0 - z),
                    z,
                ),
            };
            // Some twenty products of numbers near 1.
            let off = (value(&curved, &nodes, p) - p).length();
            assert!(off < 1e-14, "{cell_type}: {p}: {off:e}");
        }
    }
}

/// The greatest difference between a function and its interpolants on parts, over the bound.
fn worst(cell_type: u8, parts: usize, seed: f64) -> f64 {
    let curved = kind(cell_type);
    let nodes = reference(cell_type);
    let values = (0..nodes.len()).map(|i| vector(seed + 3.1 * i as f64));
    let values: Vec<DVec3> = values.collect();
    let (points, cells, _) = one(cell_type, nodes, vec![]);
    let mesh = mesh_of(cut_into(parts, points, &cells, vec![], &Extra::default()));
    let bound = curved.bend(&values, None) / (parts * parts) as f64;
    sampled_difference(&mesh, &|p| value(&curved, &values, p)) / bound
}

/// The greatest difference between a function on a mesh and its interpolants on the tetrahedra.
fn sampled_difference(mesh: &TetMesh, function: &dyn Fn(DVec3) -> DVec3) -> f64 {
    let mut most = 0.0_f64;
    for cell in 0..mesh.cell_count() {
        let corners = mesh.cell_points(cell);
        let at = corners.map(function);
        for sample in 0..12 {
            let weights = [0, 1, 2, 3].map(|i| {
                (noise(at[0].x + 17.0 * f64::from(sample) + 5.3 * f64::from(i)) + 1.0).max(1e-9)
            });
            let sum: f64 = weights.iter().sum();
            let mix = |v: [DVec3; 4]| (0..4).map(|i| v[i] * (weights[i] / sum)).sum::<DVec3>();
            most = most.max((function(mix(corners)) - mix(at)).length());
        }
    }
    most
}

#[test]
fn the_bound_holds_and_is_near() {
    for (cell_type, _) in NODES {
        let is_estimate = cell_type == 27;
        let ratios =
            (0..6).flat_map(|seed| [1, 2, 3].map(|parts| worst(cell_type, parts, f64::from(seed))));
        let most = ratios.fold(0.0, f64::max);
        assert!(most <= 1.0, "{cell_type}: {most}");
        // A bound that is far from any error would cut cells in vain.
        assert!(is_estimate || most > 0.1, "{cell_type}: {most}");
    }
}

/// Nearly a ball: a hexahedron whose corners and nodes on edges and faces lie on the sphere.
fn ball() -> (Vec<DVec3>, Cells, Scalars) {
    let nodes = reference(29).into_iter().map(|p| {
        let q = 2.0 * p - 1.0;
        if q == DVec3::ZERO { q } else { q.unit() }
    });
    let points: Vec<DVec3> = nodes.collect();
    let values = points.iter().map(|p| p.x).collect();
    one(29, points, values)
}

#[test]
fn the_tolerance_is_kept_and_said() {
    let (points, cells, scalars) = ball();
    let mut before = 0;
    for tolerance in [0.2, 0.05, 0.02] {
        let cut = straighten(
            points.clone(),
            cells.clone(),
            vec![scalars.clone()],
            &Extra::default(),
            Straightening::to(tolerance),
        )
        .expect("it is cut");
        let report = cut.report.expect("there is a curved cell");
        assert!(
            report.is_kept && report.shape.max(report.field) <= tolerance * (1.0 + 1e-12),
            "{report:?}"
        );
        assert!(report.parts > before, "{report:?}");
        before = report.parts;
        assert_eq!(cut.cells.types, vec![12; report.parts.pow(3)]);
        assert_eq!(cut.scalars[0].values.len(), cut.points.len());
        let text = report.to_string();
        assert!(
            text.starts_with("1 curved cell is cut into") && text.contains("at most"),
            "{text}"
        );
    }
    let cut = straighten(
        points,
        cells,
        vec![scalars],
        &Extra::default(),
        Straightening::to(1e-6),
    )
    .expect("it is cut");
    let report = cut.report.expect("there is a curved cell");
    assert!(!report.is_kept && report.parts == MOST_PARTS, "{report:?}");
    assert!(
        report
            .to_string()
            .ends_with("finer parts would be too many")
    );
}

#[test]
fn volumes_converge_at_second_order() {
    // The map of a triquadratic cell is a polynomial: its volume is that of very fine parts.
    let volume = |parts: usize| {
        let (points, cells, _) = ball();
        mesh_of(cut_into(parts, points, &cells, vec![], &Extra::default())).volume()
    };
    // The limit of a sequence whose errors fall by 4: (4 v₁₆ − v₈) / 3, off by a hundredth of v₁₆'s error.
    let limit = (4.0 * volume(16) - volume(8)) / 3.0;
    let errors = [1, 2, 4, 8].map(|parts| (volume(parts) - limit).abs());
    // Coarse parts of so bent a cell are not there yet.
    let ratio = errors[2] / errors[3];
    assert!((3.6..4.4).contains(&ratio), "{errors:?}");
}

#[test]
fn straight_cells_and_cell_data_go_through() {
    let (mut points, mut cells, _) = one(24, reference(24), vec![]);
    points.push(DVec3::ONE);
    cells.types.push(10);
    cells.connectivity.extend([1, 2, 3, 10]);
    cells.offsets.push(14);
    let of_cells = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values: vec![7.0, 9.0],
    };
    let of_points = Scalars {
        name: "p".into(),
        association: Association::Point,
        values: points.iter().map(|p| p.x * p.x).collect(),
    };
    let cut = straighten(
        points,
        cells,
        vec![of_cells, of_points],
        &Extra::default(),
        Straightening::to(0.1),
    )
    .expect("it is cut");
    let report = cut.report.expect("there is a curved cell");
    // 3/16 of x² along an edge, whose second difference is 2, over a range of 1: 0.375/n² ≤ 0.1.
    assert_eq!((report.cells, report.parts), (1, 2));
    assert_eq!(report.shape, 0.0);
    assert!((report.field - 0.375 / 4.0).abs() < 1e-12, "{report:?}");
    assert_eq!(cut.cells.types, vec![10; 9]);
    assert_eq!(cut.cells.connectivity[32..], [1, 2, 3, 10]);
    assert_eq!(
        cut.scalars[0].values,
        [[7.0; 8].as_slice(), &[9.0]].concat()
    );
    // With two parts every point of the lattice is a node.
    assert_eq!(cut.points.len(), 11);
}

#[test]
fn values_that_are_none_stay_where_they_are() {
    let (points, cells, mut scalars) = one(24, reference(24), vec![1.0; 10]);
    scalars.values[0] = f64::NAN;
    scalars.values[1] = 1e308;
    scalars.values[2] = -1e308;
    let cut = straighten(
        points,
        cells,
        vec![scalars],
        &Extra::default(),
        Straightening::to(1e-2),
    )
    .expect("it is cut");
    let values = &cut.scalars[0].values;
    // On the face opposite to the corner without a value it is not used.
    for (point, value) in cut.points.iter().zip(values) {
        let on_face = (point.x + point.y + point.z - 1.0).abs() < 1e-9;
        assert!(!on_face || value.is_finite(), "{point}: {value}");
    }
}

#[test]
fn wrong_input_is_refused() {
    let (points, cells, scalars) = one(24, reference(24), vec![0.0; 10]);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = straighten(
            points.clone(),
            cells.clone(),
            vec![scalars.clone()],
            &Extra::default(),
            Straightening::to(tolerance),
        );
        assert!(
            refused
                .expect_err("not a tolerance")
                .to_string()
                .contains("a tolerance of")
        );
    }
    let short = Cells {
        types: vec![24],
        offsets: vec![0, 4],
        connectivity: vec![0, 1, 2, 3],
    };
    let error = straighten(
        points.clone(),
        short,
        vec![],
        &Extra::default(),
        Straightening::to(0.1),
    )
    .expect_err("four points");
    assert!(error.to_string().contains("it must have 10"), "{error}");
    let one_value = Scalars {
        values: vec![0.0],
        ..scalars
    };
    let mut beyond = cells.clone();
    beyond.connectivity[9] = 10;
    let error = straighten(
        points.clone(),
        beyond,
        vec![],
        &Extra::default(),
        Straightening::to(0.1),
    )
    .expect_err("no such point");
    assert!(error.to_string().contains("10"), "{error}");
    let bad_offsets = Cells {
        offsets: vec![0, 12],
        ..cells.clone()
    };
    assert!(
        straighten(
            points.clone(),
            bad_offsets,
            vec![],
            &Extra::default(),
            Straightening::to(0.1)
        )
        .is_err()
    );
    let error = straighten(
        points.clone(),
        cells.clone(),
        vec![one_value],
        &Extra::default(),
        Straightening::to(0.1),
    );
    let error = error.expect_err("one value").to_string();
    assert_eq!(error, "field 's' has 1 values for 10 points");
    let mut infinite = points;
    infinite[7].y = f64::INFINITY;
    let error = straighten(
        infinite,
        cells,
        vec![],
        &Extra::default(),
        Straightening::to(0.1),
    )
    .expect_err("infinite");
    assert!(error.to_string().contains('7'), "{error}");
}

#[test]
fn a_mesh_without_curved_cells_stays_as_it_is() {
    let (points, cells, scalars) = one(
        10,
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        vec![0.0; 4],
    );
    let same = straighten(
        points.clone(),
        cells.clone(),
        vec![scalars.clone()],
        &Extra::default(),
        Straightening::to(0.1),
    )
    .expect("it stays");
    assert_eq!(
        same,
        Straightened {
            points,
            cells,
            scalars: vec![scalars],
            report: None
        }
    );
}

#[test]
fn functions_are_those_of_vtk() {
    // InterpolateFunctions of VTK 9.7.2 at (0.3, 0.2, 0.4), with cos i at node i; pyramids are others.
    let known = [
        (24, -0.19002128298721638),
        (25, -0.723611890978805),
        (26, 0.8488951110407007),
        (29, -0.01053843781161412),
        (31, 0.12960911684803325),
        (32, -0.7459539136494584),
        (33, -0.8873967160775115),
    ];
    for (cell_type, expected) in known {
        let curved = kind(cell_type);
        let nodes = (0..curved.nodes).map(|i| DVec3::X * (i as f64).cos());
        let nodes: Vec<DVec3> = nodes.collect();
        let found = value(&curved, &nodes, DVec3::new(0.3, 0.2, 0.4)).x;
        // Some thirty products of numbers below 1.
        assert!(
            (found - expected).abs() < 1e-14,
            "{cell_type}: {found} {expected}"
        );
    }
}
