use crate::Unit as _;
use glam::DVec3;

use super::shapes::{Curved, Family};
use super::*;
use crate::TetMesh;

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
    let functions = curved.family.functions(&shares(curved.family, p));
    let full = curved.fill(values);
    functions.iter().zip(full).map(|(f, v)| v * *f).sum()
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
        let curved = Curved::of(cell_type).expect("a curved type");
        let nodes = reference(cell_type);
        assert_eq!(nodes.len(), curved.nodes());
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
        let curved = Curved::of(cell_type).expect("a curved type");
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
    let curved = Curved::of(cell_type).expect("a curved type");
    let nodes = reference(cell_type);
    let values: Vec<DVec3> = (0..nodes.len())
        .map(|i| vector(seed + 3.1 * i as f64))
        .collect();
    let kinds = HashMap::from([(cell_type, curved.clone())]);
    let report = CurvedReport {
        cells: 1,
        parts,
        shape: 0.0,
        field: 0.0,
        is_kept: true,
        is_estimate: false,
    };
    let (points, cells, scalars) = one(cell_type, nodes, vec![0.0; values.len()]);
    let cut = Cutter::new(&kinds, parts)
        .cut(points, &cells, vec![], report)
        .expect("it is cut");
    let zeros = Scalars {
        values: vec![0.0; cut.points.len()],
        ..scalars
    };
    let mesh = TetMesh::new(cut.points, &cut.cells, zeros).expect("a mesh");
    let bound = curved.bend(&values) / (parts * parts) as f64;
    let mut most = 0.0_f64;
    for cell in 0..mesh.cell_count() {
        let corners = mesh.cell_points(cell);
        let at = corners.map(|p| value(&curved, &values, p));
        for sample in 0..12 {
            let weights = [0, 1, 2, 3].map(|i| {
                (noise(seed + 17.0 * f64::from(sample) + 5.3 * f64::from(i)) + 1.0).max(1e-9)
            });
            let sum: f64 = weights.iter().sum();
            let mix = |v: [DVec3; 4]| (0..4).map(|i| v[i] * (weights[i] / sum)).sum::<DVec3>();
            most = most.max((value(&curved, &values, mix(corners)) - mix(at)).length());
        }
    }
    most / bound
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

/// Curved cells that are neighbors, bent by a smooth map: of every family without nodes in faces, or
/// a hexahedron and wedges with such nodes, which pyramids and tetrahedra do not have.
fn mixed(bend: f64, in_faces: bool) -> (Vec<DVec3>, Cells) {
    let mut points: Vec<DVec3> = Vec::new();
    let mut known: HashMap<[u64; 3], u64> = HashMap::new();
    let mut cells = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    let map = |p: DVec3| {
        p + bend
            * DVec3::new(
                (2.0 * p.y).sin() * p.z,
                (1.5 * p.x).cos() * p.z,
                (p.x * p.y).sin(),
            )
    };
    let mut add = |cell_type: u8, corners: &[DVec3]| {
        // Nodes of straight reference cells, moved to these corners.
        let curved = Curved::of(cell_type).expect("a curved type");
        for p in reference(cell_type) {
            let at: DVec3 = corners
                .iter()
                .zip(shares(curved.family, p))
                .map(|(c, w)| *c * w)
                .sum();
            let key = at.to_array().map(|x| (x * 64.0).round() as u64);
            let point = *known.entry(key).or_insert_with(|| {
                points.push(map(at));
                points.len() as u64 - 1
            });
            cells.connectivity.push(point);
        }
        cells.types.push(cell_type);
        cells.offsets.push(cells.connectivity.len() as u64);
    };
    let cube = |x: f64| {
        [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
        ]
        .map(|p: [u8; 3]| DVec3::new(x + f64::from(p[0]), f64::from(p[1]), f64::from(p[2])))
    };
    // A hexahedron, two wedges on its side, and six pyramids around the middle of a third cube.
    let [hexahedron, wedge] = if in_faces { [29, 32] } else { [25, 26] };
    add(hexahedron, &cube(0.0));
    let c = cube(1.0);
    // The face x = 1 is a quadrilateral of the first wedge, and x = 2 one of the second.
    add(wedge, &[c[0], c[3], c[1], c[4], c[7], c[5]]);
    add(wedge, &[c[2], c[1], c[3], c[6], c[5], c[7]]);
    if in_faces {
        return (points, cells);
    }
    let d = cube(2.0);
    let top = DVec3::new(2.5, 0.5, 0.5);
    for face in [
        [0, 4, 7, 3],
        [1, 2, 6, 5],
        [0, 1, 5, 4],
        [3, 7, 6, 2],
        [0, 3, 2, 1],
        [4, 5, 6, 7],
    ] {
        // Counterclockwise from outside, so clockwise from the top: VTK's base is the other way round.
        let [a, b, e, f] = face.map(|corner| d[corner]);
        add(27, &[f, e, b, a, top]);
    }
    // A pyramid on the hexahedron, and a tetrahedron on its side.
    let apex = DVec3::new(0.5, 0.5, 2.0);
    add(
        27,
        &[
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
            apex,
        ],
    );
    add(
        24,
        &[
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            apex,
            DVec3::new(2.0, 0.5, 2.0),
        ],
    );
    (points, cells)
}

#[test]
fn parts_of_neighbors_of_every_kind_meet() {
    // Free quadrilaterals: four of the hexahedron, one of each wedge, five of the third cube; or five,
    // one and two. Free triangles: four of the wedges, three of the pyramid on top, three of the
    // tetrahedron; or four. All other faces have two cells.
    for (in_faces, quadrilaterals, triangles) in
        [(false, 4 + 2 + 5, 4 + 3 + 3), (true, 5 + 1 + 2, 4)]
    {
        let (points, cells) = mixed(0.07, in_faces);
        let kinds = cells
            .types
            .iter()
            .map(|&t| (t, Curved::of(t).expect("curved")));
        let kinds: HashMap<u8, Curved> = kinds.collect();
        for parts in 1..=4 {
            let report = CurvedReport {
                cells: 0,
                parts,
                shape: 0.0,
                field: 0.0,
                is_kept: true,
                is_estimate: true,
            };
            let cut = Cutter::new(&kinds, parts)
                .cut(points.clone(), &cells, vec![], report)
                .expect("it is cut");
            let scalars = Scalars {
                name: "s".into(),
                association: Association::Point,
                values: vec![0.0; cut.points.len()],
            };
            let mesh = TetMesh::new(cut.points, &cut.cells, scalars).expect("a mesh");
            let free = (2 * quadrilaterals + triangles) * parts * parts;
            assert_eq!(mesh.boundary_faces().len(), free, "{parts}");
            assert!(mesh.boundary_statistics().closed, "{parts}");
            assert_eq!(mesh.report().coincident_points, 0);
            assert_eq!((mesh.report().flipped, mesh.report().unused_points), (0, 0));
        }
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
    let cut = straighten(points, cells, vec![scalars], Straightening::to(1e-6)).expect("it is cut");
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
        let (points, cells, scalars) = ball();
        let kinds = HashMap::from([(29, Curved::of(29).expect("curved"))]);
        let report = CurvedReport {
            cells: 1,
            parts,
            shape: 0.0,
            field: 0.0,
            is_kept: true,
            is_estimate: false,
        };
        let cut = Cutter::new(&kinds, parts)
            .cut(points, &cells, vec![scalars], report)
            .expect("it is cut");
        let scalars = cut.scalars.into_iter().next().expect("one field");
        TetMesh::new(cut.points, &cut.cells, scalars)
            .expect("a mesh")
            .volume()
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
    let cut = straighten(points, cells, vec![scalars], Straightening::to(1e-2)).expect("it is cut");
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
    let error =
        straighten(points.clone(), short, vec![], Straightening::to(0.1)).expect_err("four points");
    assert!(error.to_string().contains("it must have 10"), "{error}");
    let one_value = Scalars {
        values: vec![0.0],
        ..scalars
    };
    let mut beyond = cells.clone();
    beyond.connectivity[9] = 10;
    let error = straighten(points.clone(), beyond, vec![], Straightening::to(0.1))
        .expect_err("no such point");
    assert!(error.to_string().contains("10"), "{error}");
    let bad_offsets = Cells {
        offsets: vec![0, 12],
        ..cells.clone()
    };
    assert!(straighten(points.clone(), bad_offsets, vec![], Straightening::to(0.1)).is_err());
    let error = straighten(
        points.clone(),
        cells.clone(),
        vec![one_value],
        Straightening::to(0.1),
    );
    let error = error.expect_err("one value").to_string();
    assert_eq!(error, "field 's' has 1 values for 10 points");
    let mut infinite = points;
    infinite[7].y = f64::INFINITY;
    let error = straighten(infinite, cells, vec![], Straightening::to(0.1)).expect_err("infinite");
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
        let curved = Curved::of(cell_type).expect("a curved type");
        let nodes = (0..curved.nodes()).map(|i| DVec3::X * (i as f64).cos());
        let nodes: Vec<DVec3> = nodes.collect();
        let found = value(&curved, &nodes, DVec3::new(0.3, 0.2, 0.4)).x;
        // Some thirty products of numbers below 1.
        assert!(
            (found - expected).abs() < 1e-14,
            "{cell_type}: {found} {expected}"
        );
    }
}
