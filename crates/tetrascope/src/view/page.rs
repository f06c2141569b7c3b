//! The page: three files, of which none loads anything from elsewhere.

/// A file of the page with its media type.
pub(crate) fn file(name: &str) -> Option<(&'static str, &'static str)> {
    match name {
        "" => Some(("text/html; charset=utf-8", include_str!("page/index.html"))),
        "style.css" => Some(("text/css; charset=utf-8", include_str!("page/style.css"))),
        "viewer.js" => Some((
            "text/javascript; charset=utf-8",
            include_str!("page/viewer.js"),
        )),
        "icon.svg" => Some(("image/svg+xml", include_str!("page/icon.svg"))),
        _ => None,
    }
}
