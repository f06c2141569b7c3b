//! The page: its files, of which none loads anything from elsewhere.
//!
//! `index.html` names the scripts in their order; each has an idea of its own, and uses those before it.

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// The name, media type and content of a file.
macro_rules! files {
    ($($name:literal from $file:literal: $media:expr,)*) => {
        &[$(($name, $media, include_str!(concat!("page/", $file)))),*]
    };
}

const FILES: &[(&str, &str, &str)] = files![
    "" from "index.html": HTML,
    "style.css" from "style.css": CSS,
    "icon.svg" from "icon.svg": "image/svg+xml",
    "common.js" from "common.js": SCRIPT,
    "curve.js" from "curve.js": SCRIPT,
    "link.js" from "link.js": SCRIPT,
    "picture.js" from "picture.js": SCRIPT,
    "clip.js" from "clip.js": SCRIPT,
    "camera.js" from "camera.js": SCRIPT,
    "difference.js" from "difference.js": SCRIPT,
    "steps.js" from "steps.js": SCRIPT,
    "editor.js" from "editor.js": SCRIPT,
    "knowledge.js" from "knowledge.js": SCRIPT,
    "panels.js" from "panels.js": SCRIPT,
];

/// A file of the page with its media type.
pub(crate) fn file(name: &str) -> Option<(&'static str, &'static str)> {
    let (_, media, text) = FILES.iter().find(|(known, ..)| *known == name)?;
    Some((media, text))
}
