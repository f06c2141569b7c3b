//! Fields and cells of every kind, in every optical model.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, CameraFit, Cells, Knot, OpticalModel, Scalars, TetMesh, TransferFunction, View,
    Volume,
};
use tetrascope_testing::{
    fitted, jumping, mismatched, outside_and_inside, point_scalars, ramp, split, stacked_plates,
};

use crate::common::{check, check_within, mesh, new, scene};

const SIDE: u32 = 64;

fn views(volume: &Volume) -> [(&'static str, View); 4] {
    let [perspective, orthographic, inside] = outside_and_inside(volume, SIDE);
    [
        ("perspective", perspective),
        ("orthographic", orthographic),
        // Along an axis of the lattice: rays in faces and along edges.
        ("along z", fitted(volume, CameraFit::PlusZ, true, SIDE)),
        ("inside", inside),
    ]
}

fn check_all(name: &str, volume: &Volume, appearance: &Appearance) {
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let name = format!("{name}, {}", model.name());
        check(&name, &new(volume, &appearance), views(volume));
    }
}

#[test]
fn data_sets() {
    for (name, cells) in [
        ("sphere", 5000),
        ("orbital", 3000),
        ("heat-sink", 4000),
        ("torus", 4000),
        ("delaunay", 2000),
        ("graded", 3000),
        ("staircase", 23),
    ] {
        let (volume, appearance) = scene(name, cells);
        check_all(name, &volume, &appearance);
    }
}

#[test]
fn cell_scalars() {
    let (mesh, appearance) = mesh("sphere", 2000);
    let mean = |cell| mesh.cell_scalars(cell).iter().sum::<f64>() / 4.0;
    let scalars = Scalars {
        name: "mean".into(),
        association: Association::Cell,
        values: (0..mesh.cell_count()).map(mean).collect(),
    };
    let points = mesh.points().to_vec();
    let mesh = TetMesh::from_tetrahedra(points, mesh.tetrahedra().to_vec(), scalars);
    let volume = Volume::Mesh(mesh.expect("a mesh"));
    check_all("cell scalars", &volume, &appearance);
}

/// Blocks that touch but share no point, fields that jump between cells or are nowhere, faces that lie
/// in one place and are not the same, and many parts behind each other.
#[test]
fn cells_that_fit_badly() {
    let (mesh, appearance) = mesh("sphere", 600);
    check_all("split", &split(&mesh), &appearance);
    // Along z some rays lie in faces: where the field jumps, MAXIMUM_INTENSITY tells a cell that is met
    // for a rounding from one that is not.
    let jumping = jumping(&mesh);
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let views = views(&jumping).into_iter();
        let views = views.filter(|(from, _)| *from != "along z");
        let name = format!("jumping, {}", model.name());
        check(&name, &new(&jumping, &appearance), views);
    }
    let volume = mismatched(6);
    check_all("mismatched", &volume, &ramp(&volume));
    // Each end of a ray's way through a plate is off by 2⁻²⁴ of the extent, and the plate is 8e-4 of it:
    // 1e-4 of its light, 1e-4 / √300 of that of 300, whose errors are their own.
    let volume = stacked_plates(300);
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..ramp(&volume)
        };
        let name = format!("plates, {}", model.name());
        check_within(6.0, &name, &new(&volume, &appearance), views(&volume));
    }
}

/// A transfer function of steps, on whose values the scalar is constant in some cells: both sides
/// count half; and one of many intervals.
#[test]
fn steps_and_many_knots() {
    let (mesh, _) = mesh("sphere", 1500);
    let knot = |scalar, color: [f64; 3], extinction| Knot {
        scalar,
        color: color.into(),
        extinction,
    };
    let levels = mesh
        .scalars()
        .values
        .iter()
        .map(|s| (4.0 * s).round() / 4.0);
    let scalars = point_scalars(levels.collect());
    let stepped = Volume::Mesh(mesh.with_scalars(scalars).expect("as many"));
    let steps = TransferFunction::new(vec![
        knot(0.0, [1.0, 0.2, 0.1], 0.0),
        knot(0.25, [0.9, 0.3, 0.1], 0.3),
        knot(0.25, [0.1, 0.3, 0.9], 1.7),
        knot(0.5, [0.1, 0.8, 0.2], 0.1),
        knot(0.5, [0.9, 0.9, 0.2], 2.0),
        knot(1.0, [1.0, 1.0, 1.0], 0.0),
    ]);
    let appearance = Appearance::new(steps.expect("sorted"), OpticalModel::EmissionAbsorption);
    check_all("levels on steps", &stepped, &appearance);
    let many = (0..=1000).map(|i| {
        let s = f64::from(i) / 1000.0;
        let wave = |phase: f64| 0.5 + 0.5 * (40.0 * s + phase).sin();
        knot(s, [wave(0.0), wave(2.0), wave(4.0)], 3.0 * wave(1.0))
    });
    let many = TransferFunction::new(many.collect()).expect("sorted");
    let appearance = Appearance::new(many, OpticalModel::EmissionAbsorption);
    check_all("a thousand intervals", &Volume::Mesh(mesh), &appearance);
}

/// A row of hexahedra whose lower edges are collapsed, as in the blunt fin: some of
/// their tetrahedra are left out. A scalar that is not a number makes the cells
/// around it transparent.
#[test]
fn degenerate_and_undefined_cells() {
    const N: u64 = 7;
    let index = |[i, j, k]: [u64; 3]| i + N * (j + N * k);
    let lattice = |n: u64| (0..n * n * n).map(move |c| [c % n, c / n % n, c / (n * n)]);
    let place = |[i, j, k]: [u64; 3]| {
        // As j = 1 where both j and k are least.
        let y = if k == 0 { j.max(1) } else { j };
        DVec3::new(i as f64, y as f64, k as f64)
    };
    let points: Vec<DVec3> = lattice(N).map(place).collect();
    let mut cells = Cells::default();
    cells.offsets.push(0);
    for [i, j, k] in lattice(N - 1) {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        for up in [0, 1] {
            let at = corners.map(|[x, y]| index([i + x, j + y, k + up]));
            cells.connectivity.extend(at);
        }
        cells.types.push(12);
        cells.offsets.push(cells.connectivity.len() as u64);
    }
    let mut values: Vec<f64> = points.iter().map(|p| p.length() / 12.0).collect();
    values[index([3, 3, 3]) as usize] = f64::NAN;
    let mesh = TetMesh::new(points, &cells, point_scalars(values)).expect("a mesh");
    assert!(mesh.report().collapsed > 0);
    let (_, appearance) = self::mesh("sphere", 100);
    check_all("degenerate", &Volume::Mesh(mesh), &appearance);
}

/// Optical depths of thousands in a cell, and of billionths.
#[test]
fn dense_and_clear_cells() {
    let (mesh, appearance) = mesh("sphere", 3000);
    let volume = Volume::Mesh(mesh);
    for factor in [1e-9, 30.0, 1e4, 1e15] {
        let knots = appearance.transfer_function.knots().iter().map(|k| Knot {
            extinction: k.extinction * factor,
            ..*k
        });
        let transfer_function = TransferFunction::new(knots.collect()).expect("sorted");
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Absorption] {
            let appearance = Appearance {
                transfer_function: transfer_function.clone(),
                optical_model: model,
                ..appearance.clone()
            };
            let name = format!("{} times {factor:e}", model.name());
            check(&name, &new(&volume, &appearance), views(&volume));
        }
    }
}
