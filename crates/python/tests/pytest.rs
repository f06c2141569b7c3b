//! Runs the Python tests and the examples, with the native module as this build has made it.
//!
//! It needs a Python with NumPy and pytest: `TETRASCOPE_PYTHON`, which `cargo xtask test` sets, or
//! one that is found. Without, it says that it is skipped; with CI set, that is a failure.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Where Python is, unless it is told.
const PLACES: [&str; 3] = ["python3", "/usr/bin/python3", "python"];

/// Modules that the tests need.
const NEEDED: &str = "import sys, numpy, pytest; assert sys.version_info >= (3, 10)";

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A Python that can run the tests; says "skipped" without one.
fn python(test: &str) -> Option<OsString> {
    let told = std::env::var_os("TETRASCOPE_PYTHON").filter(|path| !path.is_empty());
    let places = match told {
        Some(told) => vec![told],
        None => PLACES.map(OsString::from).to_vec(),
    };
    let runs = |python: &OsString| {
        let tried = Command::new(python).args(["-c", NEEDED]).output();
        tried.is_ok_and(|output| output.status.success())
    };
    let found = places.into_iter().find(runs);
    let is_ci = std::env::var_os("CI").is_some();
    assert!(
        found.is_some() || !is_ci,
        "CI is set, but there is no Python from 3.10 on with NumPy and pytest"
    );
    if found.is_none() {
        eprintln!("skipped: {test}: no Python from 3.10 on with NumPy and pytest");
    }
    found
}

/// The library that cargo has built for this test, as the package holds it.
fn module() -> PathBuf {
    let program = std::env::current_exe().expect("a test is a file");
    let folder = program.parent().expect("a file is in a folder");
    let name = format!("{DLL_PREFIX}_tetrascope{DLL_SUFFIX}");
    let built = folder.join(name);
    assert!(built.is_file(), "cargo has not built {}", built.display());
    built
}

/// A folder in which `import tetrascope` finds the package.
fn package(root: &Path) {
    let package = root.join("tetrascope");
    fs::create_dir(&package).expect("a new folder");
    let sources = fs::read_dir(here().join("python/tetrascope")).expect("the sources");
    for source in sources {
        let source = source.expect("an entry of a folder");
        if source.file_type().expect("a kind").is_file() {
            fs::copy(source.path(), package.join(source.file_name())).expect("copied");
        }
    }
    let extension = if cfg!(windows) { "pyd" } else { "abi3.so" };
    let there = package.join(format!("_tetrascope.{extension}"));
    fs::copy(module(), there).expect("copied");
}

/// A Python in which the package is found, in a folder of its own.
fn command(python: &OsString, root: &Path) -> Command {
    let mut command = Command::new(python);
    command
        .env("PYTHONPATH", root)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("XDG_CACHE_HOME", root.join("cache"))
        .env("MPLBACKEND", "agg")
        .env("TETRASCOPE_REPOSITORY", here().join("../.."))
        .current_dir(root);
    command
}

fn passed(what: &str, output: &Output) {
    let [out, error] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{what} failed:\n{out}\n{error}");
    println!("{what}:\n{out}\n{error}");
}

#[test]
fn the_python_tests_pass() {
    let Some(python) = python("the_python_tests_pass") else {
        return;
    };
    let root = tempfile::tempdir().expect("a temporary folder");
    package(root.path());
    let output = command(&python, root.path())
        .args(["-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider"])
        .arg(here().join("tests"))
        .output()
        .expect("Python starts");
    passed("pytest", &output);
}

/// An example, and the packages that it cannot do without.
const EXAMPLES: [(&str, &[&str]); 3] = [
    ("error_against_time.py", &["numpy"]),
    ("time_series.py", &["numpy"]),
    ("mesh_from_pyvista.py", &["numpy", "pyvista"]),
];

#[test]
fn the_examples_run() {
    let Some(python) = python("the_examples_run") else {
        return;
    };
    let root = tempfile::tempdir().expect("a temporary folder");
    package(root.path());
    let folder = here().join("../../examples/python");
    for (example, packages) in EXAMPLES {
        let imports = format!("import {}", packages.join(", "));
        let has = command(&python, root.path())
            .args(["-c", &imports])
            .output();
        if !has.expect("Python starts").status.success() {
            eprintln!("skipped: {example}: no {}", packages.join(" or "));
            continue;
        }
        let output = command(&python, root.path())
            .arg(folder.join(example))
            .arg("--small")
            .output()
            .expect("Python starts");
        passed(example, &output);
    }
}
