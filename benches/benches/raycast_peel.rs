//! Tables 1 to 4 of Bernardon, Pagot, Comba and Silva, what tiles are worth, how rays find the
//! boundary fastest, how frame time grows with the mesh, and what the order of cells in memory is worth:
//! `raycast-peel/tables/blunt/187k cells/table-2d-fixed/4x4`.
//!
//! Times are wall times with the readback in them. What is compared is drawn in turn, and a time
//! is the median over the rounds, so that a machine that is busy at times favors nobody;
//! criterion is handed the samples. Rounds end with a budget: all of this takes a few minutes.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use tetrascope::Context;
use tetrascope::core::glam::DVec3;
use tetrascope::core::mesh::{Association, NO_NEIGHBOR};
use tetrascope::core::{
    Appearance, Camera, CameraFit, FrameStats, Knot, OpticalModel, Scalars, TetMesh,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope::gpu::Gpu;
use tetrascope::raycast_peel::counters::{
    CELL_VISITS, FRAGMENTS, LAYERS, LEAST_TILE_PASSES, MOST_TILE_PASSES,
};
use tetrascope::raycast_peel::{
    Crossings, Entries, Integration, Locality, Passes, RaycastOptions, RaycastPeel,
};
use tetrascope_benches::results::keep;
use tetrascope_testing::{angular_sector, blunt_fin, data_set, liquid_oxygen_post, mesh_data};

/// Pixels per side of the tables, whose paper has 512, and of growth.
const SIDE: u32 = 256;

/// Pixels per side where tiles are compared.
const TILED_SIDE: u32 = 512;

/// Rounds end when this is used up, after the first.
const BUDGET: Duration = Duration::from_secs(15);

/// The most rounds.
const ROUNDS: usize = 7;

/// Who skips what is missing.
const BENCH: &str = tetrascope::raycast_peel::NAME;

/// The device, or why there is none.
fn gpu(context: &Context) -> Option<&Gpu> {
    tetrascope_benches::gpu(context, BENCH)
}

/// The mesh that the paper calls spx1: each cell of spx in eight, through the midpoints of
/// its edges, which the file has as points that no cell uses.
fn refined_spx() -> Option<TetMesh> {
    let data = mesh_data(BENCH, "spx.vtu")?;
    let points = data.points.clone();
    let field = data.scalars(0).expect("a field");
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

fn views(volume: &Volume, side: u32) -> [View; 3] {
    [CameraFit::PlusIso, CameraFit::MinusIso, CameraFit::PlusX].map(|from| View {
        camera: Camera::fit(&volume.bounds(), from, false, 1.0),
        width: side,
        height: side,
        background: [0.0; 4],
    })
}

fn new(gpu: &Gpu, volume: &Volume, options: &RaycastOptions) -> RaycastPeel {
    let Volume::Mesh(mesh) = volume else {
        panic!("a mesh")
    };
    RaycastPeel::new(gpu, volume, &ramp(mesh), options).expect("a mesh")
}

/// One picture of one renderer, drawn in turn with others.
struct Course<'a> {
    renderer: &'a RaycastPeel,
    view: View,
    /// Seconds.
    samples: Vec<f64>,
    stats: FrameStats,
}

impl<'a> Course<'a> {
    fn new(renderer: &'a RaycastPeel, view: View) -> Course<'a> {
        Course {
            renderer,
            view,
            samples: Vec::new(),
            stats: FrameStats::default(),
        }
    }

    fn median(&self) -> f64 {
        let mut sorted = self.samples.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

/// Draws each once to warm up, then all in turn.
fn run(courses: &mut [Course]) {
    for course in &mut *courses {
        let frame = course.renderer.render(&course.view).expect("a frame");
        course.stats = frame.stats;
    }
    let start = Instant::now();
    for round in 0..ROUNDS {
        if round > 0 && start.elapsed() > BUDGET {
            break;
        }
        for course in &mut *courses {
            let frame = course.renderer.render(&course.view).expect("a frame");
            course.samples.push(frame.stats.cpu_seconds);
        }
    }
}

/// Hands criterion what was measured.
fn report(criterion: &mut Criterion, group: &str, name: &str, courses: &[Course]) {
    let rounds = courses[0].samples.len();
    let sums: Vec<Duration> = (0..rounds)
        .map(|round| courses.iter().map(|c| c.samples[round]).sum())
        .map(Duration::from_secs_f64)
        .collect();
    let mut group = criterion.benchmark_group(group);
    // Nothing runs here: criterion asks for sums of samples.
    group
        .sample_size(10)
        .warm_up_time(Duration::from_nanos(1))
        .measurement_time(Duration::from_nanos(1));
    let mut next = sums.iter().cycle();
    group.bench_function(name, |b| {
        b.iter_custom(|iterations| next.by_ref().take(iterations as usize).sum());
    });
    group.finish();
}

fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let around = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
    values.into_iter().fold((f64::INFINITY, 0.0), around)
}

/// The columns of the paper's tables for one mesh and one table of integrals, over three cameras.
struct Rows {
    name: &'static str,
    cells: usize,
    /// Least and greatest over the cameras, seconds, by the number of tiles a side.
    seconds: [(f64, f64); 6],
    /// Least and greatest over the cameras and the tiles.
    passes: (f64, f64),
}

fn measure(
    criterion: &mut Criterion,
    gpu: &Gpu,
    (name, volume): (&'static str, &Volume),
    (table, integration): (&str, Integration),
) -> Rows {
    let cells = volume.cell_count();
    let renderers = [1, 2, 3, 4, 5, 6].map(|tiles| {
        let options = RaycastOptions {
            passes: Passes::PingPong,
            crossings: Crossings::Planes, // as published
            integration,
            tiles,
            stop_opacity: 0.95,
            ..RaycastOptions::default()
        };
        new(gpu, volume, &options)
    });
    let views = views(volume, SIDE);
    let mut courses: Vec<Course> = renderers
        .iter()
        .flat_map(|renderer| views.map(|view| Course::new(renderer, view)))
        .collect();
    run(&mut courses);
    let mut rows = Rows {
        name,
        cells,
        seconds: [(0.0, 0.0); 6],
        passes: range(courses.iter().flat_map(|c| {
            let passes = [LEAST_TILE_PASSES, MOST_TILE_PASSES].into_iter();
            passes.filter_map(|of| Some(c.stats.get(of)? as f64))
        })),
    };
    let group = format!("raycast-peel/tables/{name}/{}k cells/{table}", cells / 1000);
    keep(&format!("{group}/passes least"), rows.passes.0);
    keep(&format!("{group}/passes most"), rows.passes.1);
    for (tiles, (courses, seconds)) in (1..).zip(courses.chunks(3).zip(&mut rows.seconds)) {
        report(criterion, &group, &format!("{tiles}x{tiles}"), courses);
        *seconds = range(courses.iter().map(Course::median));
    }
    rows
}

fn print_tables(flat: &[Rows], deep: &[Rows]) {
    println!("Table 1: mesh, tetrahedra, frames/s and Ktet/s, least and greatest");
    for rows in flat {
        let seconds = rows.seconds.iter().flat_map(|&(a, b)| [a, b]);
        let (quick, slow) = range(seconds);
        let cells = rows.cells as f64 / 1e3;
        println!(
            "{:>6} {cells:.0}K {:.2} {:.2} {:.0} {:.0}",
            rows.name,
            1.0 / slow,
            1.0 / quick,
            cells / slow,
            cells / quick
        );
    }
    println!("Table 2: passes a tile, least and greatest, with two axes and with three");
    for (flat, deep) in flat.iter().zip(deep) {
        let ((a, b), (c, d)) = (flat.passes, deep.passes);
        println!("{:>6} {a} {b} {c} {d}", flat.name);
    }
    for (number, axes, all) in [(3, "two", flat), (4, "three", deep)] {
        println!("Table {number}: ms with {axes} axes, 1x1 to 6x6 tiles");
        for rows in all {
            let times = rows
                .seconds
                .map(|(a, b)| format!("{:.0}-{:.0}", 1e3 * a, 1e3 * b));
            println!("{:>6} {}", rows.name, times.join(" "));
        }
    }
}

fn tables(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let meshes = [
        ("spx1", refined_spx()),
        ("blunt", blunt_fin(BENCH)),
        ("sphere", Some(data_set("sphere", Some(240_000)))),
    ];
    let (mut flat, mut deep) = (Vec::new(), Vec::new());
    for (name, mesh) in meshes {
        let Some(mesh) = mesh else { continue };
        let mesh = (name, &Volume::Mesh(mesh));
        let two = ("table-2d-fixed", Integration::TableFixed { n: 256 });
        flat.push(measure(criterion, gpu, mesh, two));
        let three = ("table-3d", Integration::Table3d { n: 64 });
        deep.push(measure(criterion, gpu, mesh, three));
    }
    print_tables(&flat, &deep);
    println!("{SIDE}x{SIDE} pixels on {}", gpu.describe());
}

/// The benefit of tiles and of occlusion queries on the Blunt Fin: frames with 1x1 and 4x4 tiles.
fn tiling(criterion: &mut Criterion) {
    let context = Context::new();
    let (Some(gpu), Some(mesh)) = (gpu(&context), blunt_fin(BENCH)) else {
        return;
    };
    let volume = Volume::Mesh(mesh);
    let [sides, planes] = Crossings::ALL;
    let kinds = [
        (sides, 1, 8),
        (sides, 4, 8),
        (sides, 1, 32),
        (sides, 4, 32),
        (planes, 1, 8),
        (planes, 4, 8),
    ];
    let renderers = kinds.map(|((_, crossings), tiles, query_interval)| {
        let options = RaycastOptions {
            passes: Passes::PingPong,
            crossings,
            tiles,
            query_interval,
            ..RaycastOptions::default()
        };
        new(gpu, &volume, &options)
    });
    let [view, ..] = views(&volume, TILED_SIDE);
    let mut courses = renderers.each_ref().map(|r| Course::new(r, view));
    run(&mut courses);
    for (((by, _), tiles, interval), course) in kinds.iter().zip(&courses) {
        let stats = &course.stats;
        println!(
            "by {by}, {tiles}x{tiles} tiles, a query every {interval} passes: {:.0} ms, {} passes, \
             {:.1} M fragments",
            1e3 * course.median(),
            stats.passes,
            1e-6 * stats.get(FRAGMENTS).unwrap_or(0) as f64
        );
        let name = format!("{by}/{tiles}x{tiles}/{interval}");
        let group = "raycast-peel/tiling/blunt/187k cells";
        report(criterion, group, &name, std::slice::from_ref(course));
    }
}

/// Whether rays find boundary faces faster by lists for tiles or by peeled layers.
fn entries(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let made = |name| Some(data_set(name, None));
    let meshes = [
        ("blunt", blunt_fin(BENCH)),
        (
            "spx",
            mesh_data(BENCH, "spx.vtu").map(|data| data.into_mesh(None).expect("a mesh")),
        ),
        ("post", liquid_oxygen_post(BENCH)),
        ("sector", angular_sector(BENCH)),
        ("torus", made("torus")),
        ("sphere", made("sphere")),
    ];
    for (name, mesh) in meshes {
        let Some(mesh) = mesh else { continue };
        let volume = Volume::Mesh(mesh);
        let [view, ..] = views(&volume, TILED_SIDE);
        let renderers = Entries::ALL.map(|(_, entries)| {
            let options = RaycastOptions {
                entries,
                ..RaycastOptions::default()
            };
            new(gpu, &volume, &options)
        });
        let mut courses = renderers.each_ref().map(|r| Course::new(r, view));
        run(&mut courses);
        let group = format!(
            "raycast-peel/entries/{name}/{}k cells",
            volume.cell_count() / 1000
        );
        for ((by, _), course) in Entries::ALL.iter().zip(&courses) {
            let layers = course.stats.get(LAYERS);
            println!(
                "{name}, {by}: {:.0} ms{}",
                1e3 * course.median(),
                layers.map_or(String::new(), |n| format!(", {n} layers"))
            );
            report(criterion, &group, by, std::slice::from_ref(course));
        }
    }
}

/// The exponent of least squares through points of logarithms.
fn exponent(samples: &[(f64, f64)]) -> f64 {
    let count = samples.len() as f64;
    let logs = || samples.iter().map(|&(x, y)| (x.ln(), y.ln()));
    let (x, y) = logs().fold((0.0, 0.0), |(x, y), s| (x + s.0, y + s.1));
    let (x, y) = (x / count, y / count);
    let rise: f64 = logs().map(|s| (s.0 - x) * (s.1 - y)).sum();
    let run: f64 = logs().map(|s| (s.0 - x).powi(2)).sum();
    rise / run
}

/// A ray crosses as many cells as the cube root of their number: the exponent is 1/3 where
/// nothing else counts.
fn growth(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let volumes = [20_000, 60_000, 200_000, 600_000, 2_000_000]
        .map(|n| Volume::Mesh(data_set("sphere", Some(n))));
    let renderers = volumes
        .each_ref()
        .map(|volume| new(gpu, volume, &RaycastOptions::default()));
    let [view, ..] = views(&volumes[0], SIDE);
    let mut courses = renderers.each_ref().map(|r| Course::new(r, view));
    run(&mut courses);
    let (mut times, mut visits) = (Vec::new(), Vec::new());
    for (volume, course) in volumes.iter().zip(&courses) {
        let cells = volume.cell_count() as f64;
        let visited = course.stats.get(CELL_VISITS).expect("counted") as f64;
        println!(
            "{cells} cells: {:.1} ms, {:.2} M visits, {:.1} M a second",
            1e3 * course.median(),
            1e-6 * visited,
            1e-6 * visited / course.median()
        );
        times.push((cells, course.median()));
        visits.push((cells, visited));
        let name = format!("{}k cells", volume.cell_count() / 1000);
        let group = "raycast-peel/growth/sphere";
        report(criterion, group, &name, std::slice::from_ref(course));
    }
    println!(
        "of the number of cells, frame time grows as the power {:.2} and visits as {:.2}, on {}",
        exponent(&times),
        exponent(&visits),
        gpu.describe()
    );
}

/// `mesh` with its cells and points in another order.
fn reordered(mesh: &TetMesh, cells: &[u32], points: &[u32]) -> TetMesh {
    let mut place = vec![0; points.len()];
    for (new, &old) in (0..).zip(points) {
        place[old as usize] = new;
    }
    let tetrahedra = cells
        .iter()
        .map(|&cell| mesh.tetrahedra()[cell as usize].map(|point| place[point as usize]));
    let values = &mesh.scalars().values;
    let scalars = Scalars {
        values: points.iter().map(|&p| values[p as usize]).collect(),
        ..mesh.scalars().clone()
    };
    let moved = points.iter().map(|&p| mesh.points()[p as usize]).collect();
    TetMesh::from_tetrahedra(moved, tetrahedra.collect(), scalars).expect("a mesh")
}

/// 0 to `count` in a random order (Fisher and Yates; Numerical Recipes' generator).
fn shuffled(count: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut x = 1u32;
    for last in (1..count).rev() {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        order.swap(last, ((u64::from(x) * (last as u64 + 1)) >> 32) as usize);
    }
    order
}

/// Cells by their distance from the first, in steps from neighbor to neighbor, and points as
/// these cells meet them.
fn breadth_first(mesh: &TetMesh) -> (Vec<u32>, Vec<u32>) {
    let mut cells = vec![0];
    let mut points = Vec::new();
    let mut is_listed = vec![false; mesh.cell_count()];
    let mut is_met = vec![false; mesh.points().len()];
    is_listed[0] = true;
    let mut next = 0;
    while next < cells.len() {
        let cell = cells[next] as usize;
        next += 1;
        for &point in &mesh.tetrahedra()[cell] {
            if !std::mem::replace(&mut is_met[point as usize], true) {
                points.push(point);
            }
        }
        for &neighbor in &mesh.neighbors()[cell] {
            if neighbor != NO_NEIGHBOR
                && !std::mem::replace(&mut is_listed[neighbor as usize], true)
            {
                cells.push(neighbor);
            }
        }
    }
    (cells, points)
}

/// The order of cells and vertices in memory, in a mesh that no cache holds.
fn order(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let mesh = data_set("sphere", Some(2_000_000));
    let random = reordered(
        &mesh,
        &shuffled(mesh.cell_count()),
        &shuffled(mesh.points().len()),
    );
    let (cells, points) = breadth_first(&mesh);
    assert_eq!(
        (cells.len(), points.len()),
        (mesh.cell_count(), mesh.points().len())
    );
    let breadth_first = reordered(&mesh, &cells, &points);
    let orders = [
        ("morton", Locality::Morton, mesh.clone()),
        ("as-given", Locality::AsGiven, mesh),
        ("breadth-first", Locality::AsGiven, breadth_first),
        ("random", Locality::AsGiven, random),
    ];
    let orders = orders.map(|(name, locality, mesh)| (name, locality, Volume::Mesh(mesh)));
    let [view, ..] = views(&orders[0].2, SIDE);
    let renderers = orders.each_ref().map(|(_, locality, volume)| {
        let options = RaycastOptions {
            locality: *locality,
            ..RaycastOptions::default()
        };
        new(gpu, volume, &options)
    });
    let mut courses = renderers.each_ref().map(|r| Course::new(r, view));
    run(&mut courses);
    for ((name, ..), course) in orders.iter().zip(&courses) {
        let visits = course.stats.get(CELL_VISITS).expect("counted") as f64;
        println!(
            "2M cells, {name}: {:.0} ms, {:.1} M visits a second",
            1e3 * course.median(),
            1e-6 * visits / course.median()
        );
        let group = "raycast-peel/order/sphere/2000k cells";
        report(criterion, group, name, std::slice::from_ref(course));
    }
}

criterion_group!(benches, tables, tiling, entries, growth, order);
criterion_main!(benches);
