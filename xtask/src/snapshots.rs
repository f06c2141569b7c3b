//! Small reviewed pictures and texts, which catch drift; they do not define what is right.
//!
//! Texts (what the command line prints, errors, counters, the layout of `report.json`) are
//! snapshots of `insta`. Pictures are compared here, and not by an `insta::Comparator` over its
//! binary snapshots, because
//! - only an adapter that everybody can run may leave a picture to be blessed, and others are
//!   held to another tolerance: `insta` leaves a new snapshot wherever one differs;
//! - a test of many pictures fails at its end, with all of them, and leaves expected |
//!   difference | actual of each;
//! - it would keep two files for each picture, the PNG file and one that describes it.
//!
//! [`pictures`] lists what is drawn; [`compare`] holds it to `snapshots/*.png`; [`texts`] knows
//! the files of `insta`; [`report`] shows both as one page; [`dead`] finds what nobody asks for.

pub mod compare;
pub mod dead;
pub mod pictures;
pub mod report;
pub mod texts;

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicUsize;

use tetrascope::core::Error;

use crate::cargo::{cargo, finish};
use crate::machine::{root, target};
use crate::output::{print, write};
use crate::setup;
use compare::Store;

/// Options of `cargo xtask snapshots`.
#[derive(clap::Args)]
pub struct Options {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Draw every picture and print every text again; exit code 5 where one is not as reviewed
    Check,
    /// Write target/snapshots/index.html: what the last check found, and a sheet of all pictures
    Report,
    /// Accept what the last check has left
    Bless,
    /// List reviewed pictures and texts that no test asks for; exit code 5 where there are any
    Dead {
        /// Delete them
        #[arg(long)]
        remove: bool,
    },
}

/// The tests that ask for snapshots.
const TESTS: [&str; 3] = ["snapshots", "texts", "cli"];

/// Does what was asked for; whether all is as reviewed.
///
/// # Errors
/// Files that cannot be read or written, tests that cannot be run.
pub fn run(options: &Options) -> Result<bool, Error> {
    let store = Store::here();
    match options.action {
        Action::Check => {
            let passed = test(&mut tests())?;
            if !passed {
                eprintln!("`cargo xtask snapshots report` shows what differs");
            }
            Ok(passed)
        }
        Action::Report => {
            let page = target().join("snapshots").join("index.html");
            let differing = report::write_page(&store, &texts::all(root())?, &page)?;
            eprintln!("wrote {}", page.display());
            eprintln!("{differing} not as reviewed");
            Ok(differing == 0)
        }
        Action::Bless => {
            bless()?;
            Ok(true)
        }
        Action::Dead { remove } => dead(&store, remove),
    }
}

/// Accepts the pictures and texts that the last check has left, and says which.
///
/// # Errors
/// Files that cannot be read or written.
pub fn bless() -> Result<(), Error> {
    let mut blessed = Store::here().bless()?;
    let pictures = blessed.len();
    for text in texts::all(root())? {
        if text.accept()? {
            blessed.push(text.name());
        }
    }
    for name in &blessed {
        print(&format!("{name}\n"))?;
    }
    let texts = blessed.len() - pictures;
    eprintln!("{pictures} pictures and {texts} texts accepted");
    Ok(())
}

fn tests() -> Command {
    let mut tests = cargo(root(), "test");
    tests
        .arg("--workspace")
        .args(TESTS.iter().flat_map(|name| ["--test", name]))
        // All that differ, not the first test's.
        .arg("--no-fail-fast")
        // New texts are left beside the reviewed ones, also in CI.
        .env("INSTA_UPDATE", "new");
    tests
}

fn test(tests: &mut Command) -> Result<bool, Error> {
    Ok(finish(tests, &AtomicUsize::new(0))?.success())
}

fn dead(store: &Store, remove: bool) -> Result<bool, Error> {
    // Without an adapter, tests that need one ask for nothing.
    setup::setup()?;
    let asked = asked_texts()?;
    let mut dead = dead::pictures(store, &pictures::names()?)?;
    dead.extend(dead::texts(&texts::all(root())?, &asked));
    for path in &dead {
        let path = path.strip_prefix(root()).unwrap_or(path);
        print(&format!("{}\n", path.display()))?;
    }
    if remove {
        dead::remove(&dead)?;
    }
    eprintln!(
        "{} that no test asks for{}",
        dead.len(),
        if remove { ", deleted" } else { "" }
    );
    Ok(remove || dead.is_empty())
}

/// The texts that tests ask for: `insta` writes down which, so they run.
fn asked_texts() -> Result<Vec<PathBuf>, Error> {
    let list = target().join("snapshots").join("asked");
    write(&list, "")?;
    // Of what is asked for, pictures are known without drawing them.
    let mut tests = tests();
    tests.env("INSTA_SNAPSHOT_REFERENCES_FILE", &list);
    tests.args(["--", "--skip", "pictures_are_as_reviewed"]);
    // What is printed is the list of what is dead, and nothing else.
    tests.stdout(Stdio::null());
    if !test(&mut tests)? {
        return Err(Error::Invalid {
            what: "a test has failed, so it is not known which texts it asks for".into(),
            help: Some("make `cargo xtask snapshots check` pass first".into()),
        });
    }
    texts::listed(&list)
}
