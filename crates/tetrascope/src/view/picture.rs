//! The files that a person saves: images, and the command line that draws one.

use std::fmt::Write as _;

use tetrascope_core::{Error, text};
use tetrascope_io::image::{encode_exr, encode_npy, encode_png};

use super::session::Complete;
use super::state::State;
use crate::Settings;

/// A format of images, as [`write_image`](tetrascope_io::image::write_image) writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits, sRGB.
    Png,
    /// Linear floats.
    Exr,
    /// Linear floats.
    Npy,
}

impl PictureFormat {
    /// Each with its extension and media type.
    pub const ALL: [(PictureFormat, &'static str, &'static str); 3] = [
        (PictureFormat::Png, "png", "image/png"),
        (PictureFormat::Exr, "exr", "image/x-exr"),
        (PictureFormat::Npy, "npy", "application/octet-stream"),
    ];

    /// The bytes of a file of the picture.
    pub(crate) fn encode(self, complete: &Complete) -> Result<Vec<u8>, Error> {
        let metadata = metadata(complete);
        match self {
            PictureFormat::Png => encode_png(&complete.frame, &metadata),
            PictureFormat::Exr => encode_exr(&complete.frame, &metadata),
            PictureFormat::Npy => encode_npy(&complete.frame),
        }
    }
}

/// The texts that make the picture again.
fn metadata(complete: &Complete) -> Vec<(String, String)> {
    let texts = [
        (
            "Software",
            format!("tetrascope {}", env!("CARGO_PKG_VERSION")),
        ),
        ("Algorithm", complete.setup.algorithm.name.into()),
        ("Settings", complete.setup.settings.to_string()),
        ("Mesh", complete.state.field.loaded.description.clone()),
        ("Scene", complete.state.scene.to_toml()),
    ];
    let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
    texts.map(|(key, text)| (key.into(), text)).collect()
}

/// The name of a state's files, without an extension.
pub(crate) fn stem(state: &State) -> String {
    let source = &state.scene.source;
    let file = source.file.as_deref().and_then(std::path::Path::file_stem);
    let name = match (file, &source.dataset) {
        (Some(stem), _) => stem.to_string_lossy().into_owned(),
        (None, Some(dataset)) => dataset.clone(),
        (None, None) => "picture".into(),
    };
    // For a header of HTTP and for a shell: letters and digits that need no quotes.
    let plain = |c: char| match c.is_ascii_alphanumeric() || "-_.".contains(c) {
        true => c,
        false => '_',
    };
    let name: String = name.chars().take(text::LONGEST_NAME).map(plain).collect();
    match name.trim_start_matches(['-', '.']) {
        "" => "picture".into(),
        name => name.into(),
    }
}

/// Settings that are not at their defaults, as options.
fn options(state: &State) -> String {
    let defaults = Settings::defaults(state.algorithm);
    let mut options = format!("--algorithm {}", state.algorithm.name);
    for ((name, value), (_, default)) in state.settings.iter().zip(defaults.iter()) {
        if value != default {
            let _ = write!(options, " --set {name}={value}");
        }
    }
    options
}

/// A command for a shell of Unix that draws the picture of a state as it is, with the scene in it.
pub fn command_line(state: &State) -> String {
    let toml = state.scene.to_toml();
    // A word that is no line of the scene, so that only its own ends it.
    let mut end = "SCENE".to_owned();
    while toml.lines().any(|line| line == end) {
        end.push('_');
    }
    let (options, stem) = (options(state), stem(state));
    format!(
        "tetrascope render --scene /dev/stdin {options} -o {stem}.png <<'{end}'\n{}\n{end}\n",
        toml.trim_end()
    )
}

/// The command that draws the picture from a scene file that was saved.
pub(crate) fn short_command_line(state: &State) -> String {
    let (options, stem) = (options(state), stem(state));
    format!("tetrascope render --scene {stem}.toml {options} -o {stem}.png")
}
