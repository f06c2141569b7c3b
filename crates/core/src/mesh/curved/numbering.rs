//! VTK's numbers of the nodes of Lagrange and Bézier cells, which those of quadratic cells are at order 2.
//!
//! VTK 9: `vtkHigherOrderTetra::BarycentricIndex`, and `PointIndexFromIJK` of `vtkHigherOrderHexahedron`
//! and `vtkHigherOrderWedge`. Before VTK 9, the nodes of a hexahedron's edges from corner 2 to 6 and from
//! 3 to 7 were exchanged (`vtkHigherOrderHexahedron::NodeNumberingMappingFromVTK8To9`).

/// The nodes of a hexahedron with `order` parts along each axis, before VTK 9, as places in the order of
/// VTK 9: that of node i stands at `exchanged[i]`. Its own inverse.
pub fn exchanged([p, q, r]: [usize; 3]) -> Vec<usize> {
    let inner = r - 1;
    let first = 8 + 4 * (p - 1 + q - 1) + 2 * inner;
    let mut nodes: Vec<usize> = (0..(p + 1) * (q + 1) * (r + 1)).collect();
    let (left, right) = nodes[first..first + 2 * inner].split_at_mut(inner);
    left.swap_with_slice(right);
    nodes
}

/// The places of the nodes of VTK's Lagrange tetrahedron (type 71) or hexahedron (72) of an order, in their order, and in
/// steps of an edge's part: [0, 0, 0] is corner 0.
pub fn lagrange_nodes(cell_type: u8, order: usize) -> Vec<[usize; 3]> {
    if cell_type == 71 {
        let nodes = tetrahedron(order).into_iter();
        return nodes.map(|[_, i, j, k]| [i, j, k]).collect();
    }
    let side = order + 1;
    let mut nodes = vec![[0; 3]; side.pow(3)];
    for place in 0..side.pow(3) {
        let at = [place % side, place / side % side, place / side / side];
        nodes[hexahedron(at, [order; 3])] = at;
    }
    nodes
}

/// The node at (i, j, k) of a hexahedron with `order` parts along each axis.
pub(super) fn hexahedron([i, j, k]: [usize; 3], [p, q, r]: [usize; 3]) -> usize {
    let (inner_p, inner_q, inner_r) = (p - 1, q - 1, r - 1);
    let [on_i, on_j, on_k] = [(i, p), (j, q), (k, r)].map(|(i, order)| i == 0 || i == order);
    // The corner around the axis k: 0, 1, 2, 3 counterclockwise.
    let around = match (i > 0, j > 0) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    };
    let upper = usize::from(k > 0);
    let edges = 8;
    let faces = edges + 4 * (inner_p + inner_q + inner_r);
    let j_faces = faces + 2 * inner_q * inner_r;
    let k_faces = j_faces + 2 * inner_r * inner_p;
    match (on_i, on_j, on_k) {
        (true, true, true) => around + 4 * upper,
        (false, true, true) => {
            let before = if j > 0 { inner_p + inner_q } else { 0 };
            edges + before + upper * 2 * (inner_p + inner_q) + i - 1
        }
        (true, false, true) => {
            let before = if i > 0 {
                inner_p
            } else {
                2 * inner_p + inner_q
            };
            edges + before + upper * 2 * (inner_p + inner_q) + j - 1
        }
        (true, true, false) => edges + 4 * (inner_p + inner_q) + around * inner_r + k - 1,
        (true, false, false) => {
            let side = usize::from(i > 0) * inner_q * inner_r;
            faces + side + (j - 1) + inner_q * (k - 1)
        }
        (false, true, false) => {
            let side = usize::from(j > 0) * inner_r * inner_p;
            j_faces + side + (i - 1) + inner_p * (k - 1)
        }
        (false, false, true) => {
            let side = usize::from(k > 0) * inner_p * inner_q;
            k_faces + side + (i - 1) + inner_p * (j - 1)
        }
        (false, false, false) => {
            let inside = k_faces + 2 * inner_p * inner_q;
            inside + (i - 1) + inner_p * ((j - 1) + inner_q * (k - 1))
        }
    }
}

/// The node of a wedge with `order` parts along the triangles' edges and along the axis, at α of a triangle and
/// in layer k.
pub(super) fn wedge([a, i, j]: [usize; 3], k: usize, [p, r]: [usize; 2]) -> usize {
    let (inner_p, inner_r) = (p - 1, r - 1);
    let upper = usize::from(k > 0);
    let on_k = k == 0 || k == r;
    // The corner that has all, or the edge between two: from 0 to 1, 1 to 2 and 2 to 0.
    let corner = [a, i, j].iter().position(|&part| part == p);
    let edge = [j, a, i].iter().position(|&part| part == 0);
    let along = |edge: usize| [i, j, a][edge] - 1;
    let in_triangle = p.saturating_sub(2) * inner_p / 2;
    // Row by row of the triangle's inner nodes, which get shorter.
    let place = || (1..j).map(|row| inner_p - row).sum::<usize>() + i - 1;
    let edges = 6;
    let vertical = edges + 6 * inner_p;
    let triangles = vertical + 3 * inner_r;
    let sides = triangles + 2 * in_triangle;
    match (corner, edge, on_k) {
        (Some(corner), _, true) => corner + 3 * upper,
        (Some(corner), _, false) => vertical + corner * inner_r + k - 1,
        (None, Some(edge), true) => edges + (3 * upper + edge) * inner_p + along(edge),
        (None, Some(edge), false) => {
            sides + edge * inner_p * inner_r + along(edge) + inner_p * (k - 1)
        }
        (None, None, true) => triangles + upper * in_triangle + place(),
        (None, None, false) => sides + 3 * inner_p * inner_r + (k - 1) * in_triangle + place(),
    }
}

/// α of each node of a tetrahedron: corners, edges, faces and a smaller tetrahedron inside.
pub(super) fn tetrahedron(order: usize) -> Vec<[usize; 4]> {
    let mut nodes = Vec::new();
    let (mut order, mut base) = (order, 0);
    loop {
        let corners = [0, 1, 2, 3];
        add_shell(
            &mut nodes,
            [base; 4],
            order,
            &corners,
            &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        );
        for face in [[0, 1, 3], [2, 3, 1], [0, 3, 2], [0, 2, 1]] {
            let mut from = [base; 4];
            face.iter().for_each(|&corner| from[corner] += 1);
            let mut inner = order.checked_sub(3);
            while let Some(order) = inner {
                let [a, b, c] = face;
                add_shell(&mut nodes, from, order, &face, &[[a, b], [b, c], [c, a]]);
                face.iter().for_each(|&corner| from[corner] += 1);
                inner = order.checked_sub(3);
            }
        }
        match order.checked_sub(4) {
            Some(inner) => (order, base) = (inner, base + 1),
            None => return nodes,
        }
    }
}

/// Adds corners and nodes on edges, beyond `from`; only one node where the order is 0.
fn add_shell(
    nodes: &mut Vec<[usize; 4]>,
    from: [usize; 4],
    order: usize,
    corners: &[usize],
    edges: &[[usize; 2]],
) {
    if order == 0 {
        nodes.push(from);
        return;
    }
    let mut add = |parts: [(usize, usize); 2]| {
        let mut index = from;
        parts
            .iter()
            .for_each(|&(corner, part)| index[corner] += part);
        nodes.push(index);
    };
    corners
        .iter()
        .for_each(|&corner| add([(corner, order), (corner, 0)]));
    for &[a, b] in edges {
        (1..order).for_each(|m| add([(a, order - m), (b, m)]));
    }
}
