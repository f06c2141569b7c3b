//! The scene that options and scene file ask for.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use tetrascope_core::appearance::MAX_CLIP_PLANES;
use tetrascope_core::{Error, OpticalModel, Volume};
use tetrascope_scene::{
    CameraSpec, IsosurfaceSpec, ProjectionKind, Scene, SceneFile, VolumeSource, nearest,
};

use super::{Output, SceneArgs, SourceArgs, VolumeArgs};
use crate::datasets;
use crate::volumes::{self, Loaded};

/// A scene that is asked for, before its volume is there.
#[derive(Clone)]
pub struct Request {
    /// The scene file or that of the data set, changed by the options.
    pub file: SceneFile,
    /// The scene file, if there is one: errors name it.
    origin: Option<PathBuf>,
    /// The parts that options replaced, one line each.
    notes: Vec<String>,
}

impl Request {
    /// Reads the scene file, if any, and applies the options and the `volume` that is named
    /// beside it.
    pub fn new(args: &SceneArgs, volume: Option<&PathBuf>) -> Result<Request, Error> {
        Request::of(args, volume, args.scene.as_deref())
    }

    /// The same for another scene file, or none.
    pub fn of(
        args: &SceneArgs,
        volume: Option<&PathBuf>,
        scene: Option<&Path>,
    ) -> Result<Request, Error> {
        let mut request = Request {
            file: SceneFile::new(VolumeSource::default()),
            origin: scene.map(Path::to_owned),
            notes: Vec::new(),
        };
        if let Some(path) = scene {
            request.file = SceneFile::read(path)?;
        }
        let given = source(volume.map(PathBuf::as_path), &args.options)?;
        if given.file.is_some() || given.dataset.is_some() {
            match (&given.dataset, scene) {
                (Some(name), None) => request.file = volumes::scene(datasets::find(name)?),
                _ => {
                    // Another volume in the scene's look; a field of that name is still meant.
                    let field = request.file.volume.field.take();
                    request.file.volume = VolumeSource {
                        field,
                        ..VolumeSource::default()
                    };
                }
            }
        }
        merge(&mut request.file.volume, given);
        request.apply(args);
        if args.clip.len() > MAX_CLIP_PLANES {
            return Err(Error::Usage {
                what: format!("{} clip planes", args.clip.len()),
                help: Some(format!("give at most {MAX_CLIP_PLANES}")),
            });
        }
        volumes::check(&request.file.volume).map_err(|error| request.place(error))?;
        Ok(request)
    }

    /// The options that change the picture.
    fn apply(&mut self, args: &SceneArgs) {
        let scene = &mut self.file;
        if let Some((width, height)) = args.size {
            (scene.image.width, scene.image.height) = (Some(width), Some(height));
        }
        if args.background.is_some() {
            scene.image.background = args.background;
        }
        if args.camera.is_some() {
            scene.camera = CameraSpec {
                fit: args.camera,
                ..CameraSpec::default()
            };
        }
        if args.orthographic {
            scene.camera.projection = Some(ProjectionKind::Orthographic);
        }
        if args.model.is_some() {
            scene.appearance.optical_model = args.model;
        }
        let restyled =
            args.colormap.is_some() || args.range.is_some() || args.unit_distance.is_some();
        if restyled && scene.appearance.transfer_function.take().is_some() {
            self.notes
                .push("a color map replaces the scene's transfer function".into());
        }
        let look = &mut scene.appearance;
        if !args.isovalue.is_empty() {
            look.optical_model = args.model.or(Some(OpticalModel::Isosurfaces));
            let surface = |&value: &f64| IsosurfaceSpec { value, color: None };
            look.isosurfaces = Some(args.isovalue.iter().map(surface).collect());
        }
        look.depth_cue = args.depth_cue.or(look.depth_cue);
        if !args.clip.is_empty() {
            look.clip_planes = Some(args.clip.clone());
        }
        look.colormap = args.colormap.or(look.colormap);
        look.range = args.range.or(look.range);
        look.unit_distance = args.unit_distance.or(look.unit_distance);
    }

    /// Loads the volume; prints what was found out. Gives the seconds too.
    pub fn load(&self, output: &Output) -> Result<(Loaded, f64), Error> {
        let source = &self.file.volume;
        let (loaded, seconds) = output
            .timed(&format!("loading {}", name(source)), || {
                volumes::load(source)
            })
            .map_err(|error| match (error, &source.dataset) {
                // A data set is made as it is asked for.
                (error, Some(_)) => self.place(error),
                (error, None) => self.in_scene(error),
            })?;
        output.note(format_args!("  {}", loaded.description));
        for note in &loaded.notes {
            output.note(format_args!("  {note}"));
        }
        Ok((loaded, seconds))
    }

    /// Completes the scene for `volume`; prints what was chosen.
    pub fn resolve(&self, volume: &Volume, output: &Output) -> Result<Scene, Error> {
        let scene = self.complete(self.file.resolve(volume))?;
        for line in &scene.defaults {
            output.note(format_args!("  {line}"));
        }
        Ok(scene)
    }

    /// The outcome of completing this scene, in words of the command line.
    pub fn complete(&self, scene: Result<Scene, Error>) -> Result<Scene, Error> {
        let mut scene = scene.map_err(|error| self.in_scene(error))?;
        for line in &mut scene.defaults {
            *line = with_option(line);
        }
        scene.defaults.splice(0..0, self.notes.iter().cloned());
        Ok(scene)
    }

    /// A result that comes from what is asked for, in words of the command line.
    pub fn in_words<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        result.map_err(|error| self.in_scene(error))
    }

    /// The picture's name unless the user says: the scene's, the file's or
    /// the data set's name, without folder and extension.
    pub fn stem(&self) -> OsString {
        let source = &self.file.volume;
        let file = self.origin.as_deref().or(source.file.as_deref());
        match (file.and_then(Path::file_stem), &source.dataset) {
            (Some(stem), _) => stem.to_owned(),
            (None, Some(dataset)) => dataset.into(),
            (None, None) => "picture".into(),
        }
    }

    /// An error in what is asked for: without a scene file, on the command line.
    fn place(&self, error: Error) -> Error {
        match self.origin {
            None => usage(error),
            Some(_) => self.in_scene(error),
        }
    }

    /// Adds the scene file to an error that comes from what it says.
    fn in_scene(&self, error: Error) -> Error {
        let Some(path) = &self.origin else {
            return error;
        };
        let file = path.display().to_string();
        let help = crate::help(&error);
        match error {
            Error::Invalid { what, help } => Error::Scene {
                at: file,
                what,
                help,
            },
            Error::Scene { at, what, help } => Error::Scene {
                at: format!("{at} of {file}"),
                what,
                help,
            },
            // A wrong name is wrong usage on the command line, but wrong input here.
            Error::Unknown { .. } => Error::Scene {
                at: file,
                what: error.to_string(),
                help,
            },
            other => other,
        }
    }
}

/// An error in what the command line says.
pub fn usage(error: Error) -> Error {
    match error {
        Error::Invalid { what, help } => Error::Usage { what, help },
        other => other,
    }
}

/// The choice, with the option that chooses otherwise.
fn with_option(line: &str) -> String {
    let option = match line.split_once(':').map_or(line, |(what, _)| what) {
        "background" => "--background changes it",
        "camera" => "--camera changes it",
        "colormap" => "--colormap changes it",
        "isosurface" => "--isovalue changes it",
        "opacity" => "with --range it rises from the low to the high end",
        "range" => "--range changes it",
        "unit distance" => "--unit-distance changes it",
        _ => return line.into(),
    };
    format!("{line} ({option})")
}

/// The volume that the command line names, without a scene.
pub fn source(volume: Option<&Path>, args: &VolumeArgs) -> Result<VolumeSource, Error> {
    let grid = &args.grid;
    Ok(VolumeSource {
        interpolation: grid.interpolation,
        dims: grid.dims,
        number: grid.number,
        spacing: grid.spacing,
        origin: grid.origin,
        offset: grid.offset,
        byte_order: grid.byte_order,
        ..mesh_source(volume, &args.source)?
    })
}

/// The same where grids are not meant.
pub fn mesh_source(volume: Option<&Path>, args: &SourceArgs) -> Result<VolumeSource, Error> {
    let mut source = VolumeSource {
        solution: args.solution.clone(),
        cells: args.cells,
        seed: args.seed,
        field: args.field.clone(),
        step: args.step,
        time: args.time,
        curved: args.curved,
        ..VolumeSource::default()
    };
    if let Some(volume) = volume {
        let named = self::volume(volume)?;
        (source.file, source.dataset) = (named.file, named.dataset);
    }
    Ok(source)
}

/// The file or data set that a word on the command line names.
pub fn volume(volume: &Path) -> Result<VolumeSource, Error> {
    let mut source = VolumeSource::default();
    let name = volume.to_string_lossy();
    let names: Vec<&str> = datasets::all().iter().map(|dataset| dataset.name).collect();
    // A name with a folder or an extension means a file, so that opening it says what
    // is wrong; so does a file that happens to be called like a data set.
    let is_path = volume.components().count() > 1 || volume.extension().is_some();
    if volume.exists() || is_path {
        source.file = Some(volume.to_owned());
    } else if names.contains(&name.as_ref()) {
        source.dataset = Some(name.into_owned());
    } else {
        let help = match nearest(&name, &names) {
            Some(near) => format!("did you mean '{near}'?"),
            None => {
                "give the path of a file with a mesh or a grid, or one of these data sets".into()
            }
        };
        return Err(Error::Invalid {
            what: format!("'{name}' is neither a file nor a data set"),
            help: Some(format!("{help} (data sets: {})", names.join(", "))),
        });
    }
    Ok(source)
}

/// Puts what `given` says over `source`.
fn merge(source: &mut VolumeSource, given: VolumeSource) {
    source.file = given.file.or(source.file.take());
    source.dataset = given.dataset.or(source.dataset.take());
    source.solution = given.solution.or(source.solution.take());
    source.field = given.field.or(source.field.take());
    if given.step.is_some() || given.time.is_some() {
        (source.step, source.time) = (given.step, given.time);
    }
    source.curved = given.curved.or(source.curved);
    source.interpolation = given.interpolation.or(source.interpolation);
    source.cells = given.cells.or(source.cells);
    source.seed = given.seed.or(source.seed);
    source.dims = given.dims.or(source.dims);
    source.number = given.number.or(source.number);
    source.spacing = given.spacing.or(source.spacing);
    source.origin = given.origin.or(source.origin);
    source.offset = given.offset.or(source.offset);
    source.byte_order = given.byte_order.or(source.byte_order);
}

/// The file or the data set of a source, in words.
pub fn name(source: &VolumeSource) -> String {
    match (&source.file, &source.dataset) {
        (Some(file), _) => file.display().to_string(),
        (None, Some(dataset)) => format!("data set {dataset}"),
        (None, None) => "nothing".into(),
    }
}
