//! Scene files.

use super::{Entry, Seed, bytes_of};
use crate::pack::Part;

pub(super) const WORDS: &[&str] = &[
    "version = 1\n",
    "[volume]\n",
    "[camera]\n",
    "[image]\n",
    "[appearance]\n",
    "[[appearance.transfer_function]]\n",
    "[[appearance.isosurfaces]]\n",
    "file = \"grid.raw\"\n",
    "dataset = \"sphere\"\n",
    "solution = \"a\"\n",
    "field = \"s\"\n",
    "cells = 100\n",
    "seed = 1\n",
    "dims = [2, 3, 4]\n",
    "type = \"u8\"\n",
    "type = \"f64\"\n",
    "spacing = [1.0, 1.0, 1e-310]\n",
    "origin = [0.0, 0.0, 0.0]\n",
    "offset = 1\n",
    "byte_order = \"big\"\n",
    "fit = \"+iso\"\n",
    "position = [9.0, 0.0, 0.0]\n",
    "focal_point = [0.0, 0.0, 0.0]\n",
    "view_up = [0.0, 1.0, 0.0]\n",
    "projection = \"orthographic\"\n",
    "view_angle = 20.0\n",
    "parallel_scale = 3.0\n",
    "width = 64\n",
    "height = 64\n",
    "background = [0.0, 0.0, 0.0, 1.0]\n",
    "optical_model = \"isosurfaces\"\n",
    "colormap = \"magma\"\n",
    "range = [0.0, 1.0]\n",
    "unit_distance = 0.1\n",
    "depth_cue = 0.5\n",
    "ambient = 0.1\n",
    "scalar = 1.0\n",
    "color = [1.0, 1.0, 1.0]\n",
    "extinction = 1.0\n",
    "value = 0.5\n",
    "nan",
    "inf",
    "-inf",
    "1e39",
    "[",
    "]",
    "{",
    "}",
    "\"",
    ",",
    "\n",
    "\"\"\"",
    "\\u001b",
    "\\u0000",
];

const LONG: &str = "\
version = 1

[volume]
file = \"grid.raw\"
dims = [2, 3, 4]
type = \"u8\"
spacing = [1.0, 1.0, 2.0]
origin = [0.0, -1.0, 0.0]

[camera]
position = [9.0, 8.0, 7.0]
focal_point = [0.0, 0.0, 0.0]
view_up = [0.0, 0.0, 1.0]
projection = \"perspective\"
view_angle = 30.0

[image]
width = 64
height = 48
background = [0.0, 0.0, 0.0, 1.0]

[appearance]
optical_model = \"isosurfaces\"
depth_cue = 0.5
ambient = 0.2
transfer_function = [
  { scalar = 0.0, color = [0.0, 0.0, 1.0], extinction = 0.0 },
  { scalar = 100.0, color = [1.0, 0.5, 0.0], extinction = 3.0 },
]
isosurfaces = [{ value = 50.0, color = [1.0, 1.0, 1.0] }, { value = 20.0 }]
lights = [{ toward = [1.0, 1.0, 1.0], color = [1.0, 1.0, 1.0] }]
clip_planes = [{ point = [0.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }]
";

const SHORT: &str = "\
version = 1
[volume]
file = \"grid.raw\"
dims = [2, 3, 4]
type = \"u8\"
[camera]
fit = \"+x\"
projection = \"orthographic\"
[appearance]
colormap = \"inferno\"
range = [10.0, 90.0]
unit_distance = 0.5
";

const JSON: &str = r#"{"version": 1, "volume": {"file": "grid.raw", "dims": [2, 3, 4], "type": "i8"},
"camera": {"position": [9, 8, 7], "parallel_scale": 4}, "image": {"width": 32},
"appearance": {"optical_model": "emission", "range": [0, 50], "depth_cue": 0.25}}
"#;

pub(super) fn scenes() -> Vec<Seed> {
    let scene = |name, text: &str| Seed {
        files: vec![
            (name, vec![Part::plain(text)]),
            ("grid.raw", vec![Part::plain(bytes_of(24, |v| [v as u8]))]),
        ],
        entry: Entry::Scene,
    };
    vec![
        scene("scene.toml", LONG),
        scene("scene.toml", SHORT),
        scene("scene.json", JSON),
    ]
}
