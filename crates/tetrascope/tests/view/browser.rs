//! A browser without a screen.

use std::env;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Names under which a Chromium is found.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A browser that runs; it is killed with this.
pub(crate) struct Browser {
    child: Child,
    /// Where it takes commands.
    pub(crate) endpoint: String,
    /// The folder that it keeps.
    _profile: tempfile::TempDir,
}

/// Starts one; `None`, with a message, where there is none and that is no error.
pub(crate) fn start() -> Option<Browser> {
    let Some(program) = find() else {
        assert!(
            env::var_os("CI").is_none(),
            "there is no Chromium, which the tests here need"
        );
        eprintln!("skipped: there is no Chromium; on Debian it is the package `chromium`");
        return None;
    };
    let profile = tempfile::tempdir().expect("a folder");
    let mut child = Command::new(program)
        .args([
            "--headless=new",
            "--no-sandbox", // it runs as root in containers
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--disable-extensions",
            "--disable-background-networking",
            "--no-first-run",
            "--hide-scrollbars",
            "--force-color-profile=srgb",
            "--remote-debugging-port=0",
            "--window-size=1280,720",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg("about:blank")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let endpoint = lines.by_ref().map_while(Result::ok).find_map(|line| {
        line.strip_prefix("DevTools listening on ")
            .map(str::to_owned)
    });
    let Some(endpoint) = endpoint else {
        let status = child.wait();
        panic!("the browser takes no commands: {status:?}");
    };
    // It says more, and must not wait for who reads it.
    std::thread::spawn(move || lines.for_each(drop));
    Some(Browser {
        child,
        endpoint,
        _profile: profile,
    })
}

fn find() -> Option<PathBuf> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let named = |name: &str| {
        let mut places = env::split_paths(&folders);
        places.find_map(|folder| Some(folder.join(name)).filter(|path| path.is_file()))
    };
    NAMES.into_iter().find_map(named)
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
