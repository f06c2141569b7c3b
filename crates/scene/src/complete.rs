//! A scene with nothing left out.

use tetrascope_core::view::{BLACK, TRANSPARENT};
use tetrascope_core::{Appearance, Error, View, Volume};

use crate::subject::Subject;
use crate::{
    AppearanceSpec, CameraSpec, ImageSpec, SCENE_VERSION, SceneFile, Survey, VolumeSource,
};

/// Pixels per side unless the scene says otherwise.
const DEFAULT_SIZE: u32 = 512;

/// A complete scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The volume.
    pub source: VolumeSource,
    /// How it looks.
    pub appearance: Appearance,
    /// From where, how large and before what.
    pub view: View,
    /// The choices for everything that the scene file left out, one line each.
    pub defaults: Vec<String>,
}

impl SceneFile {
    /// Completes the scene for `volume`: a camera whose picture the volume fills, viridis
    /// over the values to tell apart, and opacity by [`default_unit_distance`](crate::default_unit_distance).
    ///
    /// # Errors
    /// [`Error::Scene`] for parts that exclude each other, [`Error::Invalid`] for values that
    /// make no sense, and for a field without a finite value where it decides something.
    pub fn resolve(&self, volume: &Volume) -> Result<Scene, Error> {
        self.resolve_for(volume)
    }

    /// Completes the scene for all volumes of a survey that was made for it, as
    /// [`SceneFile::resolve`] would for one that holds them all: their pictures have one camera
    /// and one transfer function.
    ///
    /// # Errors
    /// As [`SceneFile::resolve`].
    pub fn resolve_for_all(&self, survey: &Survey) -> Result<Scene, Error> {
        self.resolve_for(survey)
    }

    /// Whether camera and appearance leave nothing out that is chosen from the volume.
    pub fn is_complete(&self) -> bool {
        self.camera.is_complete() && self.appearance.is_complete()
    }

    fn resolve_for(&self, volume: &dyn Subject) -> Result<Scene, Error> {
        let mut defaults = Vec::new();
        let view = self.view(volume, &mut defaults)?;
        view.validate()?;
        let (_, _, forward) = view.camera.axes();
        let appearance = self.appearance.resolve(volume, forward, &mut defaults)?;
        Ok(Scene {
            source: self.volume.clone(),
            appearance,
            view,
            defaults,
        })
    }

    fn view(&self, volume: &dyn Subject, defaults: &mut Vec<String>) -> Result<View, Error> {
        let model = self.appearance.model();
        let image = &self.image;
        let (width, height) = image.size();
        let background = image.background.unwrap_or_else(|| {
            if model.only_adds_light() {
                defaults.push(format!(
                    "background: opaque black, as {} only adds light",
                    model.name()
                ));
                BLACK
            } else {
                TRANSPARENT
            }
        });
        let aspect = f64::from(width) / f64::from(height.max(1));
        let camera = self.camera.resolve(volume, aspect, defaults)?;
        Ok(View {
            camera,
            width,
            height,
            background,
        })
    }
}

impl ImageSpec {
    /// Width and height: a square where one is left out.
    pub(crate) fn size(&self) -> (u32, u32) {
        let (width, height) = (self.width, self.height);
        let [width, height] = [width.or(height), height.or(width)];
        (
            width.unwrap_or(DEFAULT_SIZE),
            height.unwrap_or(DEFAULT_SIZE),
        )
    }
}

impl Scene {
    /// The scene with nothing left out, as a scene file.
    pub fn to_file(&self) -> SceneFile {
        SceneFile {
            version: SCENE_VERSION,
            volume: self.source.clone(),
            camera: CameraSpec::of(&self.view.camera),
            image: ImageSpec {
                width: Some(self.view.width),
                height: Some(self.view.height),
                background: Some(self.view.background),
            },
            appearance: AppearanceSpec::of(&self.appearance),
        }
    }

    /// The scene as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(&self.to_file()).expect("a scene has only tables, numbers and strings")
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use tetrascope_core::glam::DVec3;
    use tetrascope_core::mesh::Association;
    use tetrascope_core::{ClipPlane, DirectionalLight, OpticalModel, Scalars, TetMesh};

    use super::*;

    fn tet() -> Volume {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: vec![1.0, 2.0, 3.0, 4.0],
        };
        Volume::Mesh(
            TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars).expect("a tet is valid"),
        )
    }

    #[test]
    fn a_volume_alone_makes_a_complete_scene_that_parses_again() {
        for model in OpticalModel::ALL {
            let mut file = SceneFile::new(VolumeSource::default());
            file.appearance.optical_model = Some(model);
            file.appearance.depth_cue = Some(0.5);
            file.appearance.clip_planes = Some(ClipPlane::of_box(&tet().bounds()).to_vec());
            file.appearance.lights = Some(vec![DirectionalLight {
                toward: DVec3::X,
                color: DVec3::ONE,
            }]);
            let scene = file.resolve(&tet()).expect("defaults suffice");
            assert!(!scene.defaults.is_empty());
            let again =
                SceneFile::parse(&scene.to_toml(), Path::new("a.toml")).expect("TOML parses");
            assert_eq!(again, scene.to_file());
            let json = serde_json::to_string(&scene.to_file()).expect("JSON writes");
            assert_eq!(
                SceneFile::parse(&json, Path::new("a.json")).expect("JSON parses"),
                scene.to_file()
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_name_that_is_not_utf_8_is_written_with_replacements() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = std::ffi::OsStr::from_bytes(b"a\xff.vtu");
        let scene = SceneFile::new(VolumeSource {
            file: Some(PathBuf::from(name)),
            ..VolumeSource::default()
        });
        let scene = scene.resolve(&tet()).expect("defaults suffice");
        assert!(scene.to_toml().contains("a\u{fffd}.vtu"));
        let json = serde_json::to_string(&scene.to_file()).expect("it is text");
        assert!(json.contains("a\u{fffd}.vtu"));
    }

    #[test]
    fn contradictions_are_refused() {
        for text in [
            "[camera]\nfit = \"+x\"\nposition = [1, 2, 3]",
            "[camera]\nview_angle = 20.0",
            "[camera]\nposition = [9.0, 0.0, 0.0]\nprojection = \"orthographic\"",
            "[camera]\nposition = [9.0, 0.0, 0.0]\nfocal_point = [9.0, 0.0, 0.0]",
            "[appearance]\nrange = [2.0, 1.0]",
            "[appearance]\nunit_distance = -1.0",
            "[appearance]\ndepth_cue = 2.0",
            "[appearance]\nambient = -1.0",
            "[appearance]\nisosurfaces = [{ value = nan }]",
            "[appearance]\nclip_planes = [{ point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 0.0] }]",
            "[image]\nwidth = 0",
        ] {
            let scene = SceneFile::parse(&format!("version = 1\n{text}"), Path::new("a.toml"))
                .expect("parses");
            assert!(scene.resolve(&tet()).is_err(), "{text}");
        }
    }
}
