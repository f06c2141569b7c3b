//! Lists of the files of a series.

use super::{Entry, Seed};
use crate::pack::Part;

pub(super) const PVD_WORDS: &[&str] = &[
    "<DataSet timestep=\"1\" file=\"a.vtu\"/>",
    "<DataSet file=\"a.vtu\"/>",
    "<!DOCTYPE a [<!ENTITY b \"c\">]>",
    "<Collection>",
    "&amp;",
    "&#x1b;",
    "nan",
    "1e999",
    "../",
];

pub(super) const SERIES_WORDS: &[&str] = &[
    "{\"name\": \"a.vtu\", \"time\": 1}, ",
    "{\"name\": \"b.vtu\"}, ",
    "\"file-series-version\": \"1.0\", ",
    "[[[[",
    "{\"files\": ",
    "null",
    "\\u001b",
    "\\ud800",
    "-1e308",
];

/// `.pvd` files with the files that they list.
pub(super) fn pvd() -> Vec<Seed> {
    let text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n\
                <DataSet timestep=\"0.5\" group=\"\" part=\"0\" file=\"a.vtu\"/>\n\
                <DataSet timestep=\"1e1\" file=\"./b.vtu\"></DataSet>\n</Collection>\n</VTKFile>\n";
    vec![seed("steps.pvd", text)]
}

/// `.series` files with theirs.
pub(super) fn series() -> Vec<Seed> {
    let text = "{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n    \
                {\"name\": \"a.vtu\", \"time\": 0.5},\n    {\"name\": \"b.vtu\", \"time\": 10}\n  ]\n}\n";
    vec![seed("steps.vtu.series", text)]
}

fn seed(name: &'static str, text: &str) -> Seed {
    let listed = |name| (name, vec![Part::plain("a step")]);
    Seed {
        files: vec![
            (name, vec![Part::plain(text)]),
            listed("a.vtu"),
            listed("b.vtu"),
        ],
        entry: Entry::Collection,
    }
}
