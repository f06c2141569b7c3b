//! Meshes and views whose pictures are known in closed form.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, Camera, Knot, OpticalModel, Projection, Scalars, TetMesh, TransferFunction, View,
    Volume,
};
use tetrascope_reference::{Reference, ReferenceOptions};

/// Points of a lattice of `n`³ cubes over the box from `min` to `max`, and six
/// tetrahedra a cube around the diagonal (Kuhn).
pub(crate) fn kuhn(n: usize, min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let side = n + 1;
    let point = |i: usize, j: usize, k: usize| (i + side * (j + side * k)) as u32;
    let mut points = Vec::new();
    for k in 0..side {
        for j in 0..side {
            for i in 0..side {
                let x = DVec3::new(i as f64, j as f64, k as f64) / n as f64;
                points.push(min + (max - min) * x);
            }
        }
    }
    let mut cells = Vec::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                for order in [
                    [0, 1, 2],
                    [0, 2, 1],
                    [1, 0, 2],
                    [1, 2, 0],
                    [2, 0, 1],
                    [2, 1, 0],
                ] {
                    let mut at = [i, j, k];
                    let mut cell = [point(i, j, k); 4];
                    for (step, axis) in order.into_iter().enumerate() {
                        at[axis] += 1;
                        cell[step + 1] = point(at[0], at[1], at[2]);
                    }
                    cells.push(cell);
                }
            }
        }
    }
    (points, cells)
}

/// A mesh with the field `scalar` at its points.
pub(crate) fn mesh(
    (points, cells): (Vec<DVec3>, Vec<[u32; 4]>),
    scalar: impl Fn(DVec3) -> f64,
) -> TetMesh {
    let values = points.iter().map(|p| scalar(*p)).collect();
    TetMesh::from_tetrahedra(points, cells, field(values)).expect("a valid mesh")
}

/// A field of point data.
pub(crate) fn field(values: Vec<f64>) -> Scalars {
    Scalars {
        name: "s".into(),
        association: Association::Point,
        values,
    }
}

/// A knot with these linear RGB and extinction.
pub(crate) fn knot(scalar: f64, color: [f64; 3], extinction: f64) -> Knot {
    Knot {
        scalar,
        color: color.into(),
        extinction,
    }
}

/// The appearance with these knots.
pub(crate) fn appearance(knots: Vec<Knot>, optical_model: OpticalModel) -> Appearance {
    Appearance::new(
        TransferFunction::new(knots).expect("valid knots"),
        optical_model,
    )
}

/// A ground truth with rayon's own threads.
pub(crate) fn reference(mesh: &TetMesh, appearance: &Appearance) -> Reference {
    let volume = Volume::Mesh(mesh.clone());
    Reference::new(&volume, appearance, &ReferenceOptions::default()).expect("a valid mesh")
}

/// A view of `size`² pixels.
pub(crate) fn view(
    position: [f64; 3],
    focal_point: [f64; 3],
    view_up: [f64; 3],
    projection: Projection,
    size: u32,
) -> View {
    View {
        camera: Camera {
            position: position.into(),
            focal_point: focal_point.into(),
            view_up: view_up.into(),
            projection,
        },
        width: size,
        height: size,
        background: [0.0; 4],
    }
}

/// Views of the cube [0, 1]³ from a generic direction, along its axes and
/// diagonals, from inside, in perspective and orthographic.
pub(crate) fn views(size: u32) -> Vec<View> {
    let perspective = Projection::Perspective { view_angle: 40.0 };
    let orthographic = Projection::Orthographic {
        parallel_scale: 0.75,
    };
    let center = [0.5; 3];
    let eyes = [
        [2.3, 1.1, -1.7],
        [0.5, 0.5, -2.0], // pixels on edges of the lattice
        [3.0, 0.5, 0.5],
        [2.5, 2.5, 2.5], // along the diagonals in which faces meet
        [0.5, 2.5, 2.5],
    ];
    let mut views = Vec::new();
    for eye in eyes {
        let up = if eye[0] == 0.5 && eye[1] == 0.5 {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
        for projection in [perspective, orthographic] {
            views.push(view(eye, center, up, projection, size));
        }
    }
    let inside = Projection::Perspective { view_angle: 120.0 };
    views.push(view(
        [0.5; 3],
        [0.9, 0.6, 0.7],
        [0.0, 0.0, 1.0],
        inside,
        size,
    ));
    views.push(view(
        [0.3, 0.4, 0.2],
        [1.0, 0.9, 0.8],
        [0.0, 0.0, 1.0],
        inside,
        size,
    ));
    views
}

/// Where a ray enters and leaves the box before its origin; `None` if it misses.
pub(crate) fn box_interval(
    ray: &tetrascope_core::Ray,
    min: DVec3,
    max: DVec3,
) -> Option<(f64, f64)> {
    let (mut t_in, mut t_out) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d == 0.0 {
            if o < min[axis] || o > max[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
        t_in = t_in.max(a.min(b));
        t_out = t_out.min(a.max(b));
    }
    (t_in < t_out).then_some((t_in, t_out))
}
