//! The use of an input: all that `info`, `print-scene` and the beginning of `render` do.

use std::path::Path;

use tetrascope::core::grid::Region;
use tetrascope::core::{Error, Volume};
use tetrascope::io::{FileData, ReadOptions, read_collection, read_file};
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope::volumes;

use crate::mutate::Input;
use crate::seeds::Entry;

/// How the reading of an input ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// To a volume and a complete scene.
    Read,
    /// With an error.
    Refused,
}

/// A message is a line that a person reads.
const LONGEST_MESSAGE: usize = 6000;

/// Reads `input`, whose files lie in `folder`; `Err` says what is wrong with the error
/// that came of it.
pub(crate) fn read(input: &Input, folder: &Path) -> Result<Reading, String> {
    let Some(error) = explain(input, folder) else {
        return Ok(Reading::Read);
    };
    check_message(&error)?;
    Ok(Reading::Refused)
}

/// Refuses an error whose message or help is longer than a person reads, or holds control characters, such as a
/// line's end.
pub(crate) fn check_message(error: &Error) -> Result<(), String> {
    for text in [Some(error.to_string()), tetrascope::help(error)]
        .into_iter()
        .flatten()
    {
        if let Some(control) = text.chars().find(|c| c.is_control()) {
            return Err(format!("a message holds the character {control:?}"));
        }
        let length = text.chars().count();
        if length > LONGEST_MESSAGE {
            return Err(format!("a message of {length} characters"));
        }
    }
    Ok(())
}

/// Why `input` is refused, if it is.
pub(crate) fn explain(input: &Input, folder: &Path) -> Option<Error> {
    let path = folder.join(input.files[0].0);
    let outcome = match &input.entry {
        Entry::Volume(source) => {
            let mut source = (**source).clone();
            source.file = Some(path);
            volume(&source)
        }
        Entry::Scene => scene(&path),
        Entry::Collection => read_collection(&path).map(drop),
    };
    outcome.err()
}

fn volume(source: &VolumeSource) -> Result<(), Error> {
    let loaded = volumes::load(source)?;
    if let Volume::Mesh(mesh) = &loaded.volume {
        mesh.boundary_statistics();
    } else {
        streamed(source)?;
    }
    SceneFile::new(source.clone()).resolve(&loaded.volume)?;
    Ok(())
}

/// The same grid, left in its file as far as that can be.
fn streamed(source: &VolumeSource) -> Result<(), Error> {
    let options = ReadOptions {
        raw: source.raw_layout()?,
        stream_above: 0,
        ..ReadOptions::default()
    };
    let path = source.file.as_deref().unwrap_or(Path::new(""));
    let FileData::Grid(data) = read_file(path, &options)? else {
        return Ok(());
    };
    if let (Volume::Stream(stream), _) = data.into_volume(None)? {
        let source = stream.source();
        let corner = Region {
            low: source.lattice().dims.map(|n| n - 1),
            size: [1; 3],
        };
        source.read(corner)?;
    }
    Ok(())
}

fn scene(path: &Path) -> Result<(), Error> {
    let file = SceneFile::read(path)?;
    // Data sets are made, not read, and as large as they are asked to be.
    if file.volume.dataset.is_some() {
        return Ok(());
    }
    let loaded = volumes::load(&file.volume)?;
    file.resolve(&loaded.volume)?.to_toml();
    Ok(())
}
