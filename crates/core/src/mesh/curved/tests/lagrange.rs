use super::super::form::Basis;
use super::*;

/// Lagrange cells of these orders along their axes, or Bézier ones.
fn curved(family: Family, basis: Basis, orders: [usize; 3]) -> (u8, Curved) {
    let [p, q, r] = orders;
    let (nodes, lagrange) = match family {
        Family::Tetrahedron => ((p + 1) * (p + 2) * (p + 3) / 6, 71),
        Family::Wedge => ((p + 1) * (p + 2) / 2 * (r + 1), 73),
        _ => ((p + 1) * (q + 1) * (r + 1), 72),
    };
    let cell_type = match (basis, family) {
        (Basis::Lagrange, _) => lagrange,
        (Basis::Bernstein, Family::Tetrahedron) => 78,
        (Basis::Bernstein, Family::Wedge) => 80,
        (Basis::Bernstein, _) => 79,
    };
    let degrees = orders.map(|order| order as f64);
    let form = Form::of(cell_type, nodes, Some(degrees)).expect("an order");
    (cell_type, Curved::new(&form.expect("it is cut")))
}

const HEXAHEDRA: [[usize; 3]; 9] = [
    [1; 3],
    [2; 3],
    [3; 3],
    [4; 3],
    [5; 3],
    [6; 3],
    [1, 2, 3],
    [6, 1, 4],
    [3, 5, 2],
];

/// All orders of each family, and some that differ along the axes.
fn all(basis: Basis) -> Vec<(u8, Curved)> {
    let tetrahedra = (1..=6).map(|order| curved(Family::Tetrahedron, basis, [order; 3]));
    let hexahedra = HEXAHEDRA.map(|orders| curved(Family::Hexahedron, basis, orders));
    let wedges = [
        [1, 1],
        [2, 2],
        [3, 3],
        [4, 4],
        [5, 5],
        [6, 6],
        [2, 3],
        [5, 1],
        [1, 4],
    ];
    let wedges = wedges.map(|[p, r]| curved(Family::Wedge, basis, [p, p, r]));
    tetrahedra.chain(hexahedra).chain(wedges).collect()
}

/// The corners of a reference cell.
fn corners(family: Family) -> Vec<DVec3> {
    reference(match family {
        Family::Tetrahedron => 24,
        Family::Hexahedron => 25,
        Family::Wedge => 26,
        Family::Pyramid => 27,
    })
}

/// Where the nodes of a cell lie in its reference cell.
fn nodes_of(curved: &Curved) -> Vec<DVec3> {
    let corners = corners(curved.family);
    let place = |node: &Vec<(usize, u64)>| {
        node.iter()
            .map(|&(corner, weight)| corners[corner] * (weight as f64 / 216_000.0))
            .sum()
    };
    curved.node_places().iter().map(place).collect()
}

/// A mesh of one cell, with what says its orders.
fn alone(cell_type: u8, curved: &Curved, points: Vec<DVec3>) -> (Vec<DVec3>, Cells, Extra) {
    let orders: Vec<f64> = curved
        .factors
        .iter()
        .map(|f| f.simplex.order as f64)
        .collect();
    let degrees = match *orders {
        [p] => [p; 3],
        [p, r] => [p, p, r],
        _ => [orders[0], orders[1], orders[2]],
    };
    let (points, cells, _) = one(cell_type, points, vec![]);
    let extra = Extra {
        degrees: vec![degrees],
        weights: Vec::new(),
    };
    (points, cells, extra)
}

#[test]
fn lagrange_functions_are_one_at_their_node_and_zero_at_the_others() {
    for (cell_type, curved) in all(Basis::Lagrange) {
        let nodes = nodes_of(&curved);
        let numbers = (0..nodes.len()).map(|i| DVec3::new(i as f64, (i * i) as f64, 1.0));
        let numbers: Vec<DVec3> = numbers.collect();
        for (number, &node) in numbers.iter().zip(&nodes) {
            let off = (value(&curved, &numbers, node) - *number)
                .abs()
                .max_element();
            // The functions' rounding, 1e-15, times the sum of squares of up to 342.
            assert!(off < 1e-8, "{cell_type} {node}: {off:e}");
        }
    }
}

#[test]
fn polynomials_of_the_order_are_drawn_exactly_at_points() {
    for (cell_type, curved) in all(Basis::Lagrange) {
        let orders: Vec<i32> = curved
            .factors
            .iter()
            .map(|f| f.simplex.order as i32)
            .collect();
        let function = |p: DVec3| match *orders {
            [n] => (p.x + 0.5 * p.y - 0.7 * p.z).powi(n),
            [n, r] => (p.x - 0.6 * p.y).powi(n) * (p.z - 0.2).powi(r),
            _ => {
                (p.x - 0.1).powi(orders[0])
                    * (p.y + 0.2).powi(orders[1])
                    * (p.z - 0.3).powi(orders[2])
            }
        };
        let nodes = nodes_of(&curved);
        let field = Scalars {
            name: "f".into(),
            association: Association::Point,
            values: nodes.iter().map(|p| function(*p)).collect(),
        };
        let (points, cells, extra) = alone(cell_type, &curved, nodes);
        for parts in [2, 5] {
            let cut = cut_into(parts, points.clone(), &cells, vec![field.clone()], &extra);
            for (p, found) in cut.points.iter().zip(&cut.scalars[0].values) {
                // Values up to 2; up to 343 functions up to 1, whose absolute sum is up to 4.55³, are rounded.
                assert!(
                    (found - function(*p)).abs() < 1e-12,
                    "{cell_type} {p}: {found}"
                );
            }
        }
    }
}

#[test]
fn bounds_of_all_orders_hold_and_are_near() {
    for (cell_type, curved) in all(Basis::Lagrange) {
        let nodes = nodes_of(&curved);
        let mut most = 0.0_f64;
        for (seed, parts) in [(0.0, 1), (1.0, 2), (2.0, 3)] {
            // Smooth, as fields are; random values bend functions of order 6 far more between nodes than at them.
            let smooth = |p: &DVec3| vector(seed) * (p.dot(vector(seed + 0.3)) * 3.0 + seed).sin();
            let random = |i: usize| vector(seed + 3.1 * i as f64);
            for values in [
                nodes.iter().map(smooth).collect(),
                (0..nodes.len()).map(random).collect::<Vec<_>>(),
            ] {
                let (_, _, extra) = alone(cell_type, &curved, nodes.clone());
                let bound = curved.bend(&values, None) / (parts * parts) as f64;
                let difference = difference_of(cell_type, &curved, &nodes, &extra, parts, &values);
                // The difference of two sums of up to 343 rounded terms.
                assert!(
                    difference <= bound + 1e-12,
                    "{cell_type} {:?} {parts}: {difference} {bound}",
                    curved.order
                );
                if bound > 1e-12 {
                    most = most.max(difference / bound);
                }
            }
        }
        // A linear tetrahedron does not bend. A bound that is far from any error would cut cells in vain.
        let is_linear = cell_type == 71 && curved.order == 1;
        assert!(
            is_linear || most > 0.1,
            "{cell_type} {}: {most}",
            curved.order
        );
    }
}

fn difference_of(
    cell_type: u8,
    curved: &Curved,
    nodes: &[DVec3],
    extra: &Extra,
    parts: usize,
    values: &[DVec3],
) -> f64 {
    let (points, cells, _) = one(cell_type, nodes.to_vec(), vec![]);
    let mesh = mesh_of(cut_into(parts, points, &cells, vec![], extra));
    sampled_difference(&mesh, &|p| value(curved, values, p))
}

/// Weights of nodes from 1/2 to 2.
fn weights(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|i| 2.0_f64.powf(noise(seed + i as f64)))
        .collect()
}

#[test]
fn bounds_of_bezier_cells_hold() {
    for (cell_type, curved) in all(Basis::Bernstein) {
        let nodes = nodes_of(&curved);
        for (seed, parts) in [(0.0, 1), (1.0, 2), (2.0, 4)] {
            let values: Vec<DVec3> = (0..nodes.len())
                .map(|i| vector(seed + 3.1 * i as f64))
                .collect();
            let (_, _, extra) = alone(cell_type, &curved, nodes.clone());
            let (points, cells, _) = one(cell_type, nodes.clone(), vec![]);
            // With control points at equal distances, points are where they are in the reference cell.
            let mesh = mesh_of(cut_into(parts, points, &cells, vec![], &extra));
            let share = |bend: f64| bend / (parts * parts) as f64;
            let difference = sampled_difference(&mesh, &|p| value(&curved, &values, p));
            let bound = share(curved.bend(&values, None));
            assert!(
                difference <= bound + 1e-12,
                "{cell_type} {parts}: {difference} {bound}"
            );
            let weights = weights(nodes.len(), seed);
            let difference =
                sampled_difference(&mesh, &|p| rational_value(&curved, &values, &weights, p));
            let bound = share(curved.bend(&values, Some(&weights)));
            assert!(
                difference <= bound,
                "{cell_type} {parts} with weights: {difference} {bound}"
            );
        }
    }
}

/// A quarter of a ring between radius 1 and 2, and z from 0 to 1: order 2 around it, 1 along the others, exact with weights.
fn ring() -> (Vec<DVec3>, Cells, Extra) {
    let kind = curved(Family::Hexahedron, Basis::Bernstein, [1, 2, 1]);
    let places = nodes_of(&kind.1);
    let middle = std::f64::consts::FRAC_1_SQRT_2;
    let around = |p: &DVec3| match p.y {
        0.0 => DVec3::X,
        1.0 => DVec3::Y,
        _ => DVec3::X + DVec3::Y,
    };
    let points = places
        .iter()
        .map(|p| around(p) * (1.0 + p.x) + DVec3::Z * p.z);
    let (points, cells, extra) = alone(79, &kind.1, points.collect());
    let weight = |p: &DVec3| if p.y == 0.5 { middle } else { 1.0 };
    let weights = places.iter().map(weight).collect();
    (points, cells, Extra { weights, ..extra })
}

#[test]
fn rational_cells_are_round() {
    let (points, cells, extra) = ring();
    let inside = cut_into(5, points.clone(), &cells, vec![], &extra);
    let radii = inside.points.iter().map(|p| p.truncate().length());
    let steps: Vec<f64> = radii.map(|radius| (radius - 1.0) * 5.0).collect();
    // Some ten roundings of numbers up to 10.
    assert!(
        steps.iter().all(|step| (step - step.round()).abs() < 1e-13),
        "{steps:?}"
    );
    let cut = straighten(points, cells, vec![], &extra, Straightening::to(1e-2));
    let report = cut.expect("it is cut").report.expect("it is curved");
    // A chord of an n-th of a quarter is off by about r (π/2n)²/8, with r = 2 and a diagonal of 3: 5 parts are enough. The
    // bound of a quotient is some times more.
    assert!(
        report.is_kept && (5..=12).contains(&report.parts),
        "{report:?}"
    );
}

#[test]
fn weights_that_are_not_above_zero_are_refused() {
    let (points, cells, extra) = ring();
    for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut wrong = extra.clone();
        wrong.weights[3] = weight;
        let error = straighten(
            points.clone(),
            cells.clone(),
            vec![],
            &wrong,
            Straightening::to(0.1),
        );
        let error = error.expect_err("a weight").to_string();
        assert!(
            error.contains("weights of Bézier cells must be above 0"),
            "{error}"
        );
    }
}

#[test]
fn numbers_of_points_without_an_order_are_refused() {
    for (cell_type, count, degrees, expected) in [
        (
            72,
            12,
            vec![],
            "cell 0 is a Lagrange hexahedron of 12 points: no order has so many: it must have 8, 27, 64, 125, 216, 343",
        ),
        (
            72,
            12,
            vec![[1.0, 2.0, 2.0]],
            "its degrees in the file are 1, 2 and 2: these need 18 points",
        ),
        (72, 12, vec![[1.0, 0.5, 2.0]], "whole numbers from 1 to 10"),
        (
            73,
            24,
            vec![[2.0, 3.0, 2.0]],
            "the first two must be the same",
        ),
        (71, 11, vec![], "it must have 4, 10, 20, 35, 56, 84"),
    ] {
        let points: Vec<DVec3> = (0..count).map(|i| vector(f64::from(i))).collect();
        let (points, cells, _) = one(cell_type, points, vec![]);
        let extra = Extra {
            degrees,
            weights: vec![],
        };
        let error = straighten(points, cells, vec![], &extra, Straightening::to(0.1));
        let error = error.expect_err("no order").to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn degrees_that_are_not_given_follow_from_the_points() {
    let (cell_type, kind) = curved(Family::Hexahedron, Basis::Lagrange, [2; 3]);
    let (points, cells, mut extra) = alone(cell_type, &kind, nodes_of(&kind));
    extra.degrees = vec![[f64::NAN; 3]];
    let cut = cut_into(3, points, &cells, vec![], &extra);
    assert_eq!(cut.cells.types, [12; 27]);
}

#[test]
fn cells_whose_functions_are_not_known_stay() {
    // Tetrahedra of 15 nodes and of order 7, a wedge of 21 nodes, pyramids.
    for (cell_type, count) in [(71, 15), (71, 120), (73, 21), (74, 30), (37, 19)] {
        let points: Vec<DVec3> = (0..count).map(|i| vector(f64::from(i))).collect();
        let (points, cells, _) = one(cell_type, points, vec![]);
        let same = straighten(
            points,
            cells.clone(),
            vec![],
            &Extra::default(),
            Straightening::to(0.1),
        );
        let same = same.expect("they stay");
        assert_eq!((same.cells, same.report), (cells, None));
    }
}

#[test]
fn cells_of_order_1_become_straight_ones() {
    for (cell_type, straight) in [(71, 10), (72, 12), (73, 13), (78, 10), (79, 12), (80, 13)] {
        let count = crate::mesh::volume_corners(straight).expect("a volume");
        let points: Vec<DVec3> = (0..count).map(|i| vector(i as f64)).collect();
        let (points, cells, _) = one(cell_type, points, vec![]);
        let made = straighten(
            points.clone(),
            cells,
            vec![],
            &Extra::default(),
            Straightening::to(1e-6),
        );
        let made = made.expect("they are straight");
        assert_eq!(
            (made.cells.types, made.points, made.report),
            (vec![straight], points, None)
        );
    }
}

#[test]
fn a_hostile_mesh_is_cut_into_few_cells() {
    // Many cells of order 1 and one of order 6, on the same few points.
    let order_6 = (0..84).collect::<Vec<u64>>();
    let mut cells = Cells {
        types: vec![71; 5001],
        offsets: vec![0],
        connectivity: Vec::new(),
    };
    for cell in 0..5001 {
        let nodes = if cell == 0 {
            &order_6[..]
        } else {
            &order_6[..4]
        };
        cells.connectivity.extend(nodes);
        cells.offsets.push(cells.connectivity.len() as u64);
    }
    let points = (0..84).map(|i| vector(f64::from(i))).collect();
    let how = Straightening {
        tolerance: 1e-9,
        most_cells: 100,
    };
    let cut = straighten(points, cells, vec![], &Extra::default(), how).expect("it is cut");
    // 6³ for the one and 2³ for each of the others.
    assert!(
        cut.cells.types.len() <= 216 + 5000 * 8,
        "{}",
        cut.cells.types.len()
    );
    assert!(!cut.report.expect("there are curved cells").is_kept);
}

#[test]
fn nodes_exchanged_twice_are_where_they_were() {
    for orders in HEXAHEDRA {
        let exchanged = exchanged(orders);
        let twice: Vec<usize> = exchanged.iter().map(|&node| exchanged[node]).collect();
        assert!(twice.into_iter().eq(0..exchanged.len()));
        // Those that change are on the edges from corner 2 to 6 and from 3 to 7, and change places at equal heights.
        let kind = curved(Family::Hexahedron, Basis::Lagrange, orders).1;
        let places = nodes_of(&kind);
        for (node, &other) in exchanged
            .iter()
            .enumerate()
            .filter(|(node, other)| node != *other)
        {
            assert_eq!(places[node].z, places[other].z);
            assert_eq!((places[node].y, places[other].y), (1.0, 1.0));
            assert_eq!(places[node].x + places[other].x, 1.0);
        }
        assert_eq!(
            exchanged.iter().zip(0..).filter(|(a, b)| *a != b).count(),
            2 * (orders[2] - 1)
        );
    }
}

#[test]
fn cells_of_any_numbers_are_cut_or_refused() {
    const TYPES: [u8; 12] = [24, 25, 26, 27, 71, 72, 73, 78, 79, 80, 12, 74];
    const COUNTS: [usize; 12] = [4, 6, 8, 10, 13, 15, 18, 20, 24, 27, 40, 64];
    const NUMBERS: [f64; 8] = [0.0, 1.0, 1.0, 2.0, 3.0, f64::NAN, f64::INFINITY, 1e300];
    let mut cut = 0;
    for case in 0..3000 {
        let seed = f64::from(case) * 7.7;
        let choice = |i: f64, of: usize| ((noise(seed + i) + 1.0) / 2.0 * of as f64) as usize % of;
        // Few points, so that cells are degenerate and share faces; some are far away or not finite.
        let coordinate = |i: f64| match choice(i + 0.5, 400) {
            0 => NUMBERS[choice(i, 8)],
            _ => choice(i, 4) as f64,
        };
        let points = (0..24).map(f64::from);
        let points =
            points.map(|i| DVec3::new(coordinate(i), coordinate(i + 0.1), coordinate(i + 0.2)));
        let points: Vec<DVec3> = points.collect();
        let mut cells = Cells {
            offsets: vec![0],
            ..Cells::default()
        };
        for cell in 0..3 {
            let at = 100.0 + 90.0 * f64::from(cell);
            let count = COUNTS[choice(at, 12)];
            let nodes = (0..count).map(|i| choice(at + 1.0 + i as f64, 24) as u64);
            cells.connectivity.extend(nodes);
            cells.types.push(TYPES[choice(at + 0.3, 12)]);
            cells.offsets.push(cells.connectivity.len() as u64);
        }
        let degree = |i: f64| NUMBERS[choice(i, 6)];
        let extra = Extra {
            degrees: match case % 3 {
                0 => [500.0, 501.0, 502.0]
                    .map(|i| [degree(i), degree(i + 0.1), degree(i + 0.2)])
                    .to_vec(),
                _ => Vec::new(),
            },
            weights: match case % 5 {
                0 => (0..24)
                    .map(|i| NUMBERS[1 + choice(600.0 + f64::from(i), 4)])
                    .collect(),
                _ => Vec::new(),
            },
        };
        let field = Scalars {
            name: "f".into(),
            association: Association::Point,
            values: (0..24)
                .map(|i| NUMBERS[choice(700.0 + f64::from(i), 8)])
                .collect(),
        };
        let how = Straightening {
            tolerance: 1e-2,
            most_cells: 500,
        };
        let Ok(made) = straighten(points, cells, vec![field], &extra, how) else {
            continue;
        };
        if let Some(report) = made.report {
            assert!(
                report.shape >= 0.0 && report.field >= 0.0 && report.gap >= 0.0,
                "{case}: {report}"
            );
            cut += 1;
        }
        let field = made.scalars.into_iter().next().expect("one field");
        assert_eq!(field.values.len(), made.points.len(), "{case}");
        let _ = TetMesh::new(made.points, &made.cells, field);
    }
    assert!(cut > 20, "{cut}");
}
