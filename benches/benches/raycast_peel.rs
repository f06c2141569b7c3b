//! Tables 1 to 4 of Bernardon, Pagot, Comba and Silva, how frame time grows with the mesh, and
//! what the order of cells in memory is worth:
//! `raycast-peel/tables/blunt/187k cells/exact/4x4`.
//!
//! Times are wall times with the readback in them.

use std::collections::HashMap;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use tetrascope::Context;
use tetrascope::core::glam::DVec3;
use tetrascope::core::mesh::{Association, Split};
use tetrascope::core::{
    Appearance, Camera, CameraFit, Frame, Knot, OpticalModel, Scalars, TetMesh, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope::datasets::{Options, find};
use tetrascope::gpu::Gpu;
use tetrascope::io::{MeshData, ReadOptions, read_mesh};
use tetrascope::raycast_peel::{Integration, Locality, Passes, RaycastOptions, RaycastPeel};

/// Pixels a side; the paper has 512.
const SIDE: u32 = 256;

/// The device, or why there is none.
fn gpu(context: &Context) -> Option<&Gpu> {
    context
        .gpu()
        .inspect_err(|error| eprintln!("skipped: raycast-peel: {error}"))
        .ok()
}

/// A mesh file; without it, says that it is skipped.
fn data(name: &str) -> Option<MeshData> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let folder = std::env::var_os("TETRASCOPE_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.is_file() {
        eprintln!("skipped: there is no {}", path.display());
        return None;
    }
    Some(read_mesh(&path, &ReadOptions::default()).expect("a valid file"))
}

fn sphere(cells: u64) -> TetMesh {
    let options = Options {
        cells: Some(cells),
        ..Options::default()
    };
    let dataset = find("sphere").expect("a data set");
    dataset.mesh(&options).expect("a mesh")
}

fn blunt_fin() -> Option<TetMesh> {
    let data = data("bluntfinxyz.bin")?;
    let field = data.field(Some("density")).expect("a field").clone();
    let mesh = TetMesh::with_split(data.points, &data.cells, field, Split::FiveAlternating);
    Some(mesh.expect("a mesh"))
}

/// The mesh that the paper calls spx1: each cell of spx in eight, through the midpoints of
/// its edges, which the file has as points that no cell uses.
fn refined_spx() -> Option<TetMesh> {
    let data = data("spx.vtu")?;
    let points = data.points.clone();
    let field = data.fields[0].clone();
    let coarse = data.into_mesh(None).expect("a mesh");
    let mut used = vec![false; points.len()];
    for &point in coarse.tetrahedra().iter().flatten() {
        used[point as usize] = true;
    }
    let mut by_x: Vec<u32> = (0..points.len() as u32)
        .filter(|&point| !used[point as usize])
        .collect();
    by_x.sort_by(|&a, &b| points[a as usize].x.total_cmp(&points[b as usize].x));
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let place = (points[a as usize] + points[b as usize]) / 2.0;
            // The file's midpoints are off by up to 1.7e-5.
            let start = by_x.partition_point(|&p| points[p as usize].x < place.x - 1e-4);
            let near = by_x[start..]
                .iter()
                .take_while(|&&p| points[p as usize].x <= place.x + 1e-4);
            let distance = |p: &&u32| points[**p as usize].distance_squared(place);
            let nearest = near.min_by(|p, q| distance(p).total_cmp(&distance(q)));
            *nearest.expect("every edge has its midpoint")
        })
    };
    let mut cells = Vec::new();
    for &[a, b, c, d] in coarse.tetrahedra() {
        let [ab, ac, ad] = [middle(a, b), middle(a, c), middle(a, d)];
        let [bc, bd, cd] = [middle(b, c), middle(b, d), middle(c, d)];
        // Four corners, and the octahedron between them around its diagonal ac-bd.
        cells.extend([
            [a, ab, ac, ad],
            [ab, b, bc, bd],
            [ac, bc, c, cd],
            [ad, bd, cd, d],
        ]);
        for [p, q] in [[ab, bc], [bc, cd], [cd, ad], [ad, ab]] {
            cells.push([ac, bd, p, q]);
        }
    }
    let scalars = Scalars {
        association: Association::Point,
        ..field
    };
    let mesh = TetMesh::from_tetrahedra(points.clone(), cells, scalars).expect("a mesh");
    assert_eq!(mesh.cell_count(), 103_488);
    assert_eq!(mesh.boundary_faces().len(), 11_040);
    Some(mesh)
}

/// A transparent ramp, so that rays go all the way.
fn ramp(mesh: &TetMesh) -> Appearance {
    let (low, high) = mesh.scalar_range().expect("scalars");
    let size = mesh.bounds().diagonal();
    let knot = |scalar, depth| Knot {
        scalar,
        color: DVec3::new(0.2, 0.6, 0.9),
        extinction: depth / size,
    };
    let function = TransferFunction::new(vec![knot(low, 0.5), knot(high, 3.0)]);
    let function = function.expect("valid knots");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

fn views(volume: &Volume) -> [View; 3] {
    [CameraFit::PlusIso, CameraFit::MinusIso, CameraFit::PlusX].map(|from| View {
        camera: Camera::fit(&volume.bounds(), from, false, 1.0),
        width: SIDE,
        height: SIDE,
        background: [0.0; 4],
    })
}

/// The least of three frames' seconds, and the frame.
fn quickest(renderer: &RaycastPeel, view: &View) -> (f64, Frame) {
    let frames = [(); 3].map(|()| renderer.render(view).expect("a frame"));
    let seconds = frames.iter().map(|f| f.stats.cpu_seconds);
    let least = seconds.fold(f64::INFINITY, f64::min);
    let [frame, ..] = frames;
    (least, frame)
}

fn new(gpu: &Gpu, volume: &Volume, options: &RaycastOptions) -> RaycastPeel {
    let Volume::Mesh(mesh) = volume else {
        panic!("a mesh")
    };
    RaycastPeel::new(gpu, volume, &ramp(mesh), options).expect("a mesh")
}

fn range(values: &[f64]) -> (f64, f64) {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    (least, values.iter().copied().fold(0.0, f64::max))
}

/// Over three cameras: the time of all frames, and of each tile the least and greatest
/// number of passes.
fn tables(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let meshes = [
        ("spx1", refined_spx()),
        ("blunt", blunt_fin()),
        ("sphere", Some(sphere(240_000))),
    ];
    for (name, mesh) in meshes {
        let Some(mesh) = mesh else { continue };
        let cells = mesh.cell_count();
        let volume = Volume::Mesh(mesh);
        for (table, integration) in [
            ("exact", Integration::Exact),
            ("table-3d", Integration::Table3d { n: 64 }),
        ] {
            let group = format!("raycast-peel/tables/{name}/{}k cells/{table}", cells / 1000);
            let mut group = criterion.benchmark_group(group);
            group
                .sample_size(10)
                .measurement_time(Duration::from_secs(3));
            for tiles in 1..=6 {
                let options = RaycastOptions {
                    passes: Passes::PingPong,
                    integration,
                    tiles,
                    ..RaycastOptions::default()
                };
                let renderer = new(gpu, &volume, &options);
                let views = views(&volume);
                group.bench_function(format!("{tiles}x{tiles}"), |b| {
                    b.iter(|| {
                        views.map(|view| black_box(renderer.render(&view).expect("a frame")))
                    });
                });
                let frames = views.map(|view| quickest(&renderer, &view));
                let (quick, slow) = range(&frames.each_ref().map(|(seconds, _)| *seconds));
                let passes: Vec<f64> = frames
                    .iter()
                    .flat_map(|(_, f)| f.stats.tile_passes.into_iter().flatten())
                    .map(|n| n as f64)
                    .collect();
                let (fewest, most) = range(&passes);
                let fragments = frames.iter().filter_map(|(_, f)| f.stats.fragments);
                println!(
                    "{name}, {table}, {tiles}x{tiles} tiles: {:.0}-{:.0} ms, {:.0}-{:.0} Ktet/s, \
                     {fewest}-{most} passes a tile, {} fragments",
                    1e3 * quick,
                    1e3 * slow,
                    1e-3 * cells as f64 / slow,
                    1e-3 * cells as f64 / quick,
                    fragments.sum::<u64>()
                );
            }
            group.finish();
        }
    }
}

/// A ray crosses as many cells as the cube root of their number: the exponent is 1/3 where
/// nothing else counts. Not criterion's: what counts is one number over all sizes.
fn growth(_: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let mut samples = Vec::new();
    for cells in [20_000, 60_000, 200_000, 600_000, 2_000_000] {
        let mesh = sphere(cells);
        let cells = mesh.cell_count() as f64;
        let volume = Volume::Mesh(mesh);
        for locality in [Locality::Morton, Locality::AsGiven] {
            let options = RaycastOptions {
                locality,
                ..RaycastOptions::default()
            };
            let renderer = new(gpu, &volume, &options);
            let [view, ..] = views(&volume);
            let (seconds, frame) = quickest(&renderer, &view);
            let visits = frame.stats.cell_visits.expect("counted") as f64;
            println!(
                "{cells} cells, {locality:?}: {:.1} ms, {:.1} M visits/s",
                1e3 * seconds,
                1e-6 * visits / seconds
            );
            if locality == Locality::Morton {
                samples.push((cells.ln(), seconds.ln()));
            }
        }
    }
    // Least squares.
    let count = samples.len() as f64;
    let (x, y) = samples
        .iter()
        .fold((0.0, 0.0), |(x, y), s| (x + s.0, y + s.1));
    let (x, y) = (x / count, y / count);
    let rise: f64 = samples.iter().map(|s| (s.0 - x) * (s.1 - y)).sum();
    let run: f64 = samples.iter().map(|s| (s.0 - x).powi(2)).sum();
    println!(
        "frame time grows as the number of cells to the {:.2} on {}",
        rise / run,
        gpu.describe()
    );
}

criterion_group!(benches, tables, growth);
criterion_main!(benches);
