//! Meshes in clusters against the same meshes in one part.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use tetrascope_core::clusters::{Cluster, ClusterSource, MeshClusters};
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, CameraFit, DepthCue, Error, Frame, OpticalModel, Scalars, Stop, TetMesh,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::{
    CLUSTERS_COVERED, CLUSTERS_DRAWN, CLUSTERS_HIDDEN, CLUSTERS_OUTSIDE, CLUSTERS_READ, LOST_RAYS,
};
use tetrascope_raycast_cpu::{Domain, PathSegments, RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{
    HARD_MESHES, exactly, fitted, inside, knot, ramp, scale, surfaces, tilted, view,
};

use crate::common::{MAX, mesh, renderer};

/// About so many clusters.
fn cut(mesh: &TetMesh, parts: usize) -> MeshClusters {
    let most = mesh.cell_count().div_ceil(parts) as u32;
    MeshClusters::of(mesh, most).expect("cut")
}

fn draw(clusters: &MeshClusters, appearance: &Appearance, view: &View) -> Frame {
    let volume = Volume::Clusters(clusters.clone());
    let frame = renderer(&volume, appearance).render(view).expect("a frame");
    assert_eq!(frame.stats.get(LOST_RAYS), Some(0));
    frame
}

/// The greatest difference of channels, of those pixels that differ by no more than `most`; and how many differ
/// by more.
fn difference(a: &Frame, b: &Frame, most: f64) -> (f64, usize) {
    let worst = |(a, b): (&[f32; 4], &[f32; 4])| {
        let channels = a.iter().zip(b);
        channels.fold(0.0, |w: f64, (a, b)| w.max(f64::from((a - b).abs())))
    };
    let pixels: Vec<f64> = a.pixels.iter().zip(&b.pixels).map(worst).collect();
    let (near, far): (Vec<f64>, Vec<f64>) = pixels.iter().partition(|worst| **worst <= most);
    (near.into_iter().fold(0.0, f64::max), far.len())
}

/// Each of a ray's segments rounds its light by 2⁻²⁴, and its ends are computed from the corners of
/// their faces in another order and in f64: that is as if the ray had moved by 2⁻²⁴, which changes
/// the light of the cells at both ends by some 2⁻²³ of a cell's.
const MOST: f64 = 2e-6;

/// The same where the light jumps at faces: there it is the length in a cell that changes, by 2⁻²⁴ over the sine of
/// the angle between ray and face, which is `common::MAX` at the worst. Where cells are thinner than f32 resolves, and
/// inside out, a ray's way back through them is cut off within a part, and between two it is not.
const MOST_AT_JUMPS: f64 = MAX;

/// Pixels of 64² whose ray is within a rounding of a surface's outline, and meets it or not.
const OUTLINE: usize = 2;

fn check(
    most: f64,
    name: &str,
    (mesh, appearance): (&TetMesh, &Appearance),
    parts: &[usize],
    views: &[View],
) {
    let volume = Volume::Mesh(mesh.clone());
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let whole = renderer(&volume, &appearance);
        for view in views {
            let whole = whole.render(view).expect("a frame");
            let most = most * scale(&exactly(&whole));
            let outline = match model {
                OpticalModel::Isosurfaces => OUTLINE,
                _ => 0,
            };
            for &parts in parts {
                let found = draw(&cut(mesh, parts), &appearance, view);
                let (near, far) = difference(&whole, &found, most);
                println!(
                    "{name}, {}, {parts} parts: {near:.1e}, {far} beyond",
                    model.name()
                );
                assert!(
                    far <= outline,
                    "{name}, {}, {parts} parts: {far}",
                    model.name()
                );
                let depths = [&whole, &found].map(|frame| frame.depths.clone());
                assert_eq!(depths[0].is_some(), model == OpticalModel::Isosurfaces);
                if let [Some(a), Some(b)] = depths {
                    // In parts of a distance of some volumes' sizes.
                    let same = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= 4e-6 * a.abs();
                    let other = a.iter().zip(&b).filter(|pair| !same(*pair)).count();
                    assert!(other <= outline, "{name}, {parts} parts: {other} depths");
                }
            }
        }
    }
}

/// In perspective; along axes, so that rays go through faces, edges and vertices; and from inside.
fn views(volume: &Volume) -> Vec<View> {
    vec![
        fitted(volume, CameraFit::PlusIso, false, 64),
        fitted(volume, CameraFit::PlusX, true, 48),
        view(inside(volume), 48),
    ]
}

#[test]
fn any_number_of_parts_gives_the_picture_of_one() {
    for (name, cells) in [
        ("sphere", 5 * 8 * 8 * 8),
        ("torus", 3000),
        ("delaunay", 2000),
    ] {
        let (mesh, appearance) = mesh(name, cells);
        let volume = Volume::Mesh(mesh.clone());
        let appearance = surfaces(&volume, appearance);
        let scene = (&mesh, &appearance);
        check(MOST, name, scene, &[1, 2, 3, 7, 64], &views(&volume));
    }
}

/// Planes end rays within clusters, and a cue is that of the whole.
#[test]
fn clips_and_cues_are_those_of_the_whole() {
    let (mesh, appearance) = mesh("torus", 3000);
    let volume = Volume::Mesh(mesh.clone());
    let appearance = Appearance {
        clip_planes: tilted(&volume),
        depth_cue: Some(DepthCue { strength: 0.7 }),
        ..surfaces(&volume, appearance)
    };
    check(
        MOST,
        "cut torus",
        (&mesh, &appearance),
        &[7],
        &views(&volume),
    );
}

/// One scalar per cell; and four per cell, which jump at every face.
#[test]
fn fields_that_jump_are_those_of_the_whole() {
    let (mesh, appearance) = mesh("delaunay", 2000);
    let count = mesh.cell_count();
    let (low, high) = mesh.scalar_range().expect("a field");
    let share = |i: usize| low + (high - low) * (0.5 + 0.5 * (i as f64 * 12.9898).sin());
    let of_cells = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values: (0..count).map(share).collect(),
    };
    let of_cells = mesh.with_scalars(of_cells).expect("as many");
    let points: Vec<DVec3> = (0..count).flat_map(|cell| mesh.cell_points(cell)).collect();
    let cells: Vec<[u32; 4]> = (0..count as u32)
        .map(|i| [0, 1, 2, 3].map(|c| 4 * i + c))
        .collect();
    let of_corners = Scalars {
        name: "d".into(),
        association: Association::Point,
        // Some of them without a value.
        values: (0..4 * count)
            .map(|i| if i % 97 == 5 { f64::NAN } else { share(i) })
            .collect(),
    };
    let of_corners = TetMesh::from_tetrahedra(points, cells, of_corners).expect("a mesh");
    assert!(!of_corners.is_continuous());
    for (name, mesh) in [("cells", of_cells), ("corners", of_corners)] {
        let volume = Volume::Mesh(mesh.clone());
        let appearance = surfaces(&volume, appearance.clone());
        let scene = (&mesh, &appearance);
        check(MOST_AT_JUMPS, name, scene, &[3, 40], &views(&volume)[..2]);
    }
}

/// Flat cells, layers thinner than f32 resolves, and cells that are inside out, with rays along axes.
#[test]
fn hard_meshes_are_those_of_one_part() {
    for hard in &HARD_MESHES {
        // Cells that overlap are seen in the order of each path: these have no order to keep.
        if hard.name.contains("inside out") {
            continue;
        }
        let mesh = hard.mesh();
        let bounds = mesh.bounds();
        let from_low = mesh
            .points()
            .iter()
            .map(|p| (*p - bounds.min) / bounds.size().max_element());
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: from_low.map(|p| p.dot(DVec3::new(0.3, 0.5, 0.2))).collect(),
        };
        let mesh = mesh.with_scalars(scalars).expect("as many");
        let volume = Volume::Mesh(mesh.clone());
        let appearance = surfaces(&volume, ramp(&volume));
        let most = if hard.thickness < 1e-4 {
            MOST_AT_JUMPS
        } else {
            MOST
        };
        check(
            most,
            hard.name,
            (&mesh, &appearance),
            &[5],
            &views(&volume)[..2],
        );
    }
}

/// Clusters whose reads are counted and may fail.
#[derive(Debug)]
struct Watched {
    clusters: MeshClusters,
    only: fn(usize) -> bool,
    shown: Vec<Cluster>,
    read: Mutex<Vec<usize>>,
    left: AtomicU64,
}

impl Watched {
    fn new(clusters: &MeshClusters, only: fn(usize) -> bool) -> Arc<Watched> {
        let all = clusters.source().clusters().iter().enumerate();
        Arc::new(Watched {
            clusters: clusters.clone(),
            only,
            shown: all.filter(|(i, _)| only(*i)).map(|(_, c)| *c).collect(),
            read: Mutex::default(),
            left: AtomicU64::new(u64::MAX),
        })
    }

    fn reads(&self) -> Vec<usize> {
        let mut reads = std::mem::take(&mut *self.read.lock().expect("no panic"));
        reads.sort_unstable();
        reads
    }
}

impl ClusterSource for Watched {
    fn clusters(&self) -> &[Cluster] {
        &self.shown
    }

    fn field(&self) -> (&str, Association) {
        self.clusters.source().field()
    }

    fn picked(&self) -> &[f64] {
        self.clusters.source().picked()
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        if self.left.fetch_sub(1, Ordering::Relaxed) == 0 {
            return Err(Error::invalid("a disk that fails"));
        }
        self.read.lock().expect("no panic").push(cluster);
        let all = 0..self.clusters.source().clusters().len();
        let number = all.filter(|i| (self.only)(*i)).nth(cluster);
        self.clusters
            .source()
            .read(number.expect("it is one of them"))
    }
}

fn counts(frame: &Frame) -> [u64; 5] {
    let counters = [
        CLUSTERS_DRAWN,
        CLUSTERS_READ,
        CLUSTERS_HIDDEN,
        CLUSTERS_OUTSIDE,
        CLUSTERS_COVERED,
    ];
    counters.map(|counter| frame.stats.get(counter).expect("counted"))
}

/// Which clusters are read: none that the look, the camera or a plane hides, and none that is covered.
#[test]
fn what_does_not_show_is_not_read() {
    let (mesh, _) = mesh("sphere", 5 * 12 * 12 * 12);
    let clusters = cut(&mesh, 64);
    let all = clusters.source().clusters();
    let function = |knots| TransferFunction::new(knots).expect("sorted");
    // Nothing but a core shows, within 0.4 of the middle.
    let core = function(vec![
        knot(0.3, [1.0, 0.5, 0.2], 9.0),
        knot(0.4, [1.0, 0.5, 0.2], 0.0),
        knot(1.8, [1.0, 0.5, 0.2], 0.0),
    ]);
    let core = Appearance::new(core, OpticalModel::EmissionAbsorption);
    let volume = Volume::Mesh(mesh.clone());
    let view = fitted(&volume, CameraFit::PlusIso, false, 64);
    for model in OpticalModel::ALL {
        let mut appearance = Appearance {
            optical_model: model,
            ..core.clone()
        };
        if model == OpticalModel::Isosurfaces {
            appearance = surfaces(&volume, appearance);
            appearance.isosurfaces.truncate(1);
            appearance.isosurfaces[0].value = 0.35;
        }
        let source = Watched::new(&clusters, |_| true);
        let watched = MeshClusters::new(source.clone()).expect("clusters");
        let frame = draw(&watched, &appearance, &view);
        let reads = source.reads();
        let [drawn, read, hidden, outside, covered] = counts(&frame);
        assert_eq!((read, outside), (reads.len() as u64, 0), "{}", model.name());
        assert_eq!(drawn + hidden + covered, all.len() as u64);
        let shows = |cluster: &Cluster| {
            let (low, high) = cluster.scalar_range.expect("values");
            match model {
                OpticalModel::MaximumIntensity => true,
                OpticalModel::Isosurfaces => low < 0.35 && 0.35 <= high,
                _ => low < 0.4,
            }
        };
        let hidden_ones = all.iter().filter(|cluster| !shows(cluster)).count();
        assert_eq!(hidden, hidden_ones as u64, "{}", model.name());
        assert!(reads.iter().all(|i| shows(&all[*i])));
        if model != OpticalModel::MaximumIntensity {
            assert!(hidden > 30, "{hidden}");
        }
    }
    // A wall in front.
    let wall = function(vec![knot(0.0, [0.2, 0.9, 0.4], 1e4)]);
    let wall = Appearance::new(wall, OpticalModel::EmissionAbsorption);
    let inside = tetrascope_testing::view(inside(&volume), 64);
    let frame = draw(&clusters, &wall, &inside);
    let [drawn, read, hidden, outside, covered] = counts(&frame);
    assert_eq!(drawn + hidden + outside + covered, all.len() as u64);
    assert_eq!((drawn, hidden), (read, 0));
    assert!(
        covered > 5 && outside > 5,
        "{covered} covered, {outside} outside"
    );
    let whole = renderer(&volume, &wall).render(&inside).expect("a frame");
    assert_eq!(difference(&whole, &frame, MOST).1, 0);
    // Cut away, but for a corner.
    let mut cut_away = tilted(&volume);
    cut_away.truncate(1);
    cut_away[0].point = 0.8 * mesh.bounds().max;
    let cut_away = Appearance {
        clip_planes: cut_away,
        ..wall
    };
    let [_, read, _, outside, _] = counts(&draw(&clusters, &cut_away, &view));
    assert!(read > 0 && outside > 40, "{outside}");
    // Nothing shows at all.
    let clear = function(vec![knot(0.0, [1.0; 3], 0.0)]);
    let clear = Appearance::new(clear, OpticalModel::EmissionAbsorption);
    let frame = draw(&clusters, &clear, &view);
    assert_eq!(counts(&frame), [0, 0, all.len() as u64, 0, 0]);
    assert!(frame.pixels.iter().all(|pixel| *pixel == frame.pixels[0]));
}

/// Clusters that are kept are not read again, also in another look; little memory keeps less, and gives the same bits.
#[test]
fn memory_changes_what_is_read_and_no_pixel() {
    let (mesh, appearance) = mesh("torus", 60_000);
    let clusters = cut(&mesh, 64);
    let volume = Volume::Mesh(mesh);
    let view = fitted(&volume, CameraFit::PlusIso, false, 300);
    let with = |memory: u64, threads| {
        let source = Watched::new(&clusters, |_| true);
        let watched = MeshClusters::new(source).expect("clusters");
        let options = RaycastCpuOptions {
            memory,
            threads,
            ..RaycastCpuOptions::default()
        };
        RaycastCpu::new(&Volume::Clusters(watched), &appearance, &options)
    };
    let mut large = with(1 << 30, None).expect("clusters");
    let first = large.render(&view).expect("a frame");
    let [drawn, read, ..] = counts(&first);
    assert!(drawn > 40 && drawn == read, "{drawn} {read}");
    let again = large.render(&view).expect("a frame");
    assert_eq!(counts(&again)[..2], [drawn, 0]);
    assert_eq!(again.pixels, first.pixels);
    assert!(again.stats.bytes_resident > 60_000 * 100);
    // The runs of 300² pixels are 5 MB a ray crosses: an eighth of this memory is less.
    let small = with(3_000_000, Some(1)).expect("clusters");
    let frame = small.render(&view).expect("a frame");
    let [in_bands, ..] = counts(&frame);
    assert!(in_bands > drawn, "{in_bands} of {drawn}");
    assert_eq!(frame.pixels, first.pixels);
    assert!(frame.stats.bytes_resident <= 750_000);
    let again = counts(&small.render(&view).expect("a frame"));
    assert!(again[1] > 0 && again[1] < again[0], "{again:?}");
    // Less than two clusters need.
    let error = with(300_000, None).map(drop).expect_err("too little");
    assert!(
        error.to_string().contains("more than half of the 1 MB"),
        "{error}"
    );
    assert!(error.help().is_some_and(|help| help.contains("`memory`")));
    // The same range, and another: the scalars of the first suit it, those of the second do not.
    for (width, most) in [(1.0, 0), (0.1, drawn)] {
        let (low, high) = appearance.transfer_function.range();
        let function = TransferFunction::new(vec![
            knot(low, [0.9, 0.5, 0.1], 1.0),
            knot(low + width * (high - low), [0.1, 0.5, 0.9], 3.0),
        ]);
        let other = Appearance::new(function.expect("sorted"), OpticalModel::EmissionAbsorption);
        large.restyle(&other).expect("another look");
        let frame = large.render(&view).expect("a frame");
        assert!(counts(&frame)[1] <= most, "{width}");
        let whole = renderer(&volume, &other).render(&view).expect("a frame");
        // The change that moving a ray makes grows with the function's slope.
        let (near, far) = difference(&whole, &frame, MOST / width);
        assert_eq!(far, 0, "{width}: {near:e} and more");
    }
}

/// Two processes have clusters in turn, and send each other segments.
#[test]
fn segments_of_processes_are_the_whole() {
    let (mesh, appearance) = mesh("torus", 3000);
    let clusters = cut(&mesh, 24);
    let volume = Volume::Mesh(mesh.clone());
    let options = RaycastCpuOptions {
        domain: Some(Domain::of(&mesh)),
        ..RaycastCpuOptions::default()
    };
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            ..surfaces(&volume, appearance.clone())
        };
        let view = fitted(&volume, CameraFit::PlusIso, false, 64);
        let ranks: [fn(usize) -> bool; 2] = [|i| i / 3 % 2 == 0, |i| i / 3 % 2 == 1];
        let segments = ranks.map(|only| {
            let own = MeshClusters::new(Watched::new(&clusters, only)).expect("clusters");
            let own = RaycastCpu::new(&Volume::Clusters(own), &appearance, &options);
            own.expect("a part").segments(&view).expect("paths")
        });
        // The longest way through the torus is in four stretches, of which a process has a few.
        assert!(segments[0].segments.len() < 6 * 64 * 64);
        let pixels = PathSegments::composite(&segments, &view).expect("one size");
        let whole = renderer(&volume, &appearance)
            .render(&view)
            .expect("a frame");
        let together = Frame {
            pixels,
            ..whole.clone()
        };
        let most = MOST * scale(&exactly(&whole));
        let far = difference(&whole, &together, most).1;
        let outline = if model == OpticalModel::Isosurfaces {
            OUTLINE
        } else {
            0
        };
        assert!(far <= outline, "{}: {far}", model.name());
    }
}

#[test]
fn a_failing_disk_and_a_stop_end_the_frame_and_the_next_is_whole() {
    let (mesh, appearance) = mesh("torus", 3000);
    let source = Watched::new(&cut(&mesh, 24), |_| true);
    let clusters = Volume::Clusters(MeshClusters::new(source.clone()).expect("clusters"));
    let stop = Stop::new();
    let rays = renderer(&clusters, &appearance).with_stop(stop.clone());
    let view = fitted(&Volume::Mesh(mesh), CameraFit::PlusIso, false, 32);
    stop.set();
    assert!(matches!(rays.render(&view), Err(Error::Stopped)));
    stop.clear();
    source.left.store(5, Ordering::Relaxed);
    let error = rays.render(&view).expect_err("a disk that fails");
    assert!(error.to_string().contains("a disk that fails"), "{error}");
    source.left.store(u64::MAX, Ordering::Relaxed);
    let frame = rays.render(&view).expect("a frame");
    let anew = renderer(&clusters, &appearance)
        .render(&view)
        .expect("a frame");
    assert_eq!(frame.pixels, anew.pixels);
}
