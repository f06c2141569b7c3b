//! Gets a machine ready to draw: a graphics adapter, or a software one.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use tetrascope::Context;
use tetrascope::core::Error;

/// Debian's packages of Mesa's software renderer and of the Vulkan loader.
const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// Debian's package that brings SwiftShader, a second software Vulkan driver.
const SECOND_PACKAGE: &str = "chromium";

/// Where distributions put the description of that driver.
const SECOND_DRIVER: [&str; 3] = [
    "/usr/lib/chromium/vk_swiftshader_icd.json",
    "/usr/lib/chromium-browser/vk_swiftshader_icd.json",
    "/usr/lib64/chromium-browser/vk_swiftshader_icd.json",
];

/// Makes sure that there is a graphics adapter, and gives it in words.
///
/// Where there is none at all, Debian or Ubuntu is the system and this user may
/// install without being asked for a password, it installs Mesa's software
/// adapter and says so; elsewhere the error names the one command to type.
/// Everything that happens is told on stderr.
pub fn setup() -> Result<String, Error> {
    let missing = match probe() {
        Err(missing @ Error::NoAdapter { .. }) if tetrascope::gpu::adapters().is_empty() => missing,
        found => return found,
    };
    if !is_debian() {
        return Err(missing);
    }
    let Some(prefix) = root_prefix() else {
        return Err(with_command(missing, "sudo apt-get install"));
    };
    eprintln!(
        "no graphics adapter: installing {}, Mesa's software adapter",
        PACKAGES.join(" and ")
    );
    if !install(&prefix, &PACKAGES) {
        return Err(with_command(missing, "apt-get install"));
    }
    probe()
}

/// The description of SwiftShader for the Vulkan loader's `VK_DRIVER_FILES`; installs
/// the driver under the conditions of [`setup`].
///
/// # Errors
/// Why there is no second driver, in words.
pub fn second_driver() -> Result<PathBuf, String> {
    let find = || {
        SECOND_DRIVER
            .map(Path::new)
            .into_iter()
            .find(|path| path.is_file())
    };
    if let Some(found) = find() {
        return Ok(found.to_owned());
    }
    let by_hand = format!("to test on SwiftShader too, install the package `{SECOND_PACKAGE}`");
    if !is_debian() {
        return Err(by_hand);
    }
    let prefix = root_prefix().ok_or(by_hand.as_str())?;
    eprintln!("no second Vulkan driver: installing {SECOND_PACKAGE}, which brings SwiftShader");
    if !install(&prefix, &[SECOND_PACKAGE]) {
        return Err(by_hand);
    }
    find()
        .map(Path::to_owned)
        .ok_or_else(|| format!("the package `{SECOND_PACKAGE}` brought no SwiftShader"))
}

/// Names under which a Chromium is found.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A browser that shows pages without a screen: Chromium, which [`second_driver`] installs, too.
///
/// # Errors
/// That there is none, in words.
pub fn browser() -> Result<PathBuf, String> {
    BROWSERS.into_iter().find_map(in_path).ok_or_else(|| {
        format!("there is no Chromium; on Debian it is the package `{SECOND_PACKAGE}`")
    })
}

/// Debian's packages of what the tests of the Python package need.
const PYTHON_PACKAGES: [&str; 3] = ["python3", "python3-numpy", "python3-pytest"];

/// Where Python is.
const PYTHONS: [&str; 2] = ["python3", "/usr/bin/python3"];

/// A Python with NumPy and pytest, for the tests of the Python package; installs them under the
/// conditions of [`setup`], or in a folder of the build where there is a Python without them.
///
/// # Errors
/// Why there is none, in words.
pub fn python() -> Result<PathBuf, String> {
    let needed = "import sys, numpy, pytest; assert sys.version_info >= (3, 10)";
    let runs = |python: &Path, arguments: &[&str]| {
        let output = Command::new(python).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    let own = crate::machine::target().join("python");
    let in_own = own.join(if cfg!(windows) {
        "Scripts/python.exe"
    } else {
        "bin/python3"
    });
    let find = || {
        let mut places = PYTHONS.iter().map(PathBuf::from).chain([in_own.clone()]);
        places.find(|python| runs(python, &["-c", needed]))
    };
    if let Some(found) = find() {
        return Ok(found);
    }
    if is_debian()
        && let Some(prefix) = root_prefix()
    {
        eprintln!(
            "no Python with NumPy and pytest: installing {}",
            PYTHON_PACKAGES.join(", ")
        );
        if install(&prefix, &PYTHON_PACKAGES)
            && let Some(found) = find()
        {
            return Ok(found);
        }
    }
    let folder = own.display().to_string();
    if PYTHONS
        .iter()
        .any(|python| runs(Path::new(python), &["-m", "venv", &folder]))
    {
        eprintln!("installing NumPy and pytest in {folder}");
        runs(
            &in_own,
            &["-m", "pip", "install", "--quiet", "numpy", "pytest"],
        );
    }
    find().ok_or_else(|| {
        "to test the Python package, install Python 3.10 or later with NumPy and pytest".into()
    })
}

/// Debian's packages of an MPI, and of the library of Clang by which its bindings are made.
const MPI_PACKAGES: [&str; 3] = ["libopenmpi-dev", "openmpi-bin", "libclang-dev"];

/// The `mpirun` that starts programs with many ranks, where they can be built, too; installs Open MPI under the conditions
/// of [`setup`].
///
/// # Errors
/// Why there is none, in words.
pub fn mpi() -> Result<PathBuf, String> {
    let find = || {
        let mpirun = in_path("mpirun").filter(|_| in_path("mpicc").is_some())?;
        has_libclang().then_some(mpirun)
    };
    if let Some(found) = find() {
        return Ok(found);
    }
    let by_hand = format!(
        "to test ranks that are processes, install the packages {}",
        MPI_PACKAGES.join(", ")
    );
    if !is_debian() {
        return Err(by_hand);
    }
    let prefix = root_prefix().ok_or(by_hand.as_str())?;
    eprintln!(
        "no MPI to build with: installing {}",
        MPI_PACKAGES.join(", ")
    );
    if !install(&prefix, &MPI_PACKAGES) {
        return Err(by_hand);
    }
    find().ok_or_else(|| format!("the packages {} brought no MPI", MPI_PACKAGES.join(", ")))
}

/// Whether bindings to C can be made: by the library that a variable names, or the one in its place.
fn has_libclang() -> bool {
    if env::var_os("LIBCLANG_PATH").is_some() {
        return true;
    }
    let llvm = std::fs::read_dir("/usr/lib")
        .into_iter()
        .flatten()
        .flatten();
    let mut folders = llvm.map(|entry| entry.path().join("lib"));
    folders.any(|folder| {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = files.map(|file| file.file_name().to_string_lossy().into_owned());
        names
            .into_iter()
            .any(|name| name.starts_with("libclang") && name.contains(".so"))
    })
}

/// A program by its name.
fn in_path(name: &str) -> Option<PathBuf> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let mut places = env::split_paths(&folders);
    places.find_map(|folder| Some(folder.join(name)).filter(|path| path.is_file()))
}

/// Installs Debian packages and says so; whether that worked.
fn install(prefix: &[&str], packages: &[&str]) -> bool {
    // Lists may be fresh enough even if an update fails; the installation decides.
    if !apt(prefix, &["update", "--quiet"]) {
        eprintln!("`apt-get update` failed; going on with the lists that are here");
    }
    let mut arguments = vec!["install", "--yes", "--quiet", "--no-install-recommends"];
    arguments.extend(packages);
    let installed = apt(prefix, &arguments);
    if installed {
        eprintln!("installed {}", packages.join(" and "));
    }
    installed
}

/// A device in words, made for the purpose: an adapter that gives none is no use.
fn probe() -> Result<String, Error> {
    let context = Context::new();
    context.gpu().map(|gpu| gpu.describe())
}

fn with_command(error: Error, command: &str) -> Error {
    match error {
        Error::NoAdapter { reason, .. } => Error::NoAdapter {
            reason,
            help: Some(format!("type `{command} {}`", PACKAGES.join(" "))),
        },
        other => other,
    }
}

/// Whether this is Debian, Ubuntu or made from them (os-release(5)).
fn is_debian() -> bool {
    let release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    is_debian_release(&release)
}

fn is_debian_release(release: &str) -> bool {
    release
        .lines()
        .filter_map(|line| line.strip_prefix("ID=").or(line.strip_prefix("ID_LIKE=")))
        .flat_map(|names| names.trim_matches('"').split(' '))
        .any(|name| name == "debian" || name == "ubuntu")
}

/// The words before a command that run it as root without a password: nothing
/// for root itself, `None` where that cannot be.
fn root_prefix() -> Option<Vec<&'static str>> {
    let output = Command::new("id").arg("-u").output().ok()?;
    if output.stdout.trim_ascii() == b"0" {
        return Some(Vec::new());
    }
    let sudo = Command::new("sudo").args(["-n", "true"]).output().ok()?;
    sudo.status.success().then(|| vec!["sudo", "-n"])
}

fn apt(prefix: &[&str], arguments: &[&str]) -> bool {
    let mut words =
        prefix
            .iter()
            .copied()
            .chain(["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
    let program = words.next().expect("there is `env` at least");
    let mut command = Command::new(program);
    command.args(words).args(arguments);
    // Only results go to stdout.
    command.stdout(std::io::stderr());
    command.status().is_ok_and(|status| status.success())
}

/// Whether a missing adapter is a failure: in CI, where there must be one.
pub fn adapter_is_required() -> bool {
    env::var_os("CI").is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn debian_and_its_children_are_known() {
        assert!(is_debian_release("NAME=\"Debian GNU/Linux\"\nID=debian\n"));
        assert!(is_debian_release("ID=ubuntu\nID_LIKE=debian"));
        assert!(is_debian_release("ID=linuxmint\nID_LIKE=\"ubuntu debian\""));
        assert!(!is_debian_release("ID=fedora\nID_LIKE=\"rhel centos\""));
        assert!(!is_debian_release("NAME=\"not debian\""));
    }

    #[test]
    fn the_command_to_type_names_the_packages() {
        let missing = Error::NoAdapter {
            reason: "none".into(),
            help: None,
        };
        let help = with_command(missing, "sudo apt-get install").help();
        assert_eq!(
            help.as_deref(),
            Some("type `sudo apt-get install mesa-vulkan-drivers libvulkan1`")
        );
    }
}
