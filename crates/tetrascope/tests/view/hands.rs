//! The rest of what hands do in a page: fingers, time steps, files, other algorithms, clip planes; and two
//! pages at once.

use serde_json::{Value, json};

use crate::browser;
use crate::devtools::Tab;
use crate::page::{check_by, complete};
use crate::program::Viewer;

/// A legacy VTK file of a cube's six tetrahedra around a diagonal, with values of a time step.
pub(crate) fn tetrahedra(step: u32) -> String {
    let mut text =
        "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\n".to_owned();
    text += "POINTS 8 double\n0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1\nCELLS 6 30\n";
    for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
        text += &format!("4 0 {a} {b} 7\n");
    }
    text +=
        "CELL_TYPES 6\n10 10 10 10 10 10\nPOINT_DATA 8\nSCALARS s double 1\nLOOKUP_TABLE default\n";
    for corner in 0..8_u32 {
        text += &format!("{}\n", (corner * 37 + step * 11) % 50);
    }
    text
}

/// A collection of three of them.
fn series(folder: &std::path::Path) -> String {
    let mut files = Vec::new();
    for step in 0..3 {
        let name = format!("t{step}.vtk");
        std::fs::write(folder.join(&name), tetrahedra(step)).expect("written");
        files.push(json!({"name": name, "time": 0.5 * f64::from(step)}));
    }
    let path = folder.join("cube.vtk.series");
    let text = json!({"file-series-version": "1.0", "files": files}).to_string();
    std::fs::write(&path, text).expect("written");
    path.to_str().expect("text").into()
}

impl Tab {
    /// Two fingers, or one, from places to places, in steps.
    fn fingers<const N: usize>(&mut self, from: [[f64; 2]; N], to: [[f64; 2]; N]) {
        const STEPS: u32 = 8;
        for step in 0..=STEPS {
            let s = f64::from(step) / f64::from(STEPS);
            let at = |i: usize, k: usize| (from[i][k] * (1.0 - s) + to[i][k] * s).round();
            let points = (0..N).map(|i| json!({"x": at(i, 0), "y": at(i, 1), "id": i}));
            let points: Vec<Value> = points.collect();
            let kind = if step == 0 { "touchStart" } else { "touchMove" };
            let event = json!({"type": kind, "touchPoints": points});
            self.call("Input.dispatchTouchEvent", event);
        }
        let end = json!({"type": "touchEnd", "touchPoints": []});
        self.call("Input.dispatchTouchEvent", end);
    }

    fn numbers<const N: usize>(&mut self, expression: &str) -> [f64; N] {
        let value = self.value(expression);
        std::array::from_fn(|i| {
            value[i]
                .as_f64()
                .unwrap_or_else(|| panic!("{expression}: {value}"))
        })
    }

    /// The camera's distance from what it looks at.
    fn distance(&mut self) -> f64 {
        let [position, focal] = ["position", "focal_point"]
            .map(|part| self.numbers::<3>(&format!("camera.now().{part}")));
        (0..3)
            .map(|i| (position[i] - focal[i]).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    fn click(&mut self, id: &str) {
        self.value(&format!("document.getElementById('{id}').click()"));
    }

    /// Gives a file to the page's dialog.
    fn choose_file(&mut self, path: &std::path::Path) {
        let root = self.call("DOM.getDocument", json!({}));
        let root = &root["root"]["nodeId"];
        let found = self.call(
            "DOM.querySelector",
            json!({"nodeId": root, "selector": "#file"}),
        );
        let files = json!({"nodeId": found["nodeId"], "files": [path]});
        self.call("DOM.setFileInputFiles", files);
    }
}

#[test]
fn fingers_steps_files_algorithms_handles_and_a_second_page() {
    let Some(browser) = browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let line = format!("{} --background black", series(folder.path()));
    let viewer = Viewer::start(&line);
    let mut tab = Tab::open(&browser.endpoint, &viewer.url);
    complete(&mut tab);
    let mut other = Tab::open(&browser.endpoint, &viewer.url);
    other.until("state && picture.header()");

    // A page behind another takes no input.
    tab.call("Page.bringToFront", json!({}));
    // Two fingers that move apart come nearer by as much, and do not lose what they look at.
    let touch = json!({"enabled": true, "maxTouchPoints": 2});
    tab.call("Emulation.setTouchEmulationEnabled", touch);
    let before = tab.distance();
    tab.fingers(
        [[380.0, 350.0], [480.0, 350.0]],
        [[330.0, 350.0], [530.0, 350.0]],
    );
    // Products of eight quotients, in f64.
    assert!((before / tab.distance() / 2.0 - 1.0).abs() < 1e-12);
    let from = tab.numbers::<3>("camera.now().position");
    tab.fingers([[400.0, 300.0]], [[460.0, 340.0]]);
    assert!(from != tab.numbers::<3>("camera.now().position"));
    assert!(
        (before / tab.distance() / 2.0 - 1.0).abs() < 1e-12,
        "one turns"
    );
    check_by(&mut tab, &viewer, "raycast-cpu", "by fingers");

    // The other page follows.
    let position = tab.value("state.camera.position");
    other.until(&format!(
        "JSON.stringify(state.camera.position) === '{position}'"
    ));
    other.until("Number(document.getElementById('picture').dataset.version) === state.version");
    assert_eq!(other.value("hello.is_first"), false);

    // Time steps: one on, then played until all have been there.
    tab.click("step-on");
    tab.until("state.step === 1");
    check_by(&mut tab, &viewer, "raycast-cpu", "the second step");
    tab.click("play");
    for step in [2, 0, 1] {
        tab.until(&format!("state.step === {step}"));
    }
    tab.click("play");
    assert_eq!(
        tab.value("document.getElementById('play').getAttribute('aria-pressed')"),
        "false"
    );
    complete(&mut tab);

    // A preset of ParaView from the file dialog; another file is refused in words.
    let preset = folder.path().join("warm.json");
    let text = r#"[{"Name": "warm", "ColorSpace": "RGB", "RGBPoints": [0, 0.2, 0, 0, 50, 1, 1, 0.4], "Points": [0, 0.1, 0.5, 0, 50, 0.9, 0.5, 0]}]"#;
    std::fs::write(&preset, text).expect("written");
    tab.choose_file(&preset);
    tab.until("state.look.preset.name === 'warm' && state.look.colormap === null");
    check_by(&mut tab, &viewer, "raycast-cpu", "a preset");
    std::fs::write(&preset, "[7]").expect("written");
    tab.choose_file(&preset);
    tab.until("document.querySelector('.message.problem')");
    assert_eq!(tab.value("state.look.preset.name"), "warm");

    // A clip plane by its handle: it follows the pointer along its axis.
    tab.call(
        "Emulation.setTouchEmulationEnabled",
        json!({"enabled": false}),
    );
    tab.click("clip-handles");
    let handle = "[...document.querySelectorAll('.handle.of-x')][1]";
    let center = format!(
        "(() => {{ const b = {handle}.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
    );
    let start = tab.numbers::<2>(&center);
    let end = tab.numbers::<2>("camera.project([0.4, 0.5, 0.5])");
    tab.drag(start, end, |_| ());
    tab.until("state.clip.length === 1");
    assert_eq!(tab.value("state.clip[0].normal"), json!([-1, 0, 0]));
    let [at] = tab.numbers::<1>("[state.clip[0].point[0]]");
    // Both coordinates of a pointer are rounded by less than a pixel where it takes hold and where it
    // lets go: 2√2 pixels in all. On average 0.6 of the axis is that many pixels long, and nowhere
    // in this view does perspective make a part of it twice as short.
    let pixels = (start[0] - end[0]).hypot(start[1] - end[1]);
    let most = 2.0 * 2.0 * std::f64::consts::SQRT_2 * 0.6 / pixels;
    assert!((at - 0.4).abs() < most, "{at}, {most}");
    check_by(&mut tab, &viewer, "raycast-cpu", "clipped");
    // By keys: a hundredth of the box, and all of it.
    tab.value(&format!("{handle}.focus()"));
    tab.key("ArrowLeft");
    tab.until(&format!(
        "Math.abs(state.clip[0].point[0] - {at} + 0.01) < 1e-12"
    ));
    let told = tab.value(&format!("Number({handle}.getAttribute('aria-valuenow'))"));
    assert!((told.as_f64().expect("a number") - at + 0.01).abs() < 1e-12);
    tab.key("End");
    tab.until("state.clip.length === 0");

    // An algorithm of the GPU, if there is one.
    if tetrascope::gpu::adapters().is_empty() {
        eprintln!("skipped: there is no graphics adapter");
        return;
    }
    tab.value(
        "(() => { const e = document.getElementById('algorithm'); e.value = 'raycast-peel'; e.dispatchEvent(new Event('change')); })()",
    );
    tab.until(
        "state.algorithm === 'raycast-peel' && picture.header().algorithm === 'raycast-peel'",
    );
    check_by(&mut tab, &viewer, "raycast-peel", "on the GPU");
    let known = tab.value("document.getElementById('honesty').innerText");
    let adapter = tab.value("picture.header().adapter");
    let adapter = adapter.as_str().expect("an adapter");
    assert!(
        known.as_str().is_some_and(|text| text.contains(adapter)),
        "{known}"
    );
}
