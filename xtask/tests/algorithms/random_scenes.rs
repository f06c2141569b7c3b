//! Random meshes, transfer functions and cameras, with every algorithm that promises something.
//!
//! A scene that fails is made as small as it still fails, and kept: `tetrascope render` opens what
//! `target/failures` has of it.

use proptest::prelude::*;
use proptest::test_runner::{Config, FileFailurePersistence};
use tetrascope::Algorithm;
use tetrascope::core::Unit as _;
use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::mesh::Association;
use tetrascope::core::view::TRANSPARENT;
use tetrascope::core::{
    Appearance, Camera, Knot, OpticalModel, Projection, Scalars, TetMesh, TransferFunction, View,
    Volume,
};
use tetrascope_testing::kuhn;
use xtask::machine::target;
use xtask::stability::{Case, Group, Matrix, Shot, keep, surfaces};
use xtask::testing::{algorithms, context};

/// Pixels along a side.
const SIDE: u32 = 11;

/// Cubes along the longest side of a mesh.
const CUBES: usize = 3;

/// The few numbers that a scene is made of, so that a failing one becomes small.
#[derive(Clone, Debug)]
struct Recipe {
    /// Cubes along a side, and which of them there are.
    cubes: usize,
    kept: Vec<bool>,
    /// How far points are moved, in cubes, and where to, of each.
    jitter: f64,
    moves: Vec<[f64; 3]>,
    /// Powers of ten by which each axis is longer.
    stretch: [f64; 3],
    /// A turn, and how many sizes it is from the origin.
    turn: [f64; 3],
    away: [f64; 3],
    /// Values of points or of cells, in steps; those at 0 are none where `holes`.
    values: Vec<u32>,
    of_cells: bool,
    holes: bool,
    /// Place in the range, color, and power of ten of the extinction over the size.
    knots: Vec<(u32, [f64; 3], f64)>,
    model: usize,
    /// Where the camera is, in sizes from the middle, where it looks, and how.
    eye: [f64; 3],
    at: [f64; 3],
    is_parallel: bool,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let unit = || prop::array::uniform3(-1.0..1.0f64);
    let corners = (CUBES + 1).pow(3);
    let mesh = (
        1..=CUBES,
        prop::collection::vec(prop::bool::weighted(0.8), CUBES.pow(3)),
        prop_oneof![Just(0.0), 0.0..0.2],
        prop::collection::vec(unit(), corners),
        prop::array::uniform3(prop_oneof![Just(0.0), -1.5..0.0]),
        unit(),
        prop::array::uniform3(prop_oneof![Just(0.0), -1e4..1e4]),
    );
    let field = (
        prop::collection::vec(0..17u32, 6 * CUBES.pow(3)),
        any::<bool>(),
        prop::bool::weighted(0.2),
        prop::collection::vec((0..33u32, unit(), -3.0..2.5), 1..7),
        0..OpticalModel::ALL.len(),
    );
    let view = (
        prop::array::uniform3(-2.5..2.5),
        prop::array::uniform3(-0.3..0.3),
        any::<bool>(),
    );
    (mesh, field, view).prop_map(|(mesh, field, view)| {
        let (cubes, kept, jitter, moves, stretch, turn, away) = mesh;
        let (values, of_cells, holes, knots, model) = field;
        let (eye, at, is_parallel) = view;
        Recipe {
            cubes,
            kept,
            jitter,
            moves,
            stretch,
            turn,
            away,
            values,
            of_cells,
            holes,
            knots,
            model,
            eye,
            at,
            is_parallel,
        }
    })
}

impl Recipe {
    fn shot(&self) -> Shot {
        let n = self.cubes;
        let place = |[x, y, z]: [usize; 3]| x + CUBES * (y + CUBES * z);
        // One cube is always there.
        let keep = |cube: [usize; 3]| cube == [0; 3] || self.kept[place(cube)];
        let (mut points, cells) = kuhn(n, DVec3::NEG_ONE, DVec3::ONE, keep);
        let [i, j, k] = self.turn;
        let turn = DMat3::from_rotation_z(3.0 * i)
            * DMat3::from_rotation_y(3.0 * j)
            * DMat3::from_rotation_x(3.0 * k);
        let to_world =
            turn * DMat3::from_diagonal(DVec3::from(self.stretch.map(|p| 10f64.powf(p))));
        let away = DVec3::from(self.away);
        for (point, by) in points.iter_mut().zip(&self.moves) {
            let cube = 2.0 / n as f64;
            *point = to_world * (*point + self.jitter * cube * DVec3::from(*by)) + away;
        }
        let count = if self.of_cells {
            cells.len()
        } else {
            points.len()
        };
        let value = |i: usize| match self.values[i % self.values.len()] {
            0 if self.holes => f64::NAN,
            step => f64::from(step) / 16.0,
        };
        let scalars = Scalars {
            name: "s".into(),
            association: if self.of_cells {
                Association::Cell
            } else {
                Association::Point
            },
            values: (0..count).map(value).collect(),
        };
        let mesh = TetMesh::from_tetrahedra(points, cells, scalars).expect("a mesh");
        let volume = Volume::Mesh(mesh);
        let (bounds, size) = (volume.bounds(), volume.bounds().diagonal());
        let mut knots: Vec<Knot> = (self.knots.iter())
            .map(|&(place, color, power)| Knot {
                scalar: f64::from(place) / 32.0,
                color: (DVec3::from(color) + 1.0) / 2.0,
                // The least is none.
                extinction: if power < -2.5 {
                    0.0
                } else {
                    10f64.powf(power) / size
                },
            })
            .collect();
        knots.sort_by(|a, b| a.scalar.total_cmp(&b.scalar));
        // Two at one scalar are a step; more are refused.
        let steps = knots.chunk_by(|a, b| a.scalar == b.scalar);
        let knots = steps
            .flat_map(|at_one| at_one.iter().take(2).copied())
            .collect();
        let function = TransferFunction::new(knots).expect("sorted");
        let focal_point = bounds.center() + size / 2.0 * DVec3::from(self.at);
        let mut position = bounds.center() + size / 2.0 * DVec3::from(self.eye);
        if (position - focal_point).length() < 0.05 * size {
            position += 0.2 * size * DVec3::ONE;
        }
        let forward = (focal_point - position).unit();
        let view = View {
            camera: Camera {
                position,
                focal_point,
                view_up: if forward.z.abs() > 0.9 {
                    DVec3::X
                } else {
                    DVec3::Z
                },
                projection: match self.is_parallel {
                    true => Projection::Orthographic {
                        parallel_scale: 0.4 * size,
                    },
                    false => Projection::Perspective { view_angle: 50.0 },
                },
            },
            width: SIDE,
            height: SIDE,
            background: TRANSPARENT,
        };
        let model = OpticalModel::ALL[self.model];
        let shot = Shot::new(volume, Appearance::new(function, model), view);
        // Between two knots, where there are two.
        match (model, surfaces(&shot)) {
            (OpticalModel::Isosurfaces, Some(appearance)) => Shot { appearance, ..shot },
            _ => shot,
        }
    }
}

/// Draws so many random scenes with these algorithms.
fn check(name: &str, scenes: u32, algorithms: &[&'static Algorithm]) {
    let config = Config {
        cases: scenes,
        failure_persistence: Some(Box::new(FileFailurePersistence::Off)),
        // Each try draws with all of them.
        max_shrink_iters: 300,
        ..Config::default()
    };
    proptest!(config, |(recipe in recipe())| {
        let shot = recipe.shot();
        let case = Case::new(Group::Geometry, name, shot.clone());
        let matrix = Matrix::draw(&[case], algorithms, context()).expect("the truth draws all");
        if let Some(fault) = matrix.faults().first() {
            let path = keep(&target().join("failures"), name, &shot).expect("written");
            prop_assert!(false, "{fault}; see {}", path.display());
        }
    });
}

#[test]
fn on_the_cpu() {
    let all = algorithms("random scenes on the CPU");
    let on_cpu: Vec<_> = all
        .into_iter()
        .filter(|a| !a.needs_gpu && !a.is_truth())
        .collect();
    check("a random scene on the CPU", 2000, &on_cpu);
}

#[test]
fn on_the_device() {
    let all = algorithms("random scenes on the device");
    let on_device: Vec<_> = all.into_iter().filter(|a| a.needs_gpu).collect();
    check("a random scene on the device", 100, &on_device);
}
