//! The nodes of tetrahedra and hexahedra of orders 3 to 6, from Gmsh's order to VTK's.
//!
//! Gmsh's reference manual, "Node ordering": corners, nodes on edges and on faces, and those inside, each as an element
//! of a lower order; edges and faces in the order of its `MTetrahedron.h` and `MHexahedron.h`.

use std::sync::LazyLock;

use tetrascope_core::mesh::curved::lagrange_nodes;

/// Coordinates of a node, in steps of an edge's n-th part.
type Place = [usize; 3];

/// For each point of VTK's cell, which of the element's nodes it is; orders 3 to 6.
static TETRAHEDRA: LazyLock<Vec<Vec<usize>>> = LazyLock::new(|| {
    let order = |n| order_of(&tetrahedron(n), &lagrange_nodes(71, n));
    (3..=6).map(order).collect()
});

/// So for hexahedra.
static HEXAHEDRA: LazyLock<Vec<Vec<usize>>> = LazyLock::new(|| {
    let order = |n| order_of(&hexahedron(n), &lagrange_nodes(72, n));
    (3..=6).map(order).collect()
});

/// For each point of a Lagrange tetrahedron of VTK's, which of the element's nodes it is.
pub(super) fn of_tetrahedron(order: usize) -> &'static [usize] {
    &TETRAHEDRA[order - 3]
}

/// For each point of a Lagrange hexahedron of VTK's, which of the element's nodes it is.
pub(super) fn of_hexahedron(order: usize) -> &'static [usize] {
    &HEXAHEDRA[order - 3]
}

fn order_of(gmsh: &[Place], vtk: &[Place]) -> Vec<usize> {
    let number = |place: &Place| gmsh.iter().position(|p| p == place);
    let numbers = vtk
        .iter()
        .map(|place| number(place).expect("both have all nodes"));
    numbers.collect()
}

/// The nodes of an element between these corners, which are `n` steps apart, on edges: from each edge's first corner.
fn on_edges(corners: &[Place], edges: &[[usize; 2]], n: usize) -> Vec<Place> {
    let nodes = edges
        .iter()
        .flat_map(|&[from, to]| (1..n).map(move |m| between(corners[from], corners[to], m, n)));
    nodes.collect()
}

/// The place m of n steps from one to another.
fn between(from: Place, to: Place, m: usize, n: usize) -> Place {
    std::array::from_fn(|axis| (from[axis] * (n - m) + to[axis] * m) / n)
}

/// Corners of what is inside of a triangle: each a step from both of its edges.
fn inside_triangle([a, b, c]: [Place; 3], n: usize) -> [Place; 3] {
    let inner = |a: Place, b: Place, c: Place| {
        let (along, across) = (between(a, b, 1, n), between(a, c, 1, n));
        std::array::from_fn(|axis| along[axis] + across[axis] - a[axis])
    };
    [inner(a, b, c), inner(b, c, a), inner(c, a, b)]
}

/// The nodes inside of a triangle whose edges have `n` steps.
fn triangle(corners: [Place; 3], n: usize) -> Vec<Place> {
    let Some(inner) = n.checked_sub(3) else {
        return Vec::new();
    };
    let corners = inside_triangle(corners, n);
    if inner == 0 {
        return vec![corners[0]];
    }
    let edges = on_edges(&corners, &[[0, 1], [1, 2], [2, 0]], inner);
    [corners.to_vec(), edges, triangle(corners, inner)].concat()
}

/// The nodes inside of a square whose edges have `n` steps.
fn square(corners: [Place; 4], n: usize) -> Vec<Place> {
    let Some(inner) = n.checked_sub(2) else {
        return Vec::new();
    };
    let [a, b, c, d] = corners;
    let corner = |a: Place, b: Place, d: Place| {
        let (along, across) = (between(a, b, 1, n), between(a, d, 1, n));
        std::array::from_fn(|axis| along[axis] + across[axis] - a[axis])
    };
    let corners = [
        corner(a, b, d),
        corner(b, c, a),
        corner(c, d, b),
        corner(d, a, c),
    ];
    if inner == 0 {
        return vec![corners[0]];
    }
    let edges = on_edges(&corners, &[[0, 1], [1, 2], [2, 3], [3, 0]], inner);
    [corners.to_vec(), edges, square(corners, inner)].concat()
}

/// All nodes of a tetrahedron.
fn tetrahedron(order: usize) -> Vec<Place> {
    const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [3, 0], [3, 2], [3, 1]];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [3, 1, 2]];
    let (mut nodes, mut from, mut n) = (Vec::new(), 0, order);
    loop {
        let along = |axis: usize| std::array::from_fn(|a| from + if a == axis { n } else { 0 });
        let corners: [Place; 4] = [[from; 3], along(0), along(1), along(2)];
        if n == 0 {
            nodes.push(corners[0]);
            return nodes;
        }
        nodes.extend(corners);
        nodes.extend(on_edges(&corners, &EDGES, n));
        let faces = FACES
            .iter()
            .flat_map(|face| triangle(face.map(|i| corners[i]), n));
        nodes.extend(faces);
        match n.checked_sub(4) {
            Some(inner) => (from, n) = (from + 1, inner),
            None => return nodes,
        }
    }
}

/// All nodes of a hexahedron.
fn hexahedron(order: usize) -> Vec<Place> {
    const EDGES: [[usize; 2]; 12] = [
        [0, 1],
        [0, 3],
        [0, 4],
        [1, 2],
        [1, 5],
        [2, 3],
        [2, 6],
        [3, 7],
        [4, 5],
        [4, 7],
        [5, 6],
        [6, 7],
    ];
    const FACES: [[usize; 4]; 6] = [
        [0, 3, 2, 1],
        [0, 1, 5, 4],
        [0, 4, 7, 3],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [4, 5, 6, 7],
    ];
    let (mut nodes, mut from, mut n) = (Vec::new(), 0, order);
    loop {
        let (low, high) = (from, from + n);
        let square = |z| {
            [
                [low, low, z],
                [high, low, z],
                [high, high, z],
                [low, high, z],
            ]
        };
        let corners = [square(low), square(high)].concat();
        if n == 0 {
            nodes.push(corners[0]);
            return nodes;
        }
        nodes.extend(&corners);
        nodes.extend(on_edges(&corners, &EDGES, n));
        let faces = FACES
            .iter()
            .flat_map(|face| self::square(face.map(|i| corners[i]), n));
        nodes.extend(faces);
        match n.checked_sub(2) {
            Some(inner) => (from, n) = (from + 1, inner),
            None => return nodes,
        }
    }
}
