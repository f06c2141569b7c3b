//! Scenes, views and differences that the tests share.

use std::path::{Path, PathBuf};

use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::mesh::{Association, Split};
use tetrascope_core::{
    Appearance, Camera, CameraFit, ClipPlane, DirectionalLight, Frame, Isosurface, Knot, Lighting,
    OpticalModel, Projection, Ray, Scalars, TetMesh, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_datasets::{Options, find};
use tetrascope_gpu::Gpu;
use tetrascope_io::{MeshData, ReadOptions, read_mesh};
use tetrascope_raycast_peel::{RaycastOptions, RaycastPeel};
use tetrascope_reference::{Reference, ReferenceOptions};

/// A data set of about `cells` cells.
pub(crate) fn mesh(name: &str, cells: Option<u64>) -> TetMesh {
    let options = Options {
        cells,
        ..Options::default()
    };
    let dataset = find(name).expect("a data set");
    dataset.mesh(&options).expect("a mesh")
}

/// A data set of about `cells` cells with its own transfer function.
pub(crate) fn scene(name: &str, cells: u64) -> (Volume, Appearance) {
    let volume = Volume::Mesh(mesh(name, Some(cells)));
    let knots = find(name).expect("a data set").look().knots;
    let function = TransferFunction::new(knots).expect("valid knots");
    let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
    (volume, appearance)
}

/// A square view over a background that is seen through.
pub(crate) fn view(camera: Camera, side: u32) -> View {
    View {
        camera,
        width: side,
        height: side,
        background: [0.1, 0.2, 0.3, 0.5],
    }
}

pub(crate) fn fitted(volume: &Volume, from: CameraFit, orthographic: bool, side: u32) -> View {
    view(Camera::fit(&volume.bounds(), from, orthographic, 1.0), side)
}

/// In the volume, at no vertex of it.
pub(crate) fn inside(volume: &Volume) -> Camera {
    let bounds = volume.bounds();
    Camera {
        position: bounds.center() + bounds.size() * DVec3::new(0.11, 0.13, 0.07),
        focal_point: bounds.center(),
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle: 70.0 },
    }
}

/// A parallel view that cuts the volume in the same place.
pub(crate) fn cutting(volume: &Volume) -> Camera {
    Camera {
        projection: Projection::Orthographic {
            parallel_scale: volume.bounds().diagonal() / 3.0,
        },
        ..inside(volume)
    }
}

pub(crate) fn renderer(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
) -> RaycastPeel {
    RaycastPeel::new(gpu, volume, appearance, options).expect("a mesh")
}

pub(crate) fn draw(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
    view: &View,
) -> Frame {
    let renderer = renderer(gpu, volume, appearance, options);
    renderer.render(view).expect("a frame")
}

pub(crate) fn truth(volume: &Volume, appearance: &Appearance) -> Reference {
    Reference::new(volume, appearance, &ReferenceOptions::default()).expect("it draws all")
}

/// Two plates with a gap between, each 0.0008 of the extent thick. The scalar goes from 0 to 1
/// through each.
pub(crate) fn plates() -> Volume {
    stacked_plates(2)
}

/// The same with `count` of them.
pub(crate) fn stacked_plates(count: u32) -> Volume {
    let mut points = Vec::new();
    let mut tetrahedra = Vec::new();
    for z in (0..count).map(|i| 0.0016 * f64::from(i)) {
        let first = points.len() as u32;
        for i in 0..8 {
            let corner = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
            points.push(DVec3::new(corner[0], corner[1], z + 0.0008 * corner[2]));
        }
        // Around the diagonal from corner 0 to 7.
        for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
            tetrahedra.push([0, a, b, 7].map(|i| first + i));
        }
    }
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values: (0..points.len()).map(|i| ((i >> 2) & 1) as f64).collect(),
    };
    Volume::Mesh(TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a mesh"))
}

/// The same cells, but no two share a point: where two touch, two faces are in one place.
pub(crate) fn split(mesh: &TetMesh) -> Volume {
    let cells = 0..mesh.cell_count();
    let points = cells.clone().flat_map(|c| mesh.cell_points(c)).collect();
    let scalars = Scalars {
        values: cells.clone().flat_map(|c| mesh.cell_scalars(c)).collect(),
        ..mesh.scalars().clone()
    };
    let tetrahedra = cells.map(|c| [0, 1, 2, 3].map(|i| 4 * c as u32 + i));
    let split = TetMesh::from_tetrahedra(points, tetrahedra.collect(), scalars);
    Volume::Mesh(split.expect("a mesh"))
}

/// The same, each cell with values of its own: some higher and steeper, some without any.
pub(crate) fn jumping(mesh: &TetMesh) -> Volume {
    let Volume::Mesh(split) = split(mesh) else {
        panic!("a mesh")
    };
    let values = split.scalars().values.iter().enumerate();
    let values = values.map(|(i, s)| match i / 4 % 5 {
        0 => s * 0.8,
        1 if i % 40 == 4 => f64::NAN,
        j => s + 0.03 * j as f64,
    });
    let scalars = Scalars {
        values: values.collect(),
        ..split.scalars().clone()
    };
    let mesh = split.with_scalars(scalars).expect("as many");
    assert!(!mesh.is_continuous());
    Volume::Mesh(mesh)
}

/// Cubes on each other along z, of whose faces no two have the same diagonal: faces lie in
/// one place and are not the same.
pub(crate) fn mismatched(count: u32) -> Volume {
    let mut points = Vec::new();
    let mut tetrahedra = Vec::new();
    for cube in 0..count {
        let first = points.len() as u32;
        for i in 0..8_u32 {
            let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
            let x = if cube % 2 == 0 { x } else { 1.0 - x };
            points.push(DVec3::new(x, y, f64::from(cube) + z));
        }
        for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
            tetrahedra.push([0, a, b, 7].map(|i| first + i));
        }
    }
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values: points.iter().map(|p: &DVec3| p.x + p.y + p.z).collect(),
    };
    Volume::Mesh(TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a mesh"))
}

/// A mesh of these cells.
pub(crate) fn cells(points: &[[f64; 3]], cells: &[[u32; 4]], values: &[f64]) -> Volume {
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values: values.to_vec(),
    };
    let points = points.iter().map(|&p| p.into()).collect();
    let mesh = TetMesh::from_tetrahedra(points, cells.to_vec(), scalars);
    Volume::Mesh(mesh.expect("a mesh"))
}

/// What two pictures differ by, over the channels of all pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    pub(crate) rmse: f64,
    pub(crate) max: f64,
}

pub(crate) fn difference(frame: &Frame, truth: &[[f64; 4]]) -> Difference {
    let errors = frame
        .pixels
        .iter()
        .zip(truth)
        .flat_map(|(a, b)| (0..4).map(|c| (f64::from(a[c]) - b[c]).abs()));
    let (sum, max) = errors.fold((0.0, 0.0_f64), |(sum, max), e| (sum + e * e, max.max(e)));
    Difference {
        rmse: (sum / (4 * truth.len()) as f64).sqrt(),
        max,
    }
}

/// The picture in f64.
pub(crate) fn exactly(frame: &Frame) -> Vec<[f64; 4]> {
    let pixels = frame.pixels.iter();
    pixels.map(|pixel| pixel.map(f64::from)).collect()
}

/// The greatest channel, and at least 1: sums of light have no other unit.
pub(crate) fn scale(truth: &[[f64; 4]]) -> f64 {
    truth.iter().flatten().fold(1.0, |a: f64, b| a.max(*b))
}

/// A ramp over the volume's scalars, dense enough to hide its back.
pub(crate) fn ramp(volume: &Volume) -> Appearance {
    let (low, high) = volume.scalar_range().expect("scalars");
    let size = volume.bounds().diagonal();
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

/// Two planes that cut corners of a volume off, along no axis.
pub(crate) fn tilted(volume: &Volume) -> Vec<ClipPlane> {
    let bounds = volume.bounds();
    let plane = |share: DVec3, normal: [f64; 3]| ClipPlane {
        point: bounds.min + share * bounds.size(),
        normal: normal.into(),
    };
    vec![
        plane(DVec3::splat(0.37), [1.0, 0.3, 0.6]),
        plane(DVec3::splat(0.71), [-0.2, -1.0, 0.1]),
    ]
}

/// `appearance` with three surfaces in the volume's range and two lights.
pub(crate) fn surfaces(volume: &Volume, appearance: Appearance) -> Appearance {
    let (low, high) = volume.scalar_range().expect("a field");
    let surface = |share: f64, color: [f64; 3]| Isosurface {
        value: low + share * (high - low),
        color: color.into(),
    };
    let light = |toward: [f64; 3], color: [f64; 3]| DirectionalLight {
        toward: toward.into(),
        color: color.into(),
    };
    Appearance {
        optical_model: OpticalModel::Isosurfaces,
        isosurfaces: vec![
            surface(0.717, [1.0, 0.3, 0.1]),
            surface(0.231, [0.2, 0.5, 1.0]),
            surface(0.489, [0.3, 0.9, 0.2]),
        ],
        lighting: Lighting {
            ambient: 0.15,
            lights: vec![
                light([1.0, 2.0, 3.0], [0.7, 0.6, 0.5]),
                light([-2.0, 1.0, -1.0], [0.2, 0.3, 0.6]),
            ],
        },
        ..appearance
    }
}

/// Whether what is within f32's reach of this pixel has this color: a ray within 1e-4 of a
/// pixel, as f32 moves rays by less than that (2⁻²⁴ of the distance of some hundred
/// pixels), or surfaces within 2⁻²² of the field's range of their values, as scalars are
/// rounded to 2⁻²⁴ of it and three of them are summed. So f32 decides what a ray along a
/// surface's outline sees, and which of two facets one meets where it crosses from cell to cell.
pub(crate) fn is_explained(
    truth: &Reference,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
    pixel: usize,
    got: [f32; 4],
) -> bool {
    let (column, row) = (pixel as u32 % view.width, pixel as u32 / view.width);
    let background = view.premultiplied_background();
    let is_near = |truth: &Reference, ray: &Ray| {
        let trace = truth.trace(ray).expect("a ray");
        (0..4).all(|c| {
            let want = trace.pixel[c] + (1.0 - trace.pixel[3]) * background[c];
            (want - f64::from(got[c])).abs() <= 1e-3
        })
    };
    let moved_ray = (0..16).any(|i| {
        let angle = f64::from(i) / 16.0 * std::f64::consts::TAU;
        let shift = 1e-4 * DVec2::from_angle(angle);
        let size = DVec2::new(view.width.into(), view.height.into());
        let at = 2.0 * (DVec2::new(column.into(), row.into()) + 0.5 + shift) / size - 1.0;
        is_near(truth, &view.camera.ray(at.x, -at.y, size.x / size.y))
    });
    let (low, high) = volume.scalar_range().expect("a field");
    moved_ray
        || [-1.0, 1.0].into_iter().any(|sign| {
            let mut appearance = appearance.clone();
            for surface in &mut appearance.isosurfaces {
                surface.value += sign * (high - low) / f64::from(1 << 22);
            }
            let mut truth = truth.clone();
            truth.restyle(&appearance).expect("it draws all");
            is_near(&truth, &view.ray(column, row))
        })
}

/// A mesh file, in the folder that `TETRASCOPE_DATA` names or in `../shared/data` beside the
/// repository; without it, says that `test` is skipped.
pub(crate) fn data(test: &str, name: &str) -> Option<MeshData> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("TETRASCOPE_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.is_file() {
        eprintln!("skipped: {test}: there is no {}", path.display());
        return None;
    }
    Some(read_mesh(&path, &ReadOptions::default()).expect("a valid file"))
}

pub(crate) fn blunt_fin(test: &str) -> Option<TetMesh> {
    let data = data(test, "bluntfinxyz.bin")?;
    let field = data.field(Some("density")).expect("a field");
    let mesh = TetMesh::with_split(data.points, &data.cells, field, Split::FiveAlternating);
    let mesh = mesh.expect("a mesh");
    // Of the 187 395 of the paper, those with four corners at different places.
    assert_eq!(mesh.cell_count(), 187_395 - 77);
    Some(mesh)
}

pub(crate) fn super_phoenix(test: &str) -> Option<TetMesh> {
    let data = data(test, "spx.vtu")?;
    Some(data.into_mesh(None).expect("a mesh"))
}

pub(crate) fn liquid_oxygen_post(test: &str) -> Option<TetMesh> {
    let data = data(test, "postxyz.bin")?;
    let field = data.fields.iter().find(|f| f.name.contains("energy"));
    let field = field.map(|field| field.name.clone());
    Some(data.into_mesh(field.as_deref()).expect("a mesh"))
}

/// Seven blocks that touch but share no point.
pub(crate) fn angular_sector(test: &str) -> Option<TetMesh> {
    let data = data(test, "AngularSector.vtk")?;
    // Its only field numbers the points.
    let scalars = Scalars {
        name: "distance".into(),
        association: Association::Point,
        values: data.points.iter().map(|p| p.length()).collect(),
    };
    Some(TetMesh::new(data.points, &data.cells, scalars).expect("a mesh"))
}
