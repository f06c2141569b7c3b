//! From names and files to what is drawn.

use std::path::Path;

use tetrascope::Algorithm;
use tetrascope::core::{Error, Knot, OpticalModel, TransferFunction, Volume};
use tetrascope::scene::{Scene, SceneFile, VolumeSource};
use tetrascope::volumes;

use super::Options;

/// The scenes that are drawn when nothing is named: a convex mesh, one with notches and a grid.
const DEFAULT_SCENES: [&str; 3] = ["sphere", "heat-sink", "angiography"];

/// Pixels per side and cells of a data set where all bounds are checked quickly: cells are a few pixels
/// wide, and a mesh has several hundred at its border.
const CHECKED: (u32, u64) = (96, 3000);

/// The scene that is drawn in parallel, too, when nothing is named: some settings draw nothing else.
const DEFAULT_PARALLEL: (&str, OpticalModel) = ("sphere", OpticalModel::Emission);

/// Pixels per side unless the scene or `--size` says otherwise: enough to see what is
/// wrong.
const DEFAULT_SIDE: u32 = 256;

/// The optical depth across the whole volume at its greatest extinction when a
/// scene made for another model is drawn in `emission`: light adds up unhidden
/// there, and beyond about 4 most of the picture would be white.
const EMISSION_DEPTH: f64 = 4.0;

/// All that a run draws.
pub(super) struct Plan {
    pub(super) scenes: Vec<PlannedScene>,
    /// The truth first.
    pub(super) algorithms: Vec<&'static Algorithm>,
    pub(super) repeat: u32,
}

/// A scene and the optical models under which it is drawn.
pub(super) struct PlannedScene {
    pub(super) name: String,
    pub(super) file: SceneFile,
    pub(super) models: Vec<OpticalModel>,
    /// Whether in parallel projection, whatever the file says.
    pub(super) orthographic: bool,
}

/// Finds everything that the options name, before anything is drawn.
pub(super) fn plan(options: &Options) -> Result<Plan, Error> {
    let size = match options.check {
        true => Some((CHECKED.0, CHECKED.0)),
        false => options.size.as_deref().map(parse_size).transpose()?,
    };
    let models = options
        .models
        .iter()
        .map(|name| parse_model(name))
        .collect::<Result<Vec<_>, _>>()?;
    let names: Vec<&str> = match options.scenes.is_empty() {
        true => DEFAULT_SCENES.to_vec(),
        false => options.scenes.iter().map(String::as_str).collect(),
    };
    let mut scenes = Vec::new();
    for name in &names {
        let mut scene = find(name, options.field.as_deref())?;
        if !models.is_empty() {
            scene.models.clone_from(&models);
        }
        if options.orthographic {
            in_parallel(&mut scene);
        }
        scenes.push(scene);
    }
    let (name, model) = DEFAULT_PARALLEL;
    if options.scenes.is_empty()
        && !options.orthographic
        && (models.is_empty() || models.contains(&model))
    {
        let mut scene = find(name, None)?;
        scene.models = vec![model];
        in_parallel(&mut scene);
        scenes.push(scene);
    }
    for scene in &mut scenes {
        let volume = &mut scene.file.volume;
        if options.check && volume.dataset.is_some() && volume.cells.is_none() {
            volume.cells = Some(CHECKED.1);
        }
        let image = &mut scene.file.image;
        if let Some((width, height)) = size {
            (image.width, image.height) = (Some(width), Some(height));
        } else if image.width.is_none() && image.height.is_none() {
            (image.width, image.height) = (Some(DEFAULT_SIDE), Some(DEFAULT_SIDE));
        }
    }
    let mut algorithms = Vec::from_iter(tetrascope::truth());
    let chosen: Vec<&'static Algorithm> = match options.algorithms.is_empty() {
        true => tetrascope::algorithms().iter().collect(),
        false => {
            let found = options
                .algorithms
                .iter()
                .map(|name| tetrascope::algorithm(name));
            found.collect::<Result<_, _>>()?
        }
    };
    algorithms.extend(chosen.into_iter().filter(|a| !a.is_truth()));
    Ok(Plan {
        scenes,
        algorithms,
        repeat: if options.check { 1 } else { options.repeat },
    })
}

fn in_parallel(scene: &mut PlannedScene) {
    scene.orthographic = true;
    scene.name.push_str(", parallel");
}

/// A scene file, a mesh file or a data set.
fn find(name: &str, field: Option<&str>) -> Result<PlannedScene, Error> {
    let path = Path::new(name);
    let extension = path
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    if matches!(extension, "toml" | "json") {
        let text = std::fs::read_to_string(path).map_err(|source| Error::Io {
            action: "cannot read",
            path: path.into(),
            source,
        })?;
        let file = SceneFile::parse(&text, path)?;
        let model = file
            .appearance
            .optical_model
            .unwrap_or(OpticalModel::EmissionAbsorption);
        let name = path
            .file_stem()
            .map_or(name.into(), |stem| stem.to_string_lossy().into_owned());
        return Ok(PlannedScene {
            name,
            file,
            models: vec![model],
            orthographic: false,
        });
    }
    if path.is_file() {
        let file = SceneFile::new(VolumeSource {
            file: Some(path.into()),
            field: field.map(String::from),
            ..VolumeSource::default()
        });
        let name = path
            .file_name()
            .map_or(name.into(), |name| name.to_string_lossy().into_owned());
        return Ok(PlannedScene {
            name,
            file,
            models: vec![OpticalModel::EmissionAbsorption],
            orthographic: false,
        });
    }
    if path.components().count() > 1 || !extension.is_empty() {
        // It looks like a file, so that is what to complain about.
        let source = std::fs::metadata(path)
            .err()
            .unwrap_or_else(|| std::io::ErrorKind::IsADirectory.into());
        return Err(Error::Io {
            action: "cannot open",
            path: path.into(),
            source,
        });
    }
    let dataset = tetrascope::datasets::find(name)?;
    Ok(PlannedScene {
        name: name.into(),
        file: volumes::scene(dataset),
        models: OpticalModel::ALL.to_vec(),
        orthographic: false,
    })
}

/// Completes a scene under `model`, which may be another than the scene's own.
///
/// In `Emission`, a transfer function made for another model has its extinction
/// scaled down so that the picture does not burn out; `defaults` says so.
pub fn resolve(file: &SceneFile, model: OpticalModel, volume: &Volume) -> Result<Scene, Error> {
    let own = file
        .appearance
        .optical_model
        .unwrap_or(OpticalModel::EmissionAbsorption);
    let mut file = file.clone();
    file.appearance.optical_model = Some(model);
    let mut scene = file.resolve(volume)?;
    let has_knots = file.appearance.transfer_function.is_some();
    if model == OpticalModel::Emission && own != model && has_knots {
        dim(&mut scene, volume)?;
    }
    Ok(scene)
}

/// Scales extinction down to [`EMISSION_DEPTH`] where it is above.
fn dim(scene: &mut Scene, volume: &Volume) -> Result<(), Error> {
    let function = &scene.appearance.transfer_function;
    let (low, high) = volume.scalar_range().unwrap_or(function.range());
    let depth = function.max_extinction(low, high) * volume.bounds().diagonal();
    if depth <= EMISSION_DEPTH {
        return Ok(());
    }
    let factor = EMISSION_DEPTH / depth;
    let knots = function.knots().iter().map(|knot| Knot {
        extinction: knot.extinction * factor,
        ..*knot
    });
    scene.appearance.transfer_function = TransferFunction::new(knots.collect())?;
    let line =
        format!("extinction: times {factor:.3e}, as unhidden light would burn the picture out");
    scene.defaults.push(line);
    Ok(())
}

fn parse_size(text: &str) -> Result<(u32, u32), Error> {
    let sides = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| Error::Scene {
        at: "--size".into(),
        what: format!("'{text}' is no size"),
        help: Some("write it like 256x256".into()),
    })
}

fn parse_model(name: &str) -> Result<OpticalModel, Error> {
    let found = OpticalModel::ALL
        .into_iter()
        .find(|model| model.name() == name);
    found.ok_or_else(|| Error::Unknown {
        kind: "optical model",
        name: name.into(),
        valid: OpticalModel::ALL.map(|model| model.name().into()).to_vec(),
    })
}
