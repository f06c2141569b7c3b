//! The parts of which the suite's scenes are made.

use tetrascope::core::Unit as _;
use tetrascope::core::glam::DVec3;
use tetrascope::core::mesh::Association;
use tetrascope::core::view::TRANSPARENT;
use tetrascope::core::{
    Appearance, Camera, CameraFit, Knot, OpticalModel, Projection, Scalars, TetMesh,
    TransferFunction, View, Volume,
};
use tetrascope_testing::{Random, knot, kuhn, point_scalars};

/// Pixels along a side: rows of cells are a few pixels wide, and hundreds of pictures take a minute.
pub(super) const SIDE: u32 = 24;

/// A color that no other channel has.
pub(super) const ORANGE: DVec3 = DVec3::new(0.9, 0.5, 0.1);

/// Points, tetrahedra and a value at each point, before they are a mesh.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pub(super) points: Vec<DVec3>,
    pub(super) cells: Vec<[u32; 4]>,
    pub(super) values: Vec<f64>,
}

impl Pieces {
    /// The cube [−1, 1]³ in n³ cubes of six tetrahedra, inner points moved by up to `jitter` of a cube.
    pub(super) fn cube(n: usize, jitter: f64, field: impl Fn(DVec3) -> f64) -> Pieces {
        let (mut points, cells) = kuhn(n, DVec3::NEG_ONE, DVec3::ONE, |_| true);
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for point in &mut points {
            let moved = random.vector() * (jitter * 2.0 / n as f64);
            if point.abs().max_element() < 1.0 {
                *point += moved;
            }
        }
        Pieces::with_field(points, cells, field)
    }

    pub(super) fn with_field(
        points: Vec<DVec3>,
        cells: Vec<[u32; 4]>,
        field: impl Fn(DVec3) -> f64,
    ) -> Pieces {
        let values = points.iter().map(|p| field(*p)).collect();
        Pieces {
            points,
            cells,
            values,
        }
    }

    /// The same with each point elsewhere.
    pub(super) fn moved(mut self, to: impl Fn(DVec3) -> DVec3) -> Pieces {
        for point in &mut self.points {
            *point = to(*point);
        }
        self
    }

    /// Both, which share no point.
    pub(super) fn and(mut self, other: Pieces) -> Pieces {
        let first = self.points.len() as u32;
        self.points.extend(other.points);
        self.values.extend(other.values);
        let shifted = other.cells.into_iter().map(|cell| cell.map(|p| first + p));
        self.cells.extend(shifted);
        self
    }

    /// The mesh, with a value at each point.
    pub(super) fn volume(self) -> Volume {
        let Pieces {
            points,
            cells,
            values,
        } = self;
        let mesh = TetMesh::from_tetrahedra(points, cells, point_scalars(values));
        Volume::Mesh(mesh.expect("the suite's meshes are valid"))
    }

    /// The mesh, with these values of its cells.
    pub(super) fn with_cell_values(self, values: Vec<f64>) -> Volume {
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Cell,
            values,
        };
        let mesh = TetMesh::from_tetrahedra(self.points, self.cells, scalars);
        Volume::Mesh(mesh.expect("the suite's meshes are valid"))
    }
}

/// Between 0 and 1 in the cube, and nowhere linear.
pub(super) fn waves(p: DVec3) -> f64 {
    0.5 + 0.2 * (2.3 * p.x + 0.4).sin() + 0.2 * (1.9 * p.y - 0.3).cos() * (1.7 * p.z).sin()
}

/// Linear, between 0 and 1 in the cube.
pub(super) fn slope(p: DVec3) -> f64 {
    0.5 + 0.2 * p.x - 0.15 * p.y + 0.1 * p.z
}

/// 0 to 1 along x in the cube.
pub(super) fn along_x(p: DVec3) -> f64 {
    (p.x + 1.0) / 2.0
}

/// Emission and absorption with these knots.
pub(super) fn look(knots: Vec<Knot>) -> Appearance {
    let function = TransferFunction::new(knots).expect("the suite's knots are valid");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

/// Three colors over [0, 1], from clear to dense for a volume of size 2.
pub(super) fn plain() -> Appearance {
    plain_over(0.0, 1.0, 1.0)
}

/// As [`plain`], over another range and with lengths so many times as large.
pub(super) fn plain_over(low: f64, high: f64, length: f64) -> Appearance {
    let at = |share: f64, color: [f64; 3], extinction: f64| {
        knot(low + share * (high - low), color, extinction / length)
    };
    look(vec![
        at(0.0, [0.1, 0.2, 0.8], 0.1),
        at(0.4, [0.2, 0.9, 0.4], 0.6),
        at(1.0, [1.0, 0.3, 0.1], 4.0),
    ])
}

/// Eight extinctions of one color over an eighth of [0, 1] each, and their mean.
pub(super) fn seven_steps() -> (Vec<Knot>, f64) {
    let extinctions = [0.3, 4.0, 0.0, 1.0, 0.02, 7.0, 0.5, 2.0];
    let mut knots = Vec::new();
    for (i, extinction) in extinctions.into_iter().enumerate() {
        let ends = [i, i + 1].map(|i| i as f64 / 8.0);
        knots.extend(ends.map(|scalar| knot(scalar, ORANGE, extinction)));
    }
    (knots, extinctions.iter().sum::<f64>() / 8.0)
}

/// As `appearance` under another model.
pub(super) fn under(model: OpticalModel, appearance: Appearance) -> Appearance {
    Appearance {
        optical_model: model,
        ..appearance
    }
}

/// A square picture over nothing.
pub(super) fn seen(camera: Camera) -> View {
    View {
        camera,
        width: SIDE,
        height: SIDE,
        background: TRANSPARENT,
    }
}

/// The whole volume in perspective from a corner.
pub(super) fn whole(volume: &Volume) -> View {
    seen(Camera::fit(
        &volume.bounds(),
        CameraFit::PlusIso,
        false,
        1.0,
    ))
}

/// Parallel rays from `position` to `focal_point`; so much of the world is seen above the middle.
pub(super) fn parallel(position: DVec3, focal_point: DVec3, parallel_scale: f64) -> View {
    let along_z = (focal_point - position).unit().z.abs() > 0.9;
    seen(Camera {
        position,
        focal_point,
        view_up: if along_z { DVec3::Y } else { DVec3::Z },
        projection: Projection::Orthographic { parallel_scale },
    })
}

/// The middle of the cube from +x, by parallel rays that all cross it from x = 1 to x = −1.
pub(super) fn down_x() -> View {
    parallel(DVec3::new(3.0, 0.0, 0.0), DVec3::ZERO, 0.9)
}

/// In perspective from `position` to `focal_point`.
pub(super) fn perspective(position: DVec3, focal_point: DVec3, view_angle: f64) -> View {
    seen(Camera {
        position,
        focal_point,
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle },
    })
}

/// Premultiplied light of one color behind which an optical depth lies.
pub(super) fn one_color(color: DVec3, depth: f64) -> [f64; 4] {
    let opacity = -(-depth).exp_m1();
    (color * opacity).extend(opacity).to_array()
}
