//! `cargo xtask compare --check`: all default scenes, small, and the page in a real browser.

mod faults;
#[cfg(unix)]
mod front;

use std::path::{Path, PathBuf};
use std::process::Command;

use tetrascope_testing::say;
use xtask::compare::{self, Options};
use xtask::setup::{adapter_is_required, browser};
use xtask::testing::algorithms;

/// A script for a browser: it does what a person would, and leaves what it finds as text.
const QUESTIONS: &str = include_str!("questions.js");

fn check(out: &Path) -> Options {
    Options {
        scenes: Vec::new(),
        field: None,
        algorithms: Vec::new(),
        models: vec!["emission-absorption".into(), "emission".into()],
        size: None,
        orthographic: false,
        repeat: 5,
        out: Some(out.into()),
        check: true,
        error: None,
        budget: None,
        peer: None,
        scaling: false,
        memory: false,
        json: false,
    }
}

fn read(path: PathBuf) -> String {
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The errors of a report, one per line, with what they are of.
fn errors(report: &serde_json::Value) -> Vec<String> {
    let mut lines = Vec::new();
    for scene in report["scenes"].as_array().expect("scenes") {
        for model in scene["models"].as_array().expect("models") {
            for row in model["rows"].as_array().expect("rows") {
                lines.push(format!(
                    "{} {} {} {}: {}",
                    scene["name"],
                    model["model"],
                    row["algorithm"],
                    row["setting"],
                    row["outcome"]["drawn"]["error"]
                ));
            }
        }
    }
    lines
}

#[test]
fn all_bounds_are_kept_and_a_browser_shows_the_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    assert!(compare::run(&check(&out)).expect("compared"));
    let report: serde_json::Value =
        serde_json::from_str(&read(out.join("report.json"))).expect("JSON");
    let scenes = report["scenes"].as_array().expect("scenes");
    let names: Vec<&str> = scenes.iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(
        names,
        ["sphere", "heat-sink", "angiography", "sphere, parallel"]
    );
    let has_gpu = algorithms("compare").iter().any(|a| a.needs_gpu);
    if has_gpu {
        // Every algorithm draws in some scene.
        for algorithm in tetrascope::algorithms() {
            let mut rows = scenes
                .iter()
                .flat_map(|scene| scene["models"].as_array().expect("models"))
                .flat_map(|model| model["rows"].as_array().expect("rows"));
            let drawn = |row: &serde_json::Value| {
                row["algorithm"] == algorithm.name && row["outcome"]["drawn"].is_object()
            };
            assert!(rows.any(drawn), "{}", algorithm.name);
        }
        assert!(
            report["checks"]
                .as_array()
                .is_some_and(|checks| checks.len() > 5)
        );
    }
    assert_eq!(report["resumed"], 0);
    assert!(!out.join("parts").exists(), "all is done");
    look(&out.join("index.html"));
}

#[test]
fn what_is_done_of_a_run_is_not_done_again_and_no_error_differs() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let options = |algorithms: &str| Options {
        scenes: vec!["sphere".into(), "staircase".into()],
        algorithms: vec![algorithms.into()],
        ..check(&out)
    };
    let run = |options: &Options| {
        assert!(compare::run(options).expect("compared"));
        serde_json::from_str::<serde_json::Value>(&read(out.join("report.json"))).expect("JSON")
    };
    let algorithm = algorithms("compare")
        .last()
        .expect("the reference at least")
        .name;
    let whole = run(&options(algorithm));
    // A run that is stopped: its report cannot be written.
    let page = out.join("index.html");
    std::fs::remove_file(&page).expect("written above");
    std::fs::create_dir(&page).expect("made");
    compare::run(&options(algorithm)).expect_err("a folder is in the way");
    std::fs::remove_dir(&page).expect("made above");
    // One of its four parts is damaged: that one is drawn again.
    let mut parts = std::fs::read_dir(out.join("parts")).expect("parts");
    let parts = parts.next().expect("of one run").expect("readable").path();
    std::fs::write(parts.join("1-1.json"), "{ damaged").expect("written");
    let resumed = run(&options(algorithm));
    assert_eq!(resumed["resumed"], 3);
    assert_eq!(errors(&whole), errors(&resumed));
    assert_eq!(whole["checks"], resumed["checks"]);
    assert_eq!(run(&options(algorithm))["resumed"], 0);
}

/// A page as a headless browser leaves it once its scripts are done, or its time is over.
fn ask(browser: &Path, profile: &Path, page: &Path) -> std::process::Output {
    Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args([
            "--virtual-time-budget=60000",
            "--window-size=1200,900",
            "--dump-dom",
        ])
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("it runs")
}

/// Opens a page in a headless browser and asks [`QUESTIONS`].
fn look(page: &Path) {
    let browser = match browser() {
        Ok(browser) => browser,
        Err(why) => {
            assert!(!adapter_is_required(), "CI is set, but: {why}");
            say(&format!("skipped: the page in a browser: {why}"));
            return;
        }
    };
    // A copy asks itself: what goes wrong before the page's own script is noted, too.
    let text = read(page.into());
    let noted = "<script>window.wrong = []; addEventListener('error', (e) => wrong.push(e.message ?? e.target.outerHTML.slice(0, 80)), true); console.error = console.warn = (...all) => wrong.push(all.join(' '));</script>";
    let asked = text
        .replacen("<head>", &format!("<head>{noted}"), 1)
        .replacen(
            "</body>",
            &format!("<script>{QUESTIONS}</script></body>"),
            1,
        );
    assert!(asked.len() > text.len() + QUESTIONS.len());
    let copy = page.with_file_name("asked.html");
    std::fs::write(&copy, asked).expect("written");
    let profile = page.with_file_name("profile");
    // On a busy machine the browser's time may be over before the page has answered.
    let mut output = None;
    let answers = (0..3).find_map(|_| {
        let asked = ask(&browser, &profile, &copy);
        let dom = String::from_utf8_lossy(&asked.stdout).into_owned();
        output = Some(asked);
        let (_, rest) = dom.split_once("<pre id=\"answers\">")?;
        Some(rest.split_once("</pre>")?.0.to_owned())
    });
    let Some(answers) = answers else {
        let output = output.expect("it was asked");
        panic!(
            "the page did not answer: {} bytes, {}",
            output.stdout.len(),
            String::from_utf8_lossy(&output.stderr)
        );
    };
    let answers: serde_json::Value = serde_json::from_str(&answers).expect("JSON");
    assert_eq!(answers["wrong"], serde_json::json!([]));
    assert_eq!(answers["unresolved"], serde_json::json!([]));
    assert!(answers["images"].as_u64() > Some(10), "{answers}");
    // In every scene the slider moves, by its value and by a pointer, and all other controls do what
    // they say.
    for viewer in answers["viewers"].as_array().expect("viewers") {
        for what in ["shown", "slider", "drag", "blink", "zoom", "words", "model"] {
            assert_eq!(viewer[what], true, "{what} in {viewer}");
        }
    }
    assert!(
        answers["viewers"]
            .as_array()
            .is_some_and(|all| !all.is_empty())
    );
}
