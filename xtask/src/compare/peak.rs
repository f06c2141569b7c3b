//! The most memory that a process takes which loads a scene and draws one frame of it: each algorithm
//! and setting in a process of its own, as what one has used stays with a process.

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

use tetrascope::core::{Error, VolumeRenderer as _};
use tetrascope::scene::SceneFile;
use tetrascope::{Context, Settings};

/// The hidden command that draws for [`of`].
pub const COMMAND: &str = "peak";

/// Bytes; `None` where the system does not say, or where nothing was drawn.
pub(super) fn of(scene: &str, algorithm: &str, setting: &str) -> Option<u64> {
    let mut child = Command::new(std::env::current_exe().ok()?)
        .args([COMMAND, algorithm, setting])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let written = child.stdin.take()?.write_all(scene.as_bytes());
    let output = child.wait_with_output().ok()?;
    written.ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

/// Draws the scene on standard input once and gives the most memory that this process has had.
///
/// # Errors
/// Those of loading and drawing; [`Error::Invalid`] where the system does not say.
pub fn run(algorithm: &str, setting: &str) -> Result<u64, Error> {
    let mut text = String::new();
    let read = std::io::stdin().read_to_string(&mut text);
    read.map_err(|source| Error::Io {
        action: "cannot read",
        path: "standard input".into(),
        source,
    })?;
    let file = SceneFile::parse(&text, Path::new("scene.toml"))?;
    let volume = tetrascope::volumes::load(&file.volume)?.volume;
    let scene = file.resolve(&volume)?;
    let algorithm = tetrascope::algorithm(algorithm)?;
    let settings = Settings::parse(algorithm, setting.split(','))?;
    let renderer = (algorithm.build)(&Context::new(), &volume, &scene.appearance, &settings)?;
    renderer.render(&scene.view)?;
    high_water_mark().ok_or_else(|| Error::invalid("the most memory is known on Linux alone"))
}

/// The most memory of this process, bytes.
fn high_water_mark() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_that_was_taken_counts_after_it_is_gone() {
        let before = high_water_mark().expect("on Linux");
        let size = before as usize + (64 << 20);
        // Written to, as pages that are not do not exist.
        drop(std::hint::black_box(vec![1u8; size]));
        assert!(high_water_mark().expect("on Linux") >= size as u64);
    }
}
