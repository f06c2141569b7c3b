//! Rays by the hundred million, aimed at what breaks walks from cell to cell: on the CPU and in the shader.
//! None may be lost.
//!
//! The packages' own tests cast them, as those see the walk from inside; this runs them in a release build
//! for as long as it takes. What was cast is kept in `target/rays`: interrupted and called again, it goes
//! on where it was. After a change of the code, begin with `--fresh`.
//!
//! Recorded on 2026-11-30: 1 006 632 960 rays on the CPU and, on llvmpipe of Mesa 22.3.6, 104 857 600 in the shader, none
//! lost and none unpaired. The first attempt found two on the CPU after 21 million: a face whose corners a ray
//! saw at one point counted as crossed.

use std::path::Path;
use std::sync::atomic::AtomicUsize;

use tetrascope::core::Error;

use crate::cargo::{cargo, ended_by_signals, finish};
use crate::machine::{root, target};
use crate::output::print;
use crate::setup;

/// How many.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Rays on the CPU, raycast-cpu's walk
    #[arg(long, value_name = "N", default_value_t = 1e9, value_parser = count)]
    pub cpu: f64,
    /// Rays on the device, raycast-peel's walk
    #[arg(long, value_name = "N", default_value_t = 1e8, value_parser = count)]
    pub device: f64,
    /// Forget what was cast before
    #[arg(long)]
    pub fresh: bool,
}

/// A number of rays, such as 1e9.
fn count(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|n: &f64| (0.0..=1e15).contains(n));
    number.ok_or_else(|| "give a number of rays up to 1e15, such as 1e9".into())
}

/// Casts them; whether none was lost.
///
/// # Errors
/// A program that does not build or run, a folder that cannot be written, an interruption.
pub fn run(options: &Options) -> Result<bool, Error> {
    ended_by_signals(|interrupted| run_until(interrupted, options))
}

fn run_until(interrupted: &AtomicUsize, options: &Options) -> Result<bool, Error> {
    let folder = target().join("rays");
    let failed = |source| Error::Io {
        action: "cannot write",
        path: folder.clone(),
        source,
    };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let mut is_well = true;
    let walks = [
        ("raycast-cpu", options.cpu),
        ("raycast-peel", options.device),
    ];
    for (walk, wanted) in walks {
        let tally = folder.join(format!("{walk}.txt"));
        if options.fresh && tally.exists() {
            std::fs::remove_file(&tally).map_err(failed)?;
        }
        if wanted == 0.0 {
            continue;
        }
        if walk == "raycast-peel" {
            eprintln!("{walk} on {}", setup::setup()?);
        }
        let mut command = cargo(root(), "test");
        command
            .args(["--release", "--package", &format!("tetrascope-{walk}")])
            .args(["--lib", "--", "--ignored", "no_ray_of_many_is_lost"])
            .env("TETRASCOPE_RAYS", wanted.to_string())
            .env("TETRASCOPE_RAYS_TALLY", &tally)
            // A test that is skipped has cast nothing.
            .env("CI", "1");
        let status = finish(&mut command, interrupted)?;
        is_well &= status.success();
        print(&format!("{walk}: {}\n", said(&tally, status.success())))?;
    }
    Ok(is_well)
}

/// The rays that were cast, in a line.
fn said(tally: &Path, is_well: bool) -> String {
    let kept = std::fs::read_to_string(tally).unwrap_or_default();
    let rays = kept.split(' ').next().unwrap_or_default();
    match (is_well, rays) {
        (true, rays) => format!("{rays} rays, none lost"),
        (false, "") => "a ray was lost, or the test did not run: see above".into(),
        (false, rays) => {
            format!("after {rays} rays one was lost, or the test did not run: see above")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_rays_are_read_and_others_refused() {
        assert_eq!(count("1e9"), Ok(1e9));
        assert_eq!(count("12345"), Ok(12345.0));
        for wrong in ["", "many", "-1", "NaN", "inf", "1e16"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_was_cast_is_said_whether_all_is_well_or_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let tally = folder.path().join("walk.txt");
        assert!(said(&tally, false).contains("did not run"));
        std::fs::write(&tally, "123 rays, next seed 7\n").expect("written");
        assert_eq!(said(&tally, true), "123 rays, none lost");
        assert!(said(&tally, false).starts_with("after 123 rays"));
    }
}
