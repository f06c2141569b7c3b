//! Who may depend on whom, as ARCHITECTURE.md says.

use std::process::Command;

use serde_json::Value;

/// Packages by their names without `tetrascope-`: what each may be built with, and what its
/// tests and benchmarks may use beside that. A rule for a package that does not exist yet
/// harms nobody.
const RULES: [(&str, &[&str], &[&str]); 21] = [
    ("core", &[], &[]),
    ("shaders", &[], &[]),
    ("f32", &["core"], &["shaders", "testing"]),
    ("io", &["core"], &["testing"]),
    ("datasets", &["core"], &[]),
    ("reference", &["core"], &["testing"]),
    ("scene", &["core"], &[]),
    (
        "raycast-cpu",
        &["core", "f32"],
        &["io", "reference", "testing"],
    ),
    ("gpu", &["core", "f32", "shaders"], &["testing"]),
    ("projection", DRAWING, JUDGING),
    ("slicing", DRAWING, JUDGING),
    ("raycast-peel", DRAWING, JUDGING),
    // It makes grids, and may have them drawn.
    (
        "resample",
        &["core", "f32", "gpu", "shaders", "slicing"],
        JUDGING,
    ),
    // Its voxels need `core` alone, and what draws them on a device the rest.
    (
        "voxel-hw",
        &["core", "f32", "gpu", "shaders", "slicing"],
        JUDGING,
    ),
    (
        "testing",
        &["core", "datasets", "gpu", "io", "reference"],
        &[],
    ),
    ("tetrascope", LIBRARIES, &[]),
    // Its program, which is built on demand, has the command line of the facade.
    (
        "cluster",
        &["core", "f32", "io", "raycast-cpu", "tetrascope"],
        &["testing"],
    ),
    ("xtask", &["benches", "tetrascope", "testing"], &[]),
    ("benches", &["tetrascope"], &["testing"]),
    ("fuzz", &["tetrascope"], &[]),
    ("python", &["tetrascope"], &[]),
];

/// An algorithm draws with these and knows no other algorithm.
const DRAWING: &[&str] = &["core", "f32", "gpu", "shaders"];

/// Its tests compare it with the truth.
const JUDGING: &[&str] = &["datasets", "io", "reference", "testing"];

/// The facade knows everything that reads, makes and draws volumes.
const LIBRARIES: &[&str] = &[
    "core",
    "datasets",
    "f32",
    "gpu",
    "io",
    "projection",
    "raycast-cpu",
    "raycast-peel",
    "reference",
    "resample",
    "scene",
    "slicing",
    "voxel-hw",
];

/// Libraries that neither read nor write text, nor correct misspellings.
const WITHOUT_TEXT: [&str; 10] = [
    "core",
    "datasets",
    "gpu",
    "projection",
    "raycast-cpu",
    "raycast-peel",
    "reference",
    "resample",
    "slicing",
    "voxel-hw",
];

/// The packages that do.
const TEXT: [&str; 3] = ["serde_json", "strsim", "toml"];

#[test]
fn packages_depend_only_on_those_below_them() {
    let mut wrong = Vec::new();
    for (package, kind, dependency) in dependencies() {
        let Some((_, built_with, tested_with)) = RULES.iter().find(|rule| rule.0 == package) else {
            wrong.push(format!("{package} has no rule here"));
            continue;
        };
        let allowed = built_with.contains(&dependency.as_str())
            || (kind == "dev" && tested_with.contains(&dependency.as_str()));
        if !allowed {
            wrong.push(format!("{package} may not use {dependency} ({kind})"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_draws_compiles_neither_toml_nor_json() {
    for package in WITHOUT_TEXT {
        let compiled = compiled(package);
        let found: Vec<_> = TEXT.iter().filter(|name| has(&compiled, name)).collect();
        assert!(found.is_empty(), "{package} compiles {found:?}");
    }
    // Where they are, they are found.
    let scene = compiled("scene");
    assert!(TEXT.iter().all(|name| has(&scene, name)), "{scene:?}");
}

/// The packages of a server.
const SERVER: [&str; 4] = ["axum", "hyper", "tokio", "tungstenite"];

#[test]
fn who_does_not_want_the_viewer_compiles_no_server() {
    let default = listed(&["--package", "tetrascope"]);
    assert!(SERVER.iter().all(|name| has(&default, name)), "{default:?}");
    for features in [
        "cli",
        "cli,projection,raycast-peel,resample,slicing,voxel-hw",
    ] {
        let arguments = [
            "--package",
            "tetrascope",
            "--no-default-features",
            "--features",
        ];
        let compiled = listed(&[&arguments[..], &[features]].concat());
        assert!(has(&compiled, "clap"), "{compiled:?}");
        let found: Vec<_> = SERVER.iter().filter(|name| has(&compiled, name)).collect();
        assert!(found.is_empty(), "{features} compiles {found:?}");
    }
}

#[test]
fn nobody_needs_mpi_unless_it_is_asked_for() {
    let package = ["--package", "tetrascope-cluster"];
    let compiled = listed(&package);
    assert!(has(&compiled, "tetrascope-raycast-cpu"), "{compiled:?}");
    assert!(
        !has(&compiled, "mpi") && !has(&compiled, "clap"),
        "{compiled:?}"
    );
    let with_mpi = listed(&[&package[..], &["--features", "mpi"]].concat());
    assert!(
        has(&with_mpi, "mpi") && has(&with_mpi, "clap"),
        "{with_mpi:?}"
    );
    // It alone is not among the packages that are built without being named.
    let metadata = cargo(&["metadata", "--no-deps", "--format-version", "1"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("cargo writes JSON");
    let names = |key: &str| -> Vec<String> {
        let list = metadata[key].as_array().expect("a list").iter();
        list.map(|id| id.as_str().expect("an id").to_owned())
            .collect()
    };
    let built = names("workspace_default_members");
    let mut others = names("workspace_members");
    others.retain(|id| !built.contains(id));
    assert_eq!(others.len(), 1, "{others:?}");
    assert!(others[0].contains("/cluster#"), "{others:?}");
}

fn has(packages: &[String], name: &str) -> bool {
    packages.iter().any(|package| package == name)
}

/// Package, kind ("normal", "dev" or "build") and dependency, for all dependencies among the
/// packages of this workspace.
fn dependencies() -> Vec<(String, String, String)> {
    let metadata = cargo(&["metadata", "--no-deps", "--format-version", "1"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("cargo writes JSON");
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let short = |value: &Value| {
        let name = value["name"].as_str().expect("a name");
        name.strip_prefix("tetrascope-").unwrap_or(name).to_owned()
    };
    let mut all = Vec::new();
    for package in list(&metadata["packages"]) {
        for dependency in list(&package["dependencies"]) {
            if dependency["path"].is_string() {
                let kind = dependency["kind"].as_str().unwrap_or("normal");
                all.push((short(&package), kind.to_owned(), short(&dependency)));
            }
        }
    }
    assert!(all.iter().any(|d| d.0 == "tetrascope" && d.2 == "core"));
    all
}

/// Every package that is compiled for `package` on this machine, tests apart.
fn compiled(package: &str) -> Vec<String> {
    let package = format!("tetrascope-{package}");
    listed(&["--package", &package])
}

/// Every package that is compiled for what `arguments` choose, tests apart.
fn listed(arguments: &[&str]) -> Vec<String> {
    let tree = ["tree", "--edges", "normal", "--prefix", "none"];
    let tree = cargo(&[&tree, arguments].concat());
    let names = tree.lines().filter_map(|line| line.split(' ').next());
    names.map(String::from).collect()
}

fn cargo(arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(arguments)
        .arg("--offline")
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("cargo runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).expect("text")
}
