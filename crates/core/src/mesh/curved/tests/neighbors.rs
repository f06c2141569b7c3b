use super::*;

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
        let curved = kind(cell_type);
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
        for parts in 1..=4 {
            let cut = cut_into(parts, points.clone(), &cells, vec![], &Extra::default());
            let report = cut.report.expect("there are curved cells");
            assert_eq!((report.apart, report.hanging), (0, 0), "{parts}");
            let mesh = mesh_of(cut);
            let free = (2 * quadrilaterals + triangles) * parts * parts;
            assert_eq!(mesh.boundary_faces().len(), free, "{parts}");
            assert!(mesh.boundary_statistics().closed, "{parts}");
            assert_eq!(mesh.report().coincident_points, 0);
            assert_eq!((mesh.report().flipped, mesh.report().unused_points), (0, 0));
        }
    }
}

/// The nodes of a Lagrange or quadratic cell between straight corners, moved by a map.
struct Cell {
    cell_type: u8,
    nodes: Vec<DVec3>,
}

fn cell(cell_type: u8, count: usize, corners: &[DVec3], map: Map) -> Cell {
    let form = Form::of(cell_type, count, None)
        .expect("an order")
        .expect("it is cut");
    let place = |node: &Vec<(usize, u64)>| {
        let terms = node
            .iter()
            .map(|&(corner, weight)| corners[corner] * (weight as f64 / 216_000.0));
        map(terms.sum())
    };
    let nodes = Curved::new(&form).node_places().iter().map(place).collect();
    Cell { cell_type, nodes }
}

/// Cells with nodes of their own each, where not `shared`.
fn together(cells: &[Cell], shared: bool) -> (Vec<DVec3>, Cells) {
    let mut points: Vec<DVec3> = Vec::new();
    let mut all = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    for cell in cells {
        for node in &cell.nodes {
            let known = points
                .iter()
                .position(|p| shared && (*p - *node).length() < 1e-9);
            all.connectivity.push(known.unwrap_or(points.len()) as u64);
            if known.is_none() {
                points.push(*node);
            }
        }
        all.types.push(cell.cell_type);
        all.offsets.push(all.connectivity.len() as u64);
    }
    (points, all)
}

fn cube(x: f64) -> [DVec3; 8] {
    let corners = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ];
    corners.map(|p: [u8; 3]| DVec3::new(x + f64::from(p[0]), f64::from(p[1]), f64::from(p[2])))
}

/// Where a point of straight cells goes.
type Map<'a> = &'a dyn Fn(DVec3) -> DVec3;

/// A hexahedron, and on its side x = 1 another that is turned, or two wedges with their quadrilaterals there, and on top of a wedge
/// a tetrahedron.
fn block(orders: [usize; 2], wedges: bool, map: Map) -> Vec<Cell> {
    let hexahedron = |order: usize, corners: &[DVec3]| cell(72, (order + 1).pow(3), corners, map);
    let mut cells = vec![hexahedron(orders[0], &cube(0.0))];
    let c = cube(1.0);
    let order = orders[1];
    if wedges {
        let count = (order + 1) * (order + 1) * (order + 2) / 2;
        cells.push(cell(73, count, &[c[0], c[3], c[1], c[4], c[7], c[5]], map));
        cells.push(cell(73, count, &[c[2], c[1], c[3], c[6], c[5], c[7]], map));
        let count = (order + 1) * (order + 2) * (order + 3) / 6;
        let top = DVec3::new(1.3, 0.5, 2.0);
        cells.push(cell(71, count, &[c[4], c[5], c[7], top], map));
    } else {
        // Turned by a quarter about x twice and about z.
        cells.push(hexahedron(order, &[2, 3, 0, 1, 6, 7, 4, 5].map(|i| c[i])));
    }
    cells
}

/// The boundary of [`block`] in triangles of a lattice of one part.
fn free_triangles(wedges: bool) -> usize {
    match wedges {
        // 5 sides of the hexahedron, 3 of the wedges, 3 triangles of the wedges and 3 of the tetrahedron.
        true => 2 * (5 + 3) + 3 + 3,
        false => 2 * 10,
    }
}

fn bent(p: DVec3) -> DVec3 {
    p + 0.1
        * DVec3::new(
            (2.0 * p.y).sin() * p.z,
            (1.5 * p.x).cos() * p.z,
            (p.x * p.y).sin(),
        )
}

#[test]
fn neighbors_of_one_order_share_their_points() {
    for (order, wedges) in [(3, false), (4, true), (5, false), (6, true)] {
        let (points, cells) = together(&block([order; 2], wedges, &bent), true);
        for parts in [1, 2, 3, 5] {
            let cut = cut_into(parts, points.clone(), &cells, vec![], &Extra::default());
            let report = cut.report.expect("there are curved cells");
            assert_eq!((report.apart, report.hanging), (0, 0));
            let mesh = mesh_of(cut);
            assert_eq!(
                mesh.boundary_faces().len(),
                free_triangles(wedges) * parts * parts
            );
            assert!(mesh.boundary_statistics().closed);
            assert_eq!(mesh.report().coincident_points, 0, "{order} {parts}");
        }
    }
}

#[test]
fn cells_with_points_of_their_own_meet_to_the_last_bit() {
    for (order, wedges) in [(2, true), (3, false), (4, true), (6, false)] {
        let (points, cells) = together(&block([order; 2], wedges, &bent), false);
        for parts in [2, 3, 5, 7] {
            let cut = cut_into(parts, points.clone(), &cells, vec![], &Extra::default());
            assert_eq!(cut.report.expect("there are curved cells").apart, 0);
            let mesh = mesh_of(cut);
            // Faces are joined where the bits of their corners' places are the same.
            assert_eq!(
                mesh.boundary_faces().len(),
                free_triangles(wedges) * parts * parts,
                "{order} {parts}"
            );
            assert!(mesh.report().joined_faces >= parts * parts * 2);
        }
    }
}

#[test]
fn orders_that_differ_meet_where_their_faces_are_the_same() {
    // Maps that both orders can have: a shear, which is linear, and a quadratic map.
    let shear = |p: DVec3| p + DVec3::new(0.3 * p.y, 0.1 * p.z, 0.2 * p.x);
    let square = |p: DVec3| p + DVec3::new(0.1 * p.y * p.z, 0.2 * p.z * p.z, 0.1 * p.y * p.y);
    let maps: [(Map, [usize; 2]); 4] = [
        (&shear, [1, 3]),
        (&shear, [2, 5]),
        (&square, [2, 3]),
        (&square, [6, 4]),
    ];
    for (map, orders) in maps {
        for wedges in [false, true] {
            for shared in [false, true] {
                let (points, cells) = together(&block(orders, wedges, map), shared);
                for parts in [2, 3, 6] {
                    let cut = cut_into(parts, points.clone(), &cells, vec![], &Extra::default());
                    let report = cut.report.expect("there are curved cells");
                    assert_eq!((report.apart, report.hanging), (0, 0), "{orders:?}");
                    let mesh = mesh_of(cut);
                    assert_eq!(
                        mesh.boundary_faces().len(),
                        free_triangles(wedges) * parts * parts,
                        "{orders:?} {parts}"
                    );
                }
            }
        }
    }
}

#[test]
fn faces_that_are_elsewhere_stay_apart_and_are_counted() {
    let (points, cells) = together(&block([2, 4], false, &bent), true);
    let cut = cut_into(4, points, &cells, vec![], &Extra::default());
    let report = cut.report.expect("there are curved cells");
    assert_eq!(report.apart, 1);
    // The map has third derivatives up to 0.1 · 8, and a cell of order 2 is off by some percent of that.
    assert!(report.gap > 1e-4 && report.gap < 1e-2, "{report:?}");
    let text = report.to_string();
    assert!(
        text.contains("1 cell has faces that are not where a neighbor's are"),
        "{text}"
    );
}

#[test]
fn nodes_in_the_old_order_are_noticed() {
    let mut block = block([3; 2], false, &bent);
    let order: Vec<usize> = exchanged([3; 3]);
    for cell in &mut block {
        cell.nodes = order.iter().map(|&node| cell.nodes[node]).collect();
    }
    let (points, cells) = together(&block, true);
    let cut = cut_into(3, points, &cells, vec![], &Extra::default());
    assert_eq!(cut.report.expect("there are curved cells").apart, 1);
}

#[test]
fn straight_neighbors_are_counted() {
    let mut cells = block([3; 2], false, &bent);
    let straight = Cell {
        cell_type: 12,
        nodes: cube(2.0).map(bent).to_vec(),
    };
    cells.push(straight);
    let (points, cells) = together(&cells, true);
    let cut = cut_into(2, points, &cells, vec![], &Extra::default());
    let report = cut.report.expect("there are curved cells");
    assert_eq!(report.hanging, 1);
    assert!(
        report
            .to_string()
            .ends_with("1 face between a curved and a straight cell is cut on one side alone")
    );
}

#[test]
fn values_of_cells_with_points_of_their_own_stay_their_own() {
    let (points, cells) = together(&block([3; 2], false, &bent), false);
    let half = points.len() / 2;
    let values = (0..points.len()).map(|i| if i < half { 1.0 } else { 2.0 });
    let field = Scalars {
        name: "f".into(),
        association: Association::Point,
        values: values.collect(),
    };
    let cut = cut_into(4, points, &cells, vec![field], &Extra::default());
    let values = &cut.scalars[0].values;
    // Sums of up to 64 functions of values 1 or 2, which are not mixed.
    let is_own = |value: &f64| (value - 1.0).abs() < 1e-12 || (value - 2.0).abs() < 1e-12;
    assert!(values.iter().all(is_own), "{values:?}");
}

#[test]
fn points_that_are_moved_count_in_the_bound() {
    // Two cells whose nodes on the face between them differ by what 32 bits round.
    let mut block = block([3; 2], false, &bent);
    for cell in &mut block {
        cell.nodes
            .iter_mut()
            .for_each(|node| *node = node.as_vec3().as_dvec3());
    }
    let off = f64::from(f32::EPSILON);
    let on_face = |place: &DVec3| (place.x - bent(DVec3::new(1.0, 0.0, 0.0)).x).abs() < 0.3;
    let nodes = block[1].nodes.iter_mut().skip(8);
    nodes
        .filter(|node| on_face(node))
        .for_each(|node| node.z += off);
    let (points, cells) = together(&block, false);
    let cut = cut_into(5, points, &cells, vec![], &Extra::default());
    let report = cut.report.expect("there are curved cells");
    // The box is about 2 × 1 × 1, and functions of order 3 enlarge what is off by up to 2.21².
    assert_eq!(report.apart, 0);
    assert!(
        report.shape > 0.1 * off && report.shape < 5.0 * off,
        "{report:?}"
    );
    let faces = mesh_of(cut).boundary_faces().len();
    assert_eq!(faces, free_triangles(false) * 25);
}
