//! The page in a browser: what a person sees and does.

use crate::browser;
use crate::devtools::Tab;
use crate::program::{Viewer, rendered};

/// A token that stays when the viewer is started again.
const TOKEN: &str = "for-tests-only_0123456789";

/// An opaque background: a canvas keeps colors times their opacity, which rounds others.
const LINE: &str = "sphere --cells 3000 --background black";

/// The pixels of the page's picture: its size and straight RGBA.
fn pixels(tab: &mut Tab) -> ([u32; 2], Vec<u8>) {
    let value = tab.value(
        "(() => { const c = document.getElementById('picture'); \
         const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
         let s = ''; for (let i = 0; i < d.length; i += 4096) s += String.fromCharCode(...d.subarray(i, i + 4096)); \
         return { width: c.width, height: c.height, data: btoa(s) }; })()",
    );
    let number = |key: &str| value[key].as_u64().expect("a number") as u32;
    let data = value["data"].as_str().expect("text");
    ([number("width"), number("height")], base64(data))
}

/// RFC 4648.
fn base64(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u8> = text.bytes().filter(|c| *c != b'=').map(digit).collect();
    let mut bytes = Vec::with_capacity(digits.len() * 3 / 4);
    for four in digits.chunks(4) {
        let all = four.iter().fold(0_u32, |all, d| all << 6 | u32::from(*d));
        let all = all << (6 * (4 - four.len()));
        bytes.extend(&all.to_be_bytes()[1..four.len()]);
    }
    bytes
}

/// Waits for the complete picture of the newest state.
pub(crate) fn complete(tab: &mut Tab) {
    tab.until(
        "document.getElementById('picture').dataset.kind === 'complete' && state && !camera.isHeld() \
         && Number(document.getElementById('picture').dataset.version) === state.version \
         && state.size.join() === picture.size().join()",
    );
}

/// Holds the page's picture to what `tetrascope render` draws of the viewer's scene.
fn check(tab: &mut Tab, viewer: &Viewer, what: &str) -> Vec<u8> {
    check_by(tab, viewer, "raycast-cpu", what)
}

/// As [`check`], by an algorithm.
pub(crate) fn check_by(tab: &mut Tab, viewer: &Viewer, algorithm: &str, what: &str) -> Vec<u8> {
    complete(tab);
    let (size, shown) = pixels(tab);
    let folder = tempfile::tempdir().expect("a folder");
    let scene = viewer.file("scene.toml");
    let options = format!("--algorithm {algorithm}");
    let (wanted_size, wanted) = rendered(folder.path(), &scene, &options);
    assert_eq!(size, wanted_size, "{what}");
    let differ = shown.iter().zip(&wanted).filter(|(a, b)| a != b).count();
    assert_eq!(
        differ,
        0,
        "{what}: {differ} of {} bytes differ",
        wanted.len()
    );
    // The picture is one: it has many colors.
    let mut colors: Vec<&[u8]> = shown.chunks(4).collect();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() > 100, "{what}: {} colors", colors.len());
    shown
}

#[test]
fn a_page_is_turned_edited_reloaded_and_outlives_its_server() {
    let Some(browser) = browser::start() else {
        return;
    };
    let viewer = Viewer::start_with(LINE, Some(TOKEN));
    let mut tab = Tab::open(&browser.endpoint, &viewer.url);

    // The picture appears, as large as there is room, and nothing has to be scrolled.
    let first = check(&mut tab, &viewer, "at first");
    assert_eq!(
        tab.value("document.documentElement.scrollHeight <= innerHeight"),
        true
    );
    assert_eq!(
        tab.value("document.documentElement.scrollWidth <= innerWidth"),
        true
    );
    for panel in ["color", "scene", "drawing"] {
        tab.value(&format!("document.getElementById('tab-{panel}').click()"));
        let fits = format!(
            "document.getElementById('panel-{panel}').scrollHeight <= document.getElementById('panel-{panel}').clientHeight + 1"
        );
        assert_eq!(tab.value(&fits), true, "{panel}");
    }
    tab.value("document.getElementById('tab-color').click()");
    // All that can be used has a name for those who do not see it.
    let nameless = tab.value(
        "[...document.querySelectorAll('button, input, select, canvas[tabindex]')].filter((e) => \
         !e.textContent.trim() && !e.getAttribute('aria-label') && !e.labels?.length && !e.title).map((e) => e.outerHTML)",
    );
    assert_eq!(nameless, serde_json::json!([]));

    // A drag turns it; frames come meanwhile, and the last picture is the exact one.
    let mut kinds = Vec::new();
    tab.drag([400.0, 350.0], [560.0, 300.0], |tab| {
        let kind = tab.value("document.getElementById('picture').dataset.kind");
        kinds.push(kind.as_str().unwrap_or_default().to_owned());
    });
    let turned = check(&mut tab, &viewer, "turned");
    assert!(first != turned, "the pixels change");
    tab.until("picture.latencies.length > 0");
    let shown = tab.value("document.getElementById('status-latency').textContent");
    assert!(
        shown.as_str().is_some_and(|s| s.starts_with("latency")),
        "{shown}"
    );
    let latency = tab.value("picture.latency()");
    eprintln!("latency from input to picture: {latency} ms; pictures meanwhile: {kinds:?}");

    // Keys turn it, too.
    tab.value("document.getElementById('picture').focus()");
    let before = tab.value("state.version");
    tab.key("ArrowLeft");
    // The full state comes once the hand rests.
    tab.until(&format!("state.version > {before}"));
    let keyed = check(&mut tab, &viewer, "by a key");
    assert!(keyed != turned);

    // A point of the transfer function that is dragged shows.
    let place = tab.value(
        "(() => { const e = document.getElementById('editor').getBoundingClientRect(); \
         const p = state.look.preset.opacities.at(-1); const w = e.width - 16; const h = e.height - 16; \
         const r = [...state.look.preset.colors, ...state.look.preset.opacities].map((q) => q.scalar); \
         const [low, high] = [Math.min(...r), Math.max(...r)]; const pad = 0.04 * (high - low); \
         return [e.left + 8 + (p.scalar - low + pad) / (high - low + 2 * pad) * w, e.top + 8 + (1 - p.opacity) * h]; })()",
    );
    let [x, y] = [0, 1].map(|i| place[i].as_f64().expect("a number"));
    tab.drag([x, y], [x - 30.0, y + 60.0], |_| ());
    let edited = check(&mut tab, &viewer, "edited");
    assert!(edited != keyed);

    // A reload shows the same.
    tab.call("Page.reload", serde_json::json!({}));
    assert!(check(&mut tab, &viewer, "reloaded") == edited);

    // The difference to the truth is shown, and left again.
    tab.value("document.getElementById('difference').click()");
    tab.until("document.getElementById('picture').dataset.kind === 'difference'");
    tab.until("document.getElementById('legend-text').textContent.startsWith('RMSE')");
    tab.value("document.getElementById('legend-close').click()");
    assert!(check(&mut tab, &viewer, "after the difference") == edited);

    // A link holds the view: opened after a change, it brings the view back.
    let link = tab.value(
        "location.href + '#' + toBase64(new TextEncoder().encode(JSON.stringify(state.saved)))",
    );
    tab.value("document.querySelector('[data-from=\"+z\"]').click()");
    tab.until("state.camera.view_up[1] === 1");
    assert!(check(&mut tab, &viewer, "from above") != edited);
    tab.go("about:blank");
    tab.go(link.as_str().expect("an address"));
    tab.until("state && state.camera.view_up[1] !== 1");
    assert!(check(&mut tab, &viewer, "by a link") == edited);

    // The server goes: the page says so. It comes back: the view is as it was.
    let port = viewer.port;
    drop(viewer);
    tab.until("!document.getElementById('gone').hidden");
    let words = tab.value("document.getElementById('gone').innerText");
    assert!(
        words
            .as_str()
            .is_some_and(|w| w.contains("does not answer")),
        "{words}"
    );
    let viewer = Viewer::start_with(&format!("{LINE} --port {port}"), Some(TOKEN));
    tab.until("document.getElementById('gone').hidden && hello && state.camera.view_up[1] !== 1");
    assert!(check(&mut tab, &viewer, "with another server") == edited);

    // A wrong token is refused in words.
    tab.go(&viewer.url.replace(TOKEN, "for-tests-only_9876543210"));
    tab.until("document.body.innerText.includes('token')");

    if let Some(path) = std::env::var_os("TETRASCOPE_SCREENSHOT") {
        tab.go(&viewer.url);
        complete(&mut tab);
        let shot = base64(&tab.screenshot());
        std::fs::write(path, shot).expect("it is written");
    }
}
