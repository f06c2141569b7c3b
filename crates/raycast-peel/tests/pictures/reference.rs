//! Ray casting against the ground truth, in every optical model.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Cells, Knot, OpticalModel, Scalars, TetMesh, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::counters::{CELL_VISITS, UNPAIRED_FACES};
use tetrascope_raycast_peel::{RaycastOptions, RaycastPeel};
use tetrascope_testing::{
    self as testing, ImageError, fitted, outside_and_inside, scale, split, truth, view,
};

use crate::common::{renderer, scene};

const SIDE: u32 = 64;

fn views(volume: &Volume) -> Vec<(&'static str, View)> {
    let [perspective, orthographic, inside] = outside_and_inside(volume, SIDE);
    vec![
        ("perspective", perspective),
        ("orthographic", orthographic),
        // Along an axis of the lattice: rays in faces and along edges.
        ("along z", fitted(volume, CameraFit::PlusZ, true, SIDE)),
        ("inside", inside),
    ]
}

/// The error that the tests of this file allow.
///
/// A segment in f32 errs by 2e-7 of its opacity and a sum of n of them by n · 2⁻²⁴;
/// a few hundred cells with scalars that are rounded to 2⁻²⁴ of the transfer
/// function's range, over which a steep knot triples the error, stay below 1e-5.
/// Where a ray grazes an edge the lengths err by 2⁻²⁴ over the sine of its angle:
/// 1e-4 of a single cell. Sums of light are as large as `scale`.
const RMSE: f64 = 2e-6;
const MAX: f64 = 1e-4;

fn check(gpu: &Gpu, name: &str, volume: &Volume, appearance: &Appearance) {
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let rays = renderer(gpu, volume, &appearance, &RaycastOptions::default());
        let reference = truth(volume, &appearance);
        for (from, view) in views(volume) {
            let frame = rays.render(&view).expect("a frame");
            let truth = reference.render_exact(&view).expect("a frame");
            let ImageError { rmse, max, .. } = ImageError::against(&truth.pixels, &frame);
            let scale = scale(&truth.pixels);
            let what = format!("{name}, {}, {from}", model.name());
            println!("{what}: rmse {rmse:.1e}, max {max:.1e} of {scale:.1}");
            assert_eq!(frame.stats.get(UNPAIRED_FACES), Some(0), "{what}");
            assert!(
                rmse <= RMSE * scale && max <= MAX * scale,
                "{what}: {rmse:e} {max:e}"
            );
        }
    }
}

#[test]
fn data_sets_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("data_sets_agree_with_the_reference") else {
        return;
    };
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
        check(&gpu, name, &volume, &appearance);
    }
}

fn mesh(name: &str, cells: u64) -> (TetMesh, Appearance) {
    match scene(name, cells) {
        (Volume::Mesh(mesh), appearance) => (mesh, appearance),
        _ => panic!("{name} is a mesh"),
    }
}

fn point_scalars(values: Vec<f64>) -> Scalars {
    testing::point_scalars(values)
}

#[test]
fn cell_scalars_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("cell_scalars_agree_with_the_reference") else {
        return;
    };
    let (mesh, appearance) = mesh("sphere", 2000);
    let mean = |cell| mesh.cell_scalars(cell).iter().sum::<f64>() / 4.0;
    let scalars = Scalars {
        name: "mean".into(),
        association: Association::Cell,
        values: (0..mesh.cell_count()).map(mean).collect(),
    };
    let points = mesh.points().to_vec();
    let mesh = TetMesh::from_tetrahedra(points, mesh.tetrahedra().to_vec(), scalars);
    check(
        &gpu,
        "cell scalars",
        &Volume::Mesh(mesh.expect("a mesh")),
        &appearance,
    );
}

/// Blocks that touch but share no point: coincident boundary faces everywhere.
#[test]
fn cells_that_share_no_point_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("cells_that_share_no_point_agree_with_the_reference") else {
        return;
    };
    let (mesh, appearance) = mesh("sphere", 600);
    check(&gpu, "split", &split(&mesh), &appearance);
}

/// A row of hexahedra whose lower edges are collapsed, as in the blunt fin: some of
/// their tetrahedra are left out. A scalar that is not a number makes the cells
/// around it transparent.
#[test]
fn degenerate_and_undefined_cells_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("degenerate_and_undefined_cells_agree_with_the_reference") else {
        return;
    };
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
    check(&gpu, "degenerate", &Volume::Mesh(mesh), &appearance);
}

/// A million miles from the origin and a micrometer wide: the same bits.
#[test]
fn place_and_size_change_nothing() {
    let Some(gpu) = testing::gpu("place_and_size_change_nothing") else {
        return;
    };
    let (mesh, appearance) = mesh("torus", 1500);
    let draw = |size: f64, place: DVec3| {
        let points = mesh.points().iter().map(|&p| (p + place) * size).collect();
        let scalars = mesh.scalars().clone();
        let moved = TetMesh::from_tetrahedra(points, mesh.tetrahedra().to_vec(), scalars);
        let volume = Volume::Mesh(moved.expect("a mesh"));
        let knots = appearance.transfer_function.knots().iter().map(|k| Knot {
            extinction: k.extinction / size,
            ..*k
        });
        let appearance = Appearance {
            transfer_function: TransferFunction::new(knots.collect()).expect("valid knots"),
            ..appearance.clone()
        };
        let options = RaycastOptions::default();
        let rays = RaycastPeel::new(&gpu, &volume, &appearance, &options).expect("a mesh");
        let camera = Camera::fit(&volume.bounds(), CameraFit::PlusX, false, 1.0);
        rays.render(&view(camera, SIDE)).expect("a frame").pixels
    };
    let here = draw(1.0, DVec3::ZERO);
    assert!(here == draw(2f64.powi(-40), DVec3::ZERO), "size");
    let there = draw(1.0, DVec3::splat(2f64.powi(20)));
    // The mesh's own coordinates lose 20 of f64's 53 bits there; f32 has 24.
    let worst = here.iter().flatten().zip(there.iter().flatten());
    let worst = worst.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
    assert!(worst < 1e-4, "place: {worst}");
}

#[test]
fn new_scalars_and_styles_give_what_a_new_renderer_gives() {
    let Some(gpu) = testing::gpu("new_scalars_and_styles_give_what_a_new_renderer_gives") else {
        return;
    };
    let (mesh, appearance) = mesh("heat-sink", 2000);
    let options = RaycastOptions::default();
    let new = |mesh: &TetMesh, appearance: &Appearance| {
        let volume = Volume::Mesh(mesh.clone());
        RaycastPeel::new(&gpu, &volume, appearance, &options).expect("a mesh")
    };
    let camera = Camera::fit(&mesh.bounds(), CameraFit::PlusIso, false, 1.0);
    let view = view(camera, SIDE);
    let frame = |rays: &RaycastPeel| rays.render(&view).expect("a frame").pixels;
    let mut rays = new(&mesh, &appearance);

    let values = mesh.scalars().values.iter().map(|s| 130.0 - s).collect();
    let turned = mesh
        .with_scalars(point_scalars(values))
        .expect("as many values");
    rays.reload(&Volume::Mesh(turned.clone())).expect("a mesh");
    assert!(frame(&rays) == frame(&new(&turned, &appearance)), "scalars");

    let emission = Appearance {
        optical_model: OpticalModel::Emission,
        ..appearance.clone()
    };
    rays.restyle(&emission).expect("a style");
    assert!(frame(&rays) == frame(&new(&turned, &emission)), "style");

    let values = (0..turned.cell_count()).map(|c| c as f64 / turned.cell_count() as f64 * 60.0);
    let per_cell = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values: values.collect(),
    };
    let per_cell = turned.with_scalars(per_cell).expect("as many values");
    rays.reload(&Volume::Mesh(per_cell.clone()))
        .expect("a mesh");
    assert!(
        frame(&rays) == frame(&new(&per_cell, &emission)),
        "association"
    );

    let (sphere, _) = self::mesh("sphere", 700);
    rays.reload(&Volume::Mesh(sphere.clone())).expect("a mesh");
    assert!(frame(&rays) == frame(&new(&sphere, &emission)), "geometry");
}

#[test]
fn early_stop_changes_no_more_than_it_says() {
    let Some(gpu) = testing::gpu("early_stop_changes_no_more_than_it_says") else {
        return;
    };
    let (mesh, appearance) = mesh("sphere", 5000);
    let volume = Volume::Mesh(mesh);
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let draw = |stop_opacity| {
        let options = RaycastOptions {
            stop_opacity,
            ..RaycastOptions::default()
        };
        let rays = RaycastPeel::new(&gpu, &volume, &appearance, &options).expect("a mesh");
        rays.render(&view).expect("a frame")
    };
    let (exact, stopped) = (draw(1.0), draw(0.6));
    let all = exact
        .pixels
        .iter()
        .flatten()
        .zip(stopped.pixels.iter().flatten());
    let worst = all.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
    assert!(worst > 0.0 && worst <= 0.4, "{worst}");
    assert!(stopped.stats.get(CELL_VISITS) < exact.stats.get(CELL_VISITS));
    // Colors are at most 1 here, so what is hidden is at most what shines through.
}

#[test]
fn a_mesh_takes_twenty_bytes_a_cell() {
    let Some(gpu) = testing::gpu("a_mesh_takes_twenty_bytes_a_cell") else {
        return;
    };
    let (mesh, appearance) = mesh("sphere", 20_000);
    let volume = Volume::Mesh(mesh.clone());
    let options = RaycastOptions::default();
    let rays = RaycastPeel::new(&gpu, &volume, &appearance, &options).expect("a mesh");
    // Lists of texels fill rows of 4096.
    let list = |count: usize, texel: usize| match count {
        ..4096 => texel * count,
        _ => texel * count.div_ceil(4096) * 4096,
    };
    let (cells, vertices) = (mesh.cell_count(), mesh.points().len());
    let volume = list(cells, 4) + list(cells, 16) + list(vertices, 16);
    let entry = list(mesh.boundary_faces().len(), 16);
    let intervals = 48 * (appearance.transfer_function.knots().len() + 1);
    let bytes = rays.bytes_resident() as usize;
    // A texel each for cell data and for a table of integrals, which this scene does not need.
    let unused = bytes - (volume + entry + intervals);
    assert!(unused <= 32, "{bytes}, {unused} unused");
    assert!(volume <= 20 * cells + 16 * vertices + 3 * 16 * 4096);
}
