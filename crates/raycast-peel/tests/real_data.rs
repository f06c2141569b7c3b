//! Real meshes, where they are at hand: in the folder that `TETRASCOPE_DATA` names, or in
//! `../shared/data` beside the repository.

use std::path::{Path, PathBuf};

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::{Association, Split};
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, Knot, OpticalModel, Scalars, TetMesh, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::testing;
use tetrascope_io::{MeshData, ReadOptions, read_mesh};
use tetrascope_raycast_peel::{Passes, RaycastOptions, RaycastPeel};
use tetrascope_reference::{Reference, ReferenceOptions};

/// Pixels a side.
const SIDE: u32 = 48;

/// A mesh file; without it, says that `test` is skipped.
fn data(test: &str, name: &str) -> Option<MeshData> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("TETRASCOPE_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.is_file() {
        eprintln!("skipped: {test}: there is no {}", path.display());
        return None;
    }
    Some(read_mesh(&path, &ReadOptions::default()).expect("a valid file"))
}

/// A ramp over the mesh's scalars, dense enough to hide its back.
fn ramp(mesh: &TetMesh) -> Appearance {
    let (low, high) = mesh.scalar_range().expect("scalars");
    let size = mesh.bounds().diagonal();
    let knot = |share: f64, color, depth: f64| Knot {
        scalar: low + share * (high - low),
        color,
        extinction: depth / size,
    };
    let function = TransferFunction::new(vec![
        knot(0.0, DVec3::new(0.1, 0.2, 0.8), 1.0),
        knot(0.4, DVec3::new(0.2, 0.9, 0.4), 3.0),
        knot(1.0, DVec3::new(1.0, 0.3, 0.1), 20.0),
    ]);
    let function = function.expect("valid knots");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

/// As in `ping_pong.rs`.
const OUTLIER: f64 = 3e-4;

/// How a mesh was drawn from one place.
#[derive(Debug)]
struct Errors {
    /// Of one dispatch, against the truth.
    single: (f64, f64),
    /// Of a step a pass, against one dispatch: RMSE over the pixels that differ by less
    /// than `OUTLIER`, and how many differ by more.
    ping_pong: (f64, usize),
    /// Rays that a step a pass gave up.
    lost: u64,
}

fn channels(frame: &Frame) -> impl Iterator<Item = f64> {
    frame.pixels.iter().flatten().map(|c| f64::from(*c))
}

/// Draws `mesh` in both forms from several places.
fn check(test: &str, mesh: TetMesh) {
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let appearance = ramp(&mesh);
    let volume = Volume::Mesh(mesh);
    let new = |passes| {
        let options = RaycastOptions {
            passes,
            ..RaycastOptions::default()
        };
        RaycastPeel::new(&gpu, &volume, &appearance, &options).expect("a mesh")
    };
    let (single, ping_pong) = (new(Passes::Single), new(Passes::PingPong));
    let reference = ReferenceOptions::default();
    let reference = Reference::new(&volume, &appearance, &reference).expect("a mesh");
    let bounds = volume.bounds();
    let inside = Camera {
        position: bounds.center() + bounds.size() * DVec3::new(0.13, 0.21, 0.17),
        focal_point: bounds.center(),
        ..Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0)
    };
    for (from, camera) in [
        ("far", Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0)),
        (
            "parallel",
            Camera::fit(&bounds, CameraFit::MinusIso, true, 1.0),
        ),
        (
            "along an axis",
            Camera::fit(&bounds, CameraFit::PlusZ, true, 1.0),
        ),
        ("inside", inside),
    ] {
        let view = View {
            camera,
            width: SIDE,
            height: SIDE,
            background: [0.0; 4],
        };
        let truth = reference.render_exact(&view).expect("a frame");
        let frame = single.render(&view).expect("a frame");
        let pairs = channels(&frame).zip(truth.pixels.iter().flatten());
        let (sum, max) = pairs.fold((0.0, 0.0_f64), |(sum, max), (a, b)| {
            let e = (a - b).abs();
            (sum + e * e, max.max(e))
        });
        let count = f64::from(4 * SIDE * SIDE);
        assert_eq!(frame.stats.lost_rays, Some(0), "{test}, {from}");
        assert_eq!(frame.stats.unpaired_faces, Some(0), "{test}, {from}");
        let stepped = ping_pong.render(&view).expect("a frame");
        let apart: Vec<f64> = channels(&frame)
            .zip(channels(&stepped))
            .map(|(a, b)| (a - b).abs())
            .collect();
        let close = apart.iter().filter(|e| **e <= OUTLIER);
        let errors = Errors {
            single: ((sum / count).sqrt(), max),
            ping_pong: (
                (close.map(|e| e * e).sum::<f64>() / count).sqrt(),
                apart
                    .chunks(4)
                    .filter(|p| p.iter().any(|e| *e > OUTLIER))
                    .count(),
            ),
            lost: stepped.stats.lost_rays.expect("counted"),
        };
        println!("{test}, {from}: {errors:?}");
        // The bar: no pixel beyond 1e-3.
        let (rmse, max) = errors.single;
        assert!(rmse <= 1e-5 && max <= 1e-3, "{test}, {from}: {errors:?}");
        // As of the small scenes in `ping_pong.rs`, where outliers are explained.
        let (apart, outliers) = errors.ping_pong;
        assert!(apart <= 1e-5 && outliers <= 4, "{test}, {from}: {errors:?}");
        assert_eq!(errors.lost, 0, "{test}, {from}");
    }
}

#[test]
fn the_blunt_fin() {
    let Some(data) = data("the Blunt Fin", "bluntfinxyz.bin") else {
        return;
    };
    let field = data.field(Some("density")).expect("a field").clone();
    let mesh = TetMesh::with_split(data.points, &data.cells, field, Split::FiveAlternating);
    let mesh = mesh.expect("a mesh");
    assert_eq!(mesh.cell_count(), 187_395);
    check("the Blunt Fin", mesh);
}

#[test]
fn the_super_phoenix() {
    let Some(data) = data("SPX", "spx.vtu") else {
        return;
    };
    check("SPX", data.into_mesh(None).expect("a mesh"));
}

#[test]
fn the_liquid_oxygen_post() {
    let Some(data) = data("the post", "postxyz.bin") else {
        return;
    };
    let field = data.fields.iter().position(|f| f.name.contains("energy"));
    let field = field.map(|index| data.fields[index].name.clone());
    check(
        "the post",
        data.into_mesh(field.as_deref()).expect("a mesh"),
    );
}

/// Seven blocks that touch but share no point.
#[test]
fn the_angular_sector() {
    let Some(data) = data("the angular sector", "AngularSector.vtk") else {
        return;
    };
    // Its only field numbers the points.
    let scalars = Scalars {
        name: "distance".into(),
        association: Association::Point,
        values: data.points.iter().map(|p| p.length()).collect(),
    };
    let mesh = TetMesh::new(data.points, &data.cells, scalars).expect("a mesh");
    check("the angular sector", mesh);
}
