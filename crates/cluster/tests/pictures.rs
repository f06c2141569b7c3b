//! Pictures of many ranks, which are threads here, against those of one.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use tetrascope_cluster::{
    Communicator as _, Exchange, Failure, Picture, RankRenderer, Share, threads,
};
use tetrascope_core::clusters::{Cluster, ClusterSource, MeshClusters};
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, CameraFit, DepthCue, Error, Frame, OpticalModel, Scalars, TetMesh, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::{CLUSTERS_DRAWN, LOST_RAYS, UNPAIRED_FACES};
use tetrascope_raycast_cpu::{Domain, RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{
    Random, data_set, exactly, fitted, inside, look_of, scale, surfaces, tilted, view,
};

/// The light of a run rounds by 2⁻²⁴ whenever it is sent, at most three times among eight ranks, and the pixel once
/// more; behind a transmittance of 2⁻²⁶ light is left out, which may be found a run earlier or later. All else is in f64.
const MOST: f64 = 5.0 / (1 << 24) as f64;

/// Where parts end elsewhere, rays pass from part to part at other faces: the bound of `raycast-cpu`'s clusters, which says why.
const MOST_OF_OTHER_PARTS: f64 = 2e-6;

/// Pixels of 64² whose ray is within a rounding of a surface's outline, and meets it or not.
const OUTLINE: usize = 2;

/// How clusters go to ranks.
#[derive(Clone, Copy, Debug)]
enum Partition {
    /// Along the curve, by bytes.
    Hilbert,
    /// By the place along x.
    Slabs,
    Random,
}

impl Partition {
    fn share(self, whole: &MeshClusters, rank: usize, ranks: usize) -> Share {
        let bounds = whole.bounds();
        let mut random = Random(3);
        let owner = |cluster: &Cluster| match self {
            Partition::Hilbert => unreachable!("by bytes"),
            Partition::Slabs => {
                let along = (cluster.bounds.center() - bounds.min).x / bounds.size().x;
                ((along * ranks as f64) as usize).min(ranks - 1)
            }
            Partition::Random => random.bits() as usize % ranks,
        };
        if let Partition::Hilbert = self {
            return Share::by_bytes(whole, rank, ranks).expect("clusters");
        }
        let owners: Vec<usize> = whole.source().clusters().iter().map(owner).collect();
        let own = (0..owners.len()).filter(|&cluster| owners[cluster] == rank);
        Share::of(whole, own).expect("clusters")
    }
}

/// Draws with so many ranks, and gives what each says.
fn draw(
    exchange: &Exchange,
    share: impl Fn(usize) -> Share + Sync,
    appearance: &Appearance,
    view: &View,
    options: &RaycastCpuOptions,
) -> Vec<Result<Picture, Failure>> {
    let size = exchange.factors().iter().product();
    threads::run(size, |ranks| {
        let share = share(ranks.rank());
        let exchange = exchange.clone();
        let renderer = RankRenderer::new(&ranks, &share, appearance, options, exchange)?;
        renderer.render(&ranks, view)
    })
}

/// The picture, which rank 0 alone has.
fn picture(pictures: Vec<Result<Picture, Failure>>) -> Picture {
    let mut pictures: Vec<Picture> = pictures
        .into_iter()
        .map(|picture| picture.expect("drawn"))
        .collect();
    assert!(pictures[1..].iter().all(|picture| picture.frame.is_none()));
    let picture = pictures.swap_remove(0);
    let stats = &picture.frame.as_ref().expect("rank 0 has it").stats;
    assert_eq!(stats.get(LOST_RAYS), Some(0));
    assert_eq!(stats.get(UNPAIRED_FACES), Some(0));
    picture
}

fn frame(pictures: Vec<Result<Picture, Failure>>) -> Frame {
    picture(pictures).frame.expect("rank 0 has it")
}

/// How many pixels or distances differ by more than `most`, and the greatest difference of the others.
fn difference(a: &Frame, b: &Frame, most: f64) -> (usize, f64) {
    let mut far = 0;
    let mut worst = 0.0_f64;
    let of_pixel = |(a, b): (&[f32; 4], &[f32; 4])| {
        let channels = a.iter().zip(b);
        channels.fold(0.0, |w: f64, (a, b)| w.max(f64::from((a - b).abs())))
    };
    for off in a.pixels.iter().zip(&b.pixels).map(of_pixel) {
        match off <= most {
            true => worst = worst.max(off),
            false => far += 1,
        }
    }
    assert_eq!(a.depths.is_some(), b.depths.is_some());
    if let (Some(a), Some(b)) = (&a.depths, &b.depths) {
        // In parts of a distance of some volumes' sizes.
        let same = |(a, b): &(&f32, &f32)| a == b || (*a - *b).abs() <= 4e-6 * a.abs();
        far = far.max(a.iter().zip(b).filter(|pair| !same(pair)).count());
    }
    (far, worst)
}

/// A mesh in a look with something in it for every optical model.
fn scene(name: &str, cells: u64) -> (TetMesh, Appearance) {
    let mesh = data_set(name, Some(cells));
    let volume = Volume::Mesh(mesh.clone());
    let appearance = surfaces(&volume, look_of(name));
    (mesh, appearance)
}

fn in_model(model: OpticalModel, appearance: &Appearance) -> Appearance {
    Appearance {
        optical_model: model,
        ..appearance.clone()
    }
}

/// In rounds as well as at once where clusters are farthest from compact.
fn exchanges(ranks: usize, partition: Partition) -> Vec<Exchange> {
    let direct = Exchange::direct(ranks);
    let radix = Exchange::radix(ranks, 2).expect("2 or more");
    match partition {
        Partition::Random if radix != direct => vec![direct, radix],
        _ => vec![direct],
    }
}

#[test]
fn any_number_of_ranks_gives_the_picture_of_one() {
    // A ray goes through the torus twice, and through its clusters in any order.
    let (mesh, appearance) = scene("torus", 3000);
    let volume = Volume::Mesh(mesh.clone());
    let clusters = MeshClusters::of(&mesh, 60).expect("cut");
    let mut view = fitted(&volume, CameraFit::PlusIso, false, 48);
    view.background = [0.3, 0.2, 0.1, 0.5];
    let options = RaycastCpuOptions::default();
    for model in OpticalModel::ALL {
        let appearance = in_model(model, &appearance);
        let one = RaycastCpu::new(&Volume::Clusters(clusters.clone()), &appearance, &options);
        let one = one.expect("clusters").render(&view).expect("a frame");
        let most = MOST * scale(&exactly(&one));
        for ranks in 1..=8 {
            for partition in [Partition::Hilbert, Partition::Slabs, Partition::Random] {
                for exchange in exchanges(ranks, partition) {
                    let share = |rank| partition.share(&clusters, rank, ranks);
                    let found = frame(draw(&exchange, share, &appearance, &view, &options));
                    let (far, worst) = difference(&one, &found, most);
                    let what = format!(
                        "{}, {ranks} ranks, {partition:?}, {exchange:?}",
                        model.name()
                    );
                    assert_eq!(far, 0, "{what}: beyond {most:e}, others {worst:e}");
                    let drawn = |frame: &Frame| frame.stats.get(CLUSTERS_DRAWN);
                    if model != OpticalModel::EmissionAbsorption
                        && model != OpticalModel::Isosurfaces
                    {
                        assert_eq!(drawn(&found), drawn(&one), "{what}");
                    }
                }
            }
        }
    }
}

/// The cells of `mesh` that `keep` takes, with the points that they use.
fn part(mesh: &TetMesh, keep: impl Fn(usize) -> bool) -> TetMesh {
    let kept: Vec<usize> = (0..mesh.cell_count()).filter(|cell| keep(*cell)).collect();
    let cells = kept.iter().map(|cell| mesh.tetrahedra()[*cell]);
    let used: BTreeSet<u32> = cells.clone().flatten().collect();
    let numbers: HashMap<u32, u32> = used.iter().copied().zip(0..).collect();
    let value = |point: &u32| mesh.scalars().values[*point as usize];
    let scalars = Scalars {
        values: used.iter().map(value).collect(),
        ..mesh.scalars().clone()
    };
    let points = used.iter().map(|point| mesh.points()[*point as usize]);
    let cells = cells.map(|cell| cell.map(|point| numbers[&point]));
    TetMesh::from_tetrahedra(points.collect(), cells.collect(), scalars).expect("a part")
}

/// Each cell at a rank by chance, so that rays go in and out of each rank's part at every cell; clips and cues are those
/// of the whole, and so is what the eye sees from inside.
#[test]
fn cells_by_chance_give_the_picture_of_the_whole_mesh() {
    let (mesh, appearance) = scene("torus", 1500);
    let volume = Volume::Mesh(mesh.clone());
    let cut = Appearance {
        clip_planes: tilted(&volume),
        depth_cue: Some(DepthCue { strength: 0.7 }),
        ..appearance.clone()
    };
    let options = RaycastCpuOptions::default();
    let views = [
        fitted(&volume, CameraFit::PlusIso, false, 64),
        fitted(&volume, CameraFit::PlusX, true, 48),
        view(inside(&volume), 48),
    ];
    let mut random = Random(11);
    let chance: Vec<u32> = (0..mesh.cell_count()).map(|_| random.bits()).collect();
    for ranks in [2, 3, 7] {
        let shares: Vec<Share> = (0..ranks)
            .map(|rank| {
                let own = part(&mesh, |cell| chance[cell] as usize % ranks == rank);
                Share {
                    own: MeshClusters::of(&own, 100).expect("cut"),
                    domain: Domain::of(&mesh),
                }
            })
            .collect();
        for model in OpticalModel::ALL {
            let appearance = in_model(model, if ranks == 3 { &cut } else { &appearance });
            let whole = RaycastCpu::new(&volume, &appearance, &options).expect("a mesh");
            for view in &views {
                let whole = whole.render(view).expect("a frame");
                let most = MOST_OF_OTHER_PARTS * scale(&exactly(&whole));
                let exchange = Exchange::radix(ranks, 2).expect("2 or more");
                let share = |rank: usize| shares[rank].clone();
                let found = frame(draw(&exchange, share, &appearance, view, &options));
                let (far, _) = difference(&whole, &found, most);
                let outline = match model {
                    OpticalModel::Isosurfaces => OUTLINE,
                    _ => 0,
                };
                assert!(far <= outline, "{}, {ranks} ranks: {far}", model.name());
            }
        }
    }
}

#[test]
fn ranks_without_a_part_draw_nothing_and_send_nothing() {
    let (mesh, appearance) = scene("sphere", 625);
    let volume = Volume::Mesh(mesh.clone());
    let clusters = MeshClusters::of(&mesh, 250).expect("cut");
    assert_eq!(clusters.source().clusters().len(), 3);
    let view = fitted(&volume, CameraFit::PlusIso, false, 64);
    let options = RaycastCpuOptions::default();
    let one = frame(draw(
        &Exchange::direct(1),
        |_| Share::by_bytes(&clusters, 0, 1).expect("clusters"),
        &appearance,
        &view,
        &options,
    ));
    let share = |rank| Share::by_bytes(&clusters, rank, 8).expect("clusters");
    let empty: Vec<usize> = (0..8)
        .filter(|&rank| share(rank).own.cell_count() == 0)
        .collect();
    assert_eq!(empty.len(), 5);
    let pictures = draw(&Exchange::direct(8), share, &appearance, &view, &options);
    let found = picture(pictures);
    for (rank, times) in found.times.iter().enumerate() {
        assert_eq!(times.messages, 7);
        assert_eq!(times.bytes == 0, empty.contains(&rank), "rank {rank}");
    }
    let most = MOST * scale(&exactly(&one));
    assert_eq!(difference(&one, &found.frame.expect("rank 0"), most).0, 0);
}

/// Where runs take more memory than there is, a picture is drawn in bands of rows, as many at all ranks.
#[test]
fn little_memory_gives_the_same_picture_in_bands() {
    let (mesh, appearance) = scene("torus", 1500);
    let volume = Volume::Mesh(mesh.clone());
    let clusters = MeshClusters::of(&mesh, 20).expect("cut");
    let view = fitted(&volume, CameraFit::PlusIso, false, 96);
    let share = |rank| Share::by_bytes(&clusters, rank, 3).expect("clusters");
    let mut pixels = Vec::new();
    for (memory, bands) in [(2_000_000_000, 1..=1), (100_000, 2..=6)] {
        let options = RaycastCpuOptions {
            memory,
            ..RaycastCpuOptions::default()
        };
        let found = picture(draw(
            &Exchange::direct(3),
            share,
            &appearance,
            &view,
            &options,
        ));
        assert!(
            bands.contains(&found.times[0].bands),
            "{}",
            found.times[0].bands
        );
        assert!(
            found
                .times
                .iter()
                .all(|times| times.bands == found.times[0].bands)
        );
        pixels.push(found.frame.expect("rank 0").pixels);
    }
    assert!(pixels[0] == pixels[1]);
}

/// Clusters of which one cannot be read.
#[derive(Debug)]
struct Broken {
    source: Arc<dyn ClusterSource>,
    bad: usize,
    panics: bool,
}

impl ClusterSource for Broken {
    fn clusters(&self) -> &[Cluster] {
        self.source.clusters()
    }

    fn field(&self) -> (&str, Association) {
        self.source.field()
    }

    fn picked(&self) -> &[f64] {
        self.source.picked()
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        match (cluster == self.bad, self.panics) {
            (false, _) => self.source.read(cluster),
            (true, true) => panic!("it was to panic"),
            (true, false) => Err(Error::Format {
                path: "mesh.tsc".into(),
                at: "byte 56".into(),
                what: "the cluster is damaged".into(),
                help: Some("copy the file again".into()),
            }),
        }
    }
}

/// The pictures of four ranks, the last of which cannot read a cluster.
fn draw_broken(panics: bool) -> Vec<Result<Picture, Failure>> {
    let (mesh, appearance) = scene("sphere", 625);
    let clusters = MeshClusters::of(&mesh, 100).expect("cut");
    let view = fitted(&Volume::Mesh(mesh), CameraFit::PlusIso, false, 64);
    let source = Arc::new(Broken {
        source: clusters.source().clone(),
        bad: clusters.source().clusters().len() - 1,
        panics,
    });
    let broken = MeshClusters::new(source).expect("clusters");
    let share = |rank| Share::by_bytes(&broken, rank, 4).expect("clusters");
    let options = RaycastCpuOptions::default();
    draw(&Exchange::direct(4), share, &appearance, &view, &options)
}

#[test]
fn a_rank_that_fails_ends_all_and_is_named() {
    for picture in draw_broken(false) {
        let failure = picture.expect_err("a cluster is damaged");
        assert_eq!(
            failure.to_string(),
            "rank 3 of 4: the cluster is damaged, in mesh.tsc at byte 56"
        );
        assert_eq!(failure.help.as_deref(), Some("copy the file again"));
    }
}

#[test]
#[should_panic(expected = "a rank panicked")]
fn a_rank_that_panics_while_it_draws_does_not_hang_the_others() {
    draw_broken(true);
}
