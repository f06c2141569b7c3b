//! The pictures that are drawn for review: every scene under every optical model by every algorithm that
//! draws it.

use tetrascope::core::{Appearance, Camera, CameraFit, Error, OpticalModel, View, Volume};
use tetrascope::datasets::{angiography, find};
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope::{Algorithm, Settings, volumes};

use crate::compare::resolve;

/// Width and height in pixels.
const SIDE: u32 = 128;

/// Data sets, and about how many cells.
const MESHES: [(&str, u64); 7] = [
    ("sphere", 3000),
    ("orbital", 3000),
    ("heat-sink", 3000),
    ("staircase", 23),
    ("torus", 3000),
    ("delaunay", 3000),
    ("graded", 3000),
];

/// Samples of the grid along each axis.
const VESSELS: [usize; 3] = [48, 48, 24];

/// Settings in place of the defaults: their pictures take the cube of the samples' number, and
/// with the defaults, 128, all of them take minutes. Drift shows in coarse ones, too.
const SETTINGS: [(&str, &str); 2] = [("resample", "samples=48"), ("voxel-hw", "voxels=48")];

/// A volume, and how and from where it is seen.
pub struct Scene {
    /// The data set's name.
    pub name: &'static str,
    /// The volume.
    pub volume: Volume,
    file: SceneFile,
}

/// One picture to be reviewed.
pub struct Picture {
    /// The name of its file, without ".png".
    pub name: String,
    /// Who draws it.
    pub algorithm: &'static Algorithm,
    /// The setting, "key=value"; empty for the defaults.
    pub setting: &'static str,
    /// The look.
    pub appearance: Appearance,
    /// The view.
    pub view: View,
}

/// All scenes.
///
/// # Errors
/// A data set cannot be made.
pub fn scenes() -> Result<Vec<Scene>, Error> {
    let mesh = |(name, cells): (&'static str, u64)| {
        let mut file = volumes::scene(find(name)?);
        file.volume = VolumeSource {
            cells: Some(cells),
            ..file.volume
        };
        let volume = volumes::load(&file.volume)?.volume;
        Ok(Scene { name, volume, file })
    };
    let mut scenes = MESHES
        .map(mesh)
        .into_iter()
        .collect::<Result<Vec<_>, Error>>()?;
    scenes.push(Scene {
        name: "angiography",
        volume: Volume::Grid(angiography(VESSELS, 1)?),
        file: SceneFile::new(VolumeSource::default()),
    });
    for scene in &mut scenes {
        (scene.file.image.width, scene.file.image.height) = (Some(SIDE), Some(SIDE));
    }
    Ok(scenes)
}

impl Scene {
    /// The pictures of this scene: what an algorithm does not draw is left out.
    ///
    /// # Errors
    /// The scene cannot be completed, or an algorithm refuses it for another reason than that
    /// it does not draw such a scene.
    pub fn pictures(&self) -> Result<Vec<Picture>, Error> {
        let mut pictures = Vec::new();
        for model in OpticalModel::ALL {
            let scene = resolve(&self.file, model, &self.volume)?;
            let view = self.reviewed(&scene.view);
            for algorithm in tetrascope::algorithms() {
                let chosen = SETTINGS.iter().find(|(name, _)| *name == algorithm.name);
                let setting = chosen.map_or("", |(_, setting)| setting);
                let settings = Settings::parse(algorithm, setting.split(','))?;
                match (algorithm.supports)(&self.volume, &scene.appearance, &view, &settings) {
                    Ok(()) => pictures.push(Picture {
                        name: format!("{}-{}-{}", self.name, model.name(), algorithm.name),
                        algorithm,
                        setting,
                        appearance: scene.appearance.clone(),
                        view,
                    }),
                    Err(Error::Unsupported { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(pictures)
    }

    /// The view of reviewed pictures: from the scene's side, around the bounding sphere, which
    /// is farther away than the default ([`Camera::frame`]).
    fn reviewed(&self, view: &View) -> View {
        let from = self.file.camera.fit.unwrap_or(CameraFit::PlusIso);
        let aspect = f64::from(view.width) / f64::from(view.height);
        View {
            camera: Camera::fit(&self.volume.bounds(), from, false, aspect),
            ..*view
        }
    }
}

/// The names of all pictures; nothing is drawn for them.
///
/// # Errors
/// As [`scenes`] and [`Scene::pictures`].
pub fn names() -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for scene in scenes()? {
        names.extend(scene.pictures()?.into_iter().map(|picture| picture.name));
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_algorithm_draws_each_model_of_something() {
        let names = names().expect("data sets are made");
        let mut once = names.clone();
        once.sort();
        once.dedup();
        assert_eq!(once.len(), names.len());
        for algorithm in tetrascope::algorithms() {
            for model in OpticalModel::ALL {
                let end = format!("-{}-{}", model.name(), algorithm.name);
                assert!(names.iter().any(|name| name.ends_with(&end)), "{end}");
            }
        }
    }
}
