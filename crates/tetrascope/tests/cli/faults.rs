//! Faults outside of the program: no room on a disk, a device that is full, a signal. Each
//! is told in words, no file appears by halves, and nothing else is left.

use std::fs::{self, OpenOptions};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::program::{Folder, program};
use super::series::mesh;

/// A file system of 64 kB over a folder, gone with the value.
struct Small<'a>(&'a Path);

impl<'a> Small<'a> {
    /// `None` where this user may not mount, which is said.
    fn over(folder: &'a Path, test: &str) -> Option<Small<'a>> {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]);
        let said = match mount.arg(folder).output() {
            Ok(output) if output.status.success() => return Some(Small(folder)),
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
        eprintln!("skipped: {test}: no small disk: {said}");
        None
    }

    /// Takes what room there is, but for so many bytes.
    fn fill_but(&self, bytes: usize) {
        let path = self.0.join("filler");
        let full = fs::write(&path, vec![7; (64 << 10) - bytes]);
        full.expect("there is as much");
    }
}

impl Drop for Small<'_> {
    fn drop(&mut self) {
        // Who mounts may unmount.
        let _ = Command::new("umount").arg(self.0).status();
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("readable");
    let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("readable").file_name();
    let names = entries.map(|entry| name(entry).to_string_lossy().into_owned());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// A machine without a graphics adapter takes no samples of meshes.
fn samples(folder: &Folder) -> bool {
    let probe = folder.run("adapters");
    if probe.code == 4 {
        eprintln!("skipped: resample and slice: {}", probe.stderr.trim());
    }
    cfg!(feature = "resample") && probe.code != 4
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_leaves_nothing() {
    let folder = Folder::new();
    let disk = folder.path("disk");
    fs::create_dir(&disk).expect("writable");
    let Some(small) = Small::over(&disk, "a_full_disk_is_told_and_leaves_nothing") else {
        return;
    };
    let noise = "--set tolerance=1e-3 --size 256";
    let mut lines: Vec<(String, &str)> = ["png", "exr", "npy"]
        .map(|extension| {
            let name = format!("a.{extension}");
            (
                format!("render sphere --cells 2000 {noise} -o disk/{name}"),
                extension,
            )
        })
        .into();
    lines.push((format!("render s*.vtk {noise} -o disk/f_%d.exr"), "exr"));
    if cfg!(feature = "voxel-hw") {
        lines.push((
            "voxelize sphere --cells 2000 --dims 64 -o disk/a.vti".into(),
            "vti",
        ));
    }
    if samples(&folder) {
        lines.push((
            "resample sphere --cells 2000 --dims 64 -o disk/a.vti".into(),
            "vti",
        ));
        let slice = "slice sphere --cells 2000 --plane 0,0,0,1,1,0 --size 300";
        lines.extend(["png", "npy", "vti"].map(|e| (format!("{slice} -o disk/a.{e}"), e)));
    }
    folder.write("s1.vtk", mesh(1.0, 0.0, 1.0));
    folder.write("s2.vtk", mesh(1.0, 0.0, 2.0));
    // Room for a file's name and its first pages.
    small.fill_but(8 << 10);
    for (line, extension) in &lines {
        for old in [false, true] {
            let name = format!("a.{extension}");
            let is_series = line.contains('%');
            if old && !is_series {
                fs::write(disk.join(&name), "old").expect("room for as much");
            }
            let before = names(&disk);
            let (error, _) = folder.run(line).failed(1);
            let named = if is_series { "f_0.exr" } else { &name };
            let words = format!("cannot write disk/{named}");
            assert!(error.contains(&words), "{line}: {error}");
            assert!(error.contains("No space left on device"), "{line}: {error}");
            assert!(!error.contains(".tetrascope-"), "{line}: {error}");
            assert_eq!(names(&disk), before, "{line}");
            if before.contains(&name) {
                assert_eq!(fs::read(disk.join(&name)).expect("there"), b"old", "{line}");
                fs::remove_file(disk.join(&name)).expect("there");
            }
        }
    }
    // A sidecar without its array is not left either: both are there or neither.
    assert_eq!(names(&disk), ["filler"]);
    // The next run works once there is room.
    fs::remove_file(disk.join("filler")).expect("there");
    folder
        .run("render s1.vtk --size 16 -o disk/a.npy")
        .succeeded();
    assert_eq!(names(&disk), ["a.npy", "a.npy.json"]);
}

// A disk without any room at all takes the name of a file and none of its bytes, also of small ones.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_without_any_room_takes_no_small_file() {
    let folder = Folder::new();
    let disk = folder.path("disk");
    fs::create_dir(&disk).expect("writable");
    let Some(small) = Small::over(&disk, "a_disk_without_any_room_takes_no_small_file") else {
        return;
    };
    small.fill_but(0);
    for extension in ["png", "exr", "npy"] {
        let line = format!("render sphere --cells 100 --size 4 -o disk/a.{extension}");
        let (error, _) = folder.run(&line).failed(1);
        assert!(error.contains("No space left on device"), "{error}");
        assert_eq!(names(&disk), ["filler"], "{extension}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_to_a_full_device_is_told() {
    let folder = Folder::new();
    folder.write("s1.vtk", mesh(1.0, 0.0, 1.0));
    for line in [
        "--help",
        "--version",
        "render --help",
        "algorithms",
        "algorithms --json",
        "datasets",
        "colormaps",
        "info s1.vtk",
        "info s1.vtk --json",
        "print-scene s1.vtk",
        "render s1.vtk --size 8 -o a.png",
        "render s1.vtk --size 8 -o a.png --json",
        "render s*.vtk --size 8 -o f_%d.png",
        "render s*.vtk --size 8 -o f_%d.png --json",
    ] {
        let full = OpenOptions::new().write(true).open("/dev/full");
        let run = program()
            .current_dir(folder.root())
            .args(line.split(' '))
            .stdout(Stdio::from(full.expect("Linux has it")))
            .output()
            .expect("the program starts");
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{line}: {stderr}");
        let words = "cannot write standard output: No space left on device";
        assert!(stderr.contains(words), "{line}: {stderr}");
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        // Nor does it matter that there is nobody to tell.
        let full = || {
            Stdio::from(
                OpenOptions::new()
                    .write(true)
                    .open("/dev/full")
                    .expect("there"),
            )
        };
        let status = program()
            .current_dir(folder.root())
            .args(line.split(' '))
            .stdout(Stdio::null())
            .stderr(full())
            .status();
        assert!(status.expect("it starts").success(), "{line}");
    }
}

/// How long a program may take to end once it is told to; it takes milliseconds, and a machine
/// that does much else may keep it waiting.
#[cfg(unix)]
const PATIENCE: Duration = Duration::from_secs(20);

#[cfg(unix)]
fn signal(run: &Child, name: &str) {
    let mut kill = Command::new("kill");
    let sent = kill.args(["-s", name, &run.id().to_string()]).status();
    assert!(sent.expect("it starts").success());
}

#[cfg(unix)]
fn started(folder: &Folder, line: &str) -> Child {
    program()
        .current_dir(folder.root())
        .args(line.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts")
}

/// The end of a program, which must come.
#[cfg(unix)]
#[track_caller]
fn ended(run: &mut Child) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = run.try_wait().expect("it is ours") {
            return status;
        }
        if start.elapsed() > PATIENCE {
            let _ = run.kill();
            panic!("it goes on after {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Waits until `seen` or until the program has ended; whether it was seen.
#[cfg(unix)]
fn seen(run: &mut Child, seen: impl Fn() -> bool) -> bool {
    while run.try_wait().expect("it is ours").is_none() {
        if seen() {
            return true;
        }
        std::thread::yield_now();
    }
    false
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_frame_at_once() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = Folder::new();
    let mut runs = vec![
        ("reference", "INT", 2),
        ("raycast-cpu", "TERM", 15),
        ("raycast-cpu", "HUP", 1),
    ];
    if cfg!(feature = "projection") && samples(&folder) {
        runs.extend([("projection", "INT", 2), ("projection", "TERM", 15)]);
    }
    for (algorithm, name, number) in runs {
        // Many seconds of work.
        let line =
            format!("render sphere --cells 20000 --algorithm {algorithm} --size 4096 -o a.png");
        let mut run = program()
            .current_dir(folder.root())
            .args(line.split(' '))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        // Until it says that it draws.
        let mut said = std::io::BufReader::new(run.stderr.take().expect("piped"));
        let mut text = String::new();
        while !text.contains("drawing 4096x4096") {
            let more = std::io::BufRead::read_line(&mut said, &mut text);
            assert!(more.expect("UTF-8") > 0, "{text}");
        }
        std::thread::sleep(Duration::from_millis(50));
        signal(&run, name);
        let status = ended(&mut run);
        assert_eq!(status.signal(), Some(number), "{algorithm}: {status}");
        assert!(folder.files().is_empty(), "{:?}", folder.files());
    }
}

/// A shell sees 128 and the signal's number, and nothing is left of the file that was being written.
#[cfg(unix)]
#[test]
fn a_signal_in_the_middle_of_a_file_leaves_nothing_of_it() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = Folder::new();
    let is_temporary = |name: &String| name.starts_with(".tetrascope-");
    let mut lines = vec![("render sphere --cells 100 --size 3000 -o a.npy", "a.npy")];
    if cfg!(feature = "voxel-hw") {
        lines.push(("voxelize sphere --cells 100 --dims 160 -o a.vti", "a.vti"));
    }
    for (line, file) in lines {
        for (name, number) in [("INT", 2), ("TERM", 15)] {
            folder.write(file, "old");
            let before = folder.files();
            let mut run = started(&folder, line);
            // The file of the check that one can be written is there for a moment only.
            let is_large = |name: &String| {
                fs::metadata(folder.path(name)).is_ok_and(|data| data.len() > 1 << 20)
            };
            let is_written = || {
                folder
                    .files()
                    .iter()
                    .any(|f| is_temporary(f) && is_large(f))
            };
            assert!(seen(&mut run, is_written), "{line}: its end came first");
            signal(&run, name);
            let status = ended(&mut run);
            if status.success() {
                // Its end came first, and the file is whole.
                assert_ne!(folder.read(file), b"old");
                continue;
            }
            assert_eq!(status.signal(), Some(number), "{line}");
            assert_eq!(folder.files(), before, "{line}");
            assert_eq!(folder.read(file), b"old", "{line}");
        }
    }
}

#[cfg(unix)]
#[test]
fn a_shell_sees_128_and_the_signal() {
    use std::io::{BufRead as _, BufReader, Read as _};
    let folder = Folder::new();
    for (name, code) in [("INT", "130"), ("TERM", "143")] {
        // A shell that says which process becomes the program, in one that says how that ends.
        let script = "sh -c 'echo $$; exec \"$@\"' sh \"$@\"; echo $?";
        let mut shell = Command::new("sh")
            .args(["-c", script, "sh", env!("CARGO_BIN_EXE_tetrascope")])
            .args([
                "render",
                "sphere",
                "--cells",
                "20000",
                "--algorithm",
                "reference",
            ])
            .args(["--size", "4096", "-o", "a.png"])
            .current_dir(folder.root())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("there is a shell");
        let mut said = BufReader::new(shell.stdout.take().expect("piped"));
        let mut process = String::new();
        said.read_line(&mut process).expect("a number");
        // Signals are handled before anything is said.
        let mut told = BufReader::new(shell.stderr.take().expect("piped"));
        told.read_line(&mut String::new()).expect("what it does");
        let kill = Command::new("kill")
            .args(["-s", name, process.trim()])
            .status();
        assert!(kill.expect("it starts").success());
        let mut rest = String::new();
        said.read_to_string(&mut rest).expect("a code");
        assert_eq!(rest.trim(), code, "{name}");
        shell.wait().expect("it ends");
    }
}

// `nohup` ignores SIGHUP, and a shell without job control SIGINT for what runs behind it.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_is_ignored_stays_so() {
    let folder = Folder::new();
    for name in ["HUP", "INT"] {
        let script = format!("trap '' {name}; exec \"$@\"");
        let mut run = Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_tetrascope")])
            .args([
                "render", "sphere", "--cells", "100", "--size", "3000", "-o", "a.npy",
            ])
            .current_dir(folder.root())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("there is a shell");
        let is_there = || !folder.files().is_empty();
        assert!(seen(&mut run, is_there), "its end came first");
        signal(&run, name);
        assert!(ended(&mut run).success(), "{name}");
        for file in folder.files() {
            fs::remove_file(folder.path(&file)).expect("there");
        }
    }
}
