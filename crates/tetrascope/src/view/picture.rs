//! The files that a person saves: images, and the command line that draws one.

use std::fmt::Write as _;

use tetrascope_core::{Error, text};
use tetrascope_io::image::{encode_exr, encode_npy, encode_png, encode_texts};

use super::shared::Complete;
use super::state::State;
use crate::Settings;
use crate::provenance::{Input, Provenance};

/// A format of images, as [`write_image`](tetrascope_io::image::write_image) writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits, sRGB.
    Png,
    /// Linear floats.
    Exr,
    /// Linear floats.
    Npy,
    /// The texts beside an NPY file, which has no room for them.
    NpyTexts,
}

impl PictureFormat {
    /// Each with its extension and media type.
    pub const ALL: [(PictureFormat, &'static str, &'static str); 4] = [
        (PictureFormat::Png, "png", "image/png"),
        (PictureFormat::Exr, "exr", "image/x-exr"),
        (PictureFormat::Npy, "npy", "application/octet-stream"),
        (PictureFormat::NpyTexts, "npy.json", "application/json"),
    ];

    /// The bytes of a file of the picture.
    pub(crate) fn encode(self, complete: &Complete) -> Result<Vec<u8>, Error> {
        let frame = &complete.frame;
        match self {
            PictureFormat::Png => encode_png(frame, &texts(complete)?),
            PictureFormat::Exr => encode_exr(frame, &texts(complete)?),
            PictureFormat::Npy => encode_npy(frame),
            PictureFormat::NpyTexts => Ok(encode_texts(&texts(complete)?)),
        }
    }
}

/// The texts that `tetrascope render` writes, too.
fn texts(complete: &Complete) -> Result<Vec<(String, String)>, Error> {
    let loaded = &complete.state.field.loaded;
    let provenance = Provenance {
        algorithm: complete.setup.algorithm,
        settings: &complete.setup.settings,
        adapter: complete.adapter.as_deref(),
        loaded,
        inputs: &Input::all_of(loaded)?,
        scene: &complete.state.scene,
    };
    Ok(provenance.texts(&complete.frame))
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
