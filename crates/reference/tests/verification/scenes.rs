//! Meshes and views whose pictures are known in closed form.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, Knot, OpticalModel, Projection, TetMesh, TransferFunction, View, Volume,
};
use tetrascope_reference::Reference;
pub(crate) use tetrascope_testing::{knot, mesh, point_scalars};

/// A box of `n`³ boxes in six tetrahedra each.
pub(crate) fn kuhn(n: usize, min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    tetrascope_testing::kuhn(n, min, max, |_| true)
}

/// The ground truth of a mesh.
pub(crate) fn reference(mesh: &TetMesh, appearance: &Appearance) -> Reference {
    tetrascope_testing::truth(&Volume::Mesh(mesh.clone()), appearance)
}

/// The appearance with these knots.
pub(crate) fn appearance(knots: Vec<Knot>, optical_model: OpticalModel) -> Appearance {
    Appearance::new(
        TransferFunction::new(knots).expect("valid knots"),
        optical_model,
    )
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
