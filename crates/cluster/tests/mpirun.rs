//! The program, started by `mpirun`. Each run has a time limit: a rank that waits for another forever is a failure.

#![cfg(feature = "mpi")]

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tetrascope::core::clusters::{Cut, MeshClusters};
use tetrascope::core::{Scalars, TetMesh};
use tetrascope::io::{MeshData, write_tsc};
use tetrascope_testing::data_set;

/// Seconds after which a run hangs. The longest takes two on a machine of two cores.
const LIMIT: Duration = Duration::from_secs(60);

/// A folder with files, in which programs run.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }

    /// The command that draws with so many ranks.
    fn command(&self, ranks: usize, line: &str) -> Command {
        let mut command = Command::new("mpirun");
        command
            .args(["--oversubscribe", "-n", &ranks.to_string()])
            .arg(env!("CARGO_BIN_EXE_tetrascope-mpi"))
            .args(line.split(' '))
            .current_dir(self.0.path())
            // In containers, tests run as root.
            .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
            .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
            // Ranks of one machine need no network.
            .env("OMPI_MCA_btl", "self,vader")
            .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn run(&self, ranks: usize, line: &str) -> Run {
        let child = self.command(ranks, line).spawn().expect("mpirun starts");
        Run::of(child, line)
    }
}

/// A run that has ended.
struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Run {
    /// Waits for the end, and ends what hangs.
    fn of(mut child: Child, line: &str) -> Run {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            if started.elapsed() > LIMIT {
                child.kill().expect("killed");
                panic!("`{line}` hangs");
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        let text = |stream: Option<&mut dyn std::io::Read>| {
            let mut bytes = Vec::new();
            let read = stream.expect("piped").read_to_end(&mut bytes);
            read.expect("it has ended");
            String::from_utf8_lossy(&bytes).into_owned()
        };
        Run {
            code: status.code().unwrap_or(-1),
            stdout: text(child.stdout.as_mut().map(|s| s as &mut dyn std::io::Read)),
            stderr: text(child.stderr.as_mut().map(|s| s as &mut dyn std::io::Read)),
        }
    }

    fn succeeded(self) -> Run {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }

    fn json(self) -> Value {
        serde_json::from_str(&self.succeeded().stdout).expect("JSON")
    }

    /// The lines of the program: `mpirun` adds its own.
    fn errors(&self) -> Vec<&str> {
        let lines = self.stderr.lines();
        lines.filter(|line| line.starts_with("error: ")).collect()
    }
}

/// The cells of `mesh` in so many runs along x, each with the points that it uses.
fn slabs(mesh: &TetMesh, count: usize) -> Vec<TetMesh> {
    let bounds = mesh.bounds();
    let slab = |cell: usize| {
        let center = mesh.cell_points(cell).iter().map(|p| p.x).sum::<f64>() / 4.0;
        let along = (center - bounds.min.x) / bounds.size().x;
        ((along * count as f64) as usize).min(count - 1)
    };
    let part = |number: usize| {
        let cells = (0..mesh.cell_count()).filter(|cell| slab(*cell) == number);
        let cells: Vec<[u32; 4]> = cells.map(|cell| mesh.tetrahedra()[cell]).collect();
        let mut used: Vec<u32> = cells.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let local = |point: u32| used.binary_search(&point).expect("used") as u32;
        let points = used.iter().map(|point| mesh.points()[*point as usize]);
        let values = used
            .iter()
            .map(|point| mesh.scalars().values[*point as usize]);
        let scalars = Scalars {
            values: values.collect(),
            ..mesh.scalars().clone()
        };
        let cells = cells.iter().map(|cell| cell.map(local)).collect();
        TetMesh::from_tetrahedra(points.collect(), cells, scalars).expect("a slab")
    };
    (0..count).map(part).collect()
}

/// Writes pieces of a torus, and a `.pvtu` file that lists them.
fn pieces(folder: &Folder, count: usize) -> TetMesh {
    let mesh = data_set("torus", Some(3000));
    let mut list = String::new();
    for (number, slab) in slabs(&mesh, count).iter().enumerate() {
        let name = format!("piece_{number}.vtu");
        let data = MeshData::of(slab).expect("a mesh");
        tetrascope::io::write_vtu(&folder.path(&name), &data, Default::default()).expect("written");
        list += &format!("<Piece Source=\"{name}\"/>\n");
    }
    let text = format!(
        "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\">\n<PUnstructuredGrid GhostLevel=\"0\">\n\
         {list}</PUnstructuredGrid>\n</VTKFile>\n"
    );
    folder.write("mesh.pvtu", &text);
    mesh
}

/// The numbers of an `.npy` file.
fn pixels(path: &Path) -> Vec<f32> {
    let mut bytes = Vec::new();
    let mut file = std::fs::File::open(path).expect("a picture");
    file.read_to_end(&mut bytes).expect("read");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (numbers, _) = bytes[header..].as_chunks::<4>();
    numbers
        .iter()
        .map(|number| f32::from_le_bytes(*number))
        .collect()
}

/// The greatest difference in parts of the greatest number.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let scale = a.iter().fold(1.0, |scale: f32, x| scale.max(x.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |worst: f32, (a, b)| worst.max((a - b).abs())) / scale
}

/// A run's light rounds by 2⁻²⁴ when it is sent, and the pixel once more.
const MOST: f32 = 3.0 / (1 << 24) as f32;

#[test]
fn ranks_draw_the_picture_of_one_rank_from_pieces_and_from_clusters() {
    let folder = Folder::new();
    let mesh = pieces(&folder, 5);
    let limits = Cut {
        most_cells: 150,
        ..Cut::default()
    };
    write_tsc(&folder.path("mesh.tsc"), &mesh, &limits).expect("written");
    for file in ["mesh.pvtu", "mesh.tsc"] {
        let mut first: Option<Vec<f32>> = None;
        for (ranks, more) in [(1, ""), (2, ""), (3, ""), (4, " --radix 2")] {
            let line = format!("render {file} --size 64 --json -o {ranks}.npy{more}");
            let report = folder.run(ranks, &line).json();
            assert_eq!(report["volume"]["cells"], mesh.cell_count());
            assert_eq!(report["ranks"].as_array().map(Vec::len), Some(ranks));
            assert_eq!(report["statistics"]["lost_rays"], 0);
            let found = pixels(&folder.path(&format!("{ranks}.npy")));
            let first = first.get_or_insert_with(|| found.clone());
            assert!(difference(first, &found) <= MOST, "{file}, {ranks} ranks");
            assert!(found.iter().any(|x| *x > 0.0));
        }
    }
}

#[test]
fn a_bad_piece_ends_all_ranks_with_one_line_that_names_rank_and_file() {
    let folder = Folder::new();
    pieces(&folder, 3);
    let whole = std::fs::read(folder.path("piece_2.vtu")).expect("a piece");
    std::fs::write(folder.path("piece_2.vtu"), &whole[..whole.len() / 2]).expect("written");
    let run = folder.run(3, "render mesh.pvtu --size 16 -o out.npy");
    assert_eq!(run.code, 3, "{}", run.stderr);
    let errors = run.errors();
    assert_eq!(errors.len(), 1, "{}", run.stderr);
    assert!(
        errors[0].starts_with("error: rank 2 of 3: "),
        "{}",
        errors[0]
    );
    assert!(errors[0].contains("piece_2.vtu"), "{}", errors[0]);
    assert!(!folder.path("out.npy").exists());
}

#[test]
fn a_damaged_cluster_is_found_by_the_rank_that_has_it() {
    let folder = Folder::new();
    let mesh = data_set("sphere", Some(3000));
    let limits = Cut {
        most_cells: 500,
        ..Cut::default()
    };
    let path = folder.path("mesh.tsc");
    write_tsc(&path, &mesh, &limits).expect("written");
    let mut bytes = std::fs::read(&path).expect("a file");
    // Spoil the first cluster, which the first rank has.
    bytes[100] ^= 1;
    std::fs::write(&path, bytes).expect("written");
    let run = folder.run(2, "render mesh.tsc --size 16 -o out.npy");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert_eq!(run.errors().len(), 1, "{}", run.stderr);
    assert!(
        run.errors()[0].starts_with("error: rank 0 of 2: the cluster is damaged"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_is_wrong_everywhere_is_said_once_and_names_no_rank() {
    let folder = Folder::new();
    pieces(&folder, 2);
    for (line, code, words) in [
        ("render none.pvtu", 3, "none.pvtu"),
        ("render mesh.pvtu --field other", 3, "no field 'other'"),
        ("render mesh.pvtu --step 1", 3, "step"),
        ("render mesh.pvtu --colour red", 2, "--colour"),
        ("render sphere", 2, "a data set"),
    ] {
        let run = folder.run(2, line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        assert_eq!(run.errors().len(), 1, "{line}: {}", run.stderr);
        assert!(run.errors()[0].contains(words), "{line}: {}", run.stderr);
        assert!(!run.errors()[0].contains("rank "), "{line}: {}", run.stderr);
    }
}

/// The processes that are children of another, from Linux's list.
fn children(parent: u32) -> Vec<u32> {
    let processes = std::fs::read_dir("/proc").expect("Linux");
    let numbers = processes.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    let is_child = |process: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        let after = stat.rsplit_once(')').map_or("", |(_, after)| after);
        after.split_whitespace().nth(1) == Some(&parent.to_string())
    };
    numbers.filter(is_child).collect()
}

#[cfg(target_os = "linux")]
#[test]
fn a_rank_that_is_killed_ends_all() {
    let folder = Folder::new();
    pieces(&folder, 3);
    // So many pictures take hours.
    let line = "render mesh.pvtu --size 2048 --repeat 1000 -o out.npy";
    let child = folder.command(3, line).spawn().expect("mpirun starts");
    let started = Instant::now();
    let ranks = loop {
        let ranks = children(child.id());
        if ranks.len() == 3 {
            break ranks;
        }
        assert!(started.elapsed() < LIMIT, "no ranks");
        std::thread::sleep(Duration::from_millis(20));
    };
    // In the midst of it, or while MPI starts.
    std::thread::sleep(Duration::from_secs(2));
    let killed = Command::new("kill")
        .args(["-9", &ranks[1].to_string()])
        .status();
    assert!(killed.expect("kill").success());
    let run = Run::of(child, line);
    assert_ne!(run.code, 0);
    assert!(!folder.path("out.npy").exists());
    // `mpirun` does not wait for those that it ends.
    let is_there = |rank: &u32| Path::new(&format!("/proc/{rank}")).exists();
    while ranks.iter().any(is_there) {
        assert!(started.elapsed() < LIMIT, "ranks go on");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_rank_that_panics_ends_all_with_one_line() {
    let folder = Folder::new();
    pieces(&folder, 3);
    let mut command = folder.command(3, "render mesh.pvtu --size 16 -o out.npy");
    command.env("TETRASCOPE_PANIC_AT_RANK", "1");
    let run = Run::of(command.spawn().expect("mpirun starts"), "a panic");
    assert_eq!(run.code, 101, "{}", run.stderr);
    assert_eq!(run.errors().len(), 1, "{}", run.stderr);
    assert!(
        run.errors()[0].starts_with("error: rank 1 of 3: panicked"),
        "{}",
        run.stderr
    );
    assert!(!folder.path("out.npy").exists());
}

/// The picture that `tetrascope` draws of the same clusters.
#[test]
fn the_picture_is_that_of_the_renderer_within_one_process() {
    use tetrascope::core::{Volume, VolumeRenderer as _};
    use tetrascope::raycast_cpu::{RaycastCpu, RaycastCpuOptions};
    use tetrascope::scene::SceneFile;

    let folder = Folder::new();
    let mesh = data_set("torus", Some(3000));
    let limits = Cut {
        most_cells: 150,
        ..Cut::default()
    };
    let path = folder.path("mesh.tsc");
    write_tsc(&path, &mesh, &limits).expect("written");
    folder
        .run(3, "render mesh.tsc --size 64 -o three.npy")
        .succeeded();
    let clusters: MeshClusters = tetrascope::io::open_tsc(&path).expect("clusters");
    let volume = Volume::Clusters(clusters);
    let mut file = SceneFile::new(Default::default());
    (file.image.width, file.image.height) = (Some(64), Some(64));
    let scene = file.resolve(&volume).expect("a scene");
    let options = RaycastCpuOptions::default();
    let renderer = RaycastCpu::new(&volume, &scene.appearance, &options).expect("clusters");
    let frame = renderer.render(&scene.view).expect("a frame");
    let found = pixels(&folder.path("three.npy"));
    assert!(difference(frame.pixels.as_flattened(), &found) <= MOST);
}
