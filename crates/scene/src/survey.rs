//! One scene for several volumes, such as the steps of a series.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Bounds, Camera, CameraFit, Framing, Volume};

use crate::SceneFile;
use crate::distribution::Distribution;
use crate::subject::Subject;

/// The facts from which defaults of a scene are chosen, gathered from volume after volume as if they were
/// one: see [`SceneFile::resolve_for_all`]. It does not grow with the volumes.
#[derive(Clone, Debug)]
pub struct Survey {
    /// One for each side from which the scene may look.
    framings: Vec<Framing>,
    needs_values: bool,
    volumes: usize,
    bounds: Bounds,
    /// The axes of all volumes' boxes, if they are the same.
    box_axes: Option<[DVec3; 3]>,
    cell_count: usize,
    /// The volume that cells fill: of each volume, the part of its box that they fill, times its box; the greatest, over
    /// the box around all.
    filled: f64,
    scalar_range: Option<(f64, f64)>,
    distribution: Distribution,
}

impl Survey {
    /// A survey of no volume yet, for a scene.
    pub fn new(scene: &SceneFile) -> Survey {
        let (width, height) = scene.image.size();
        let aspect = f64::from(width) / f64::from(height.max(1));
        let sides = CameraFit::ALL.into_iter().map(|(_, fit)| fit);
        let framings = sides
            .filter(|fit| scene.camera.may_look_from(*fit))
            .map(|fit| Framing::new(fit, aspect));
        Survey {
            framings: framings.collect(),
            needs_values: scene.appearance.needs_values(),
            volumes: 0,
            bounds: Bounds::EMPTY,
            box_axes: None,
            cell_count: 0,
            filled: 0.0,
            scalar_range: None,
            distribution: Distribution::empty(),
        }
    }

    /// Adds a volume.
    pub fn add(&mut self, volume: &Volume) {
        for point in volume.outline() {
            for framing in &mut self.framings {
                framing.extend([point]);
            }
        }
        let own = volume.bounds();
        let all = Bounds {
            min: self.bounds.min.min(own.min),
            max: self.bounds.max.max(own.max),
        };
        let axes = volume.box_axes();
        self.box_axes = match self.volumes {
            0 => Some(axes),
            _ => self.box_axes.filter(|others| *others == axes),
        };
        // Of a grid that is turned, the box that it fills is not that along the axes.
        let before = self.filled * part(self.bounds.size(), all.size());
        let here = Subject::filled(volume) * part(own.size(), all.size());
        self.filled = before.max(here); // `max` passes over NaN
        self.bounds = all;
        self.cell_count = self.cell_count.max(volume.cell_count());
        if let Some((low, high)) = volume.scalar_range() {
            let (least, greatest) = self.scalar_range.unwrap_or((low, high));
            self.scalar_range = Some((least.min(low), greatest.max(high)));
        }
        if self.needs_values {
            self.distribution.add(Distribution::of(volume));
        }
        self.volumes += 1;
    }

    /// How many volumes were added.
    pub fn volumes(&self) -> usize {
        self.volumes
    }

    /// The box around all volumes.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The least and greatest finite scalar of all volumes, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        self.scalar_range
    }
}

impl Subject for Survey {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn box_axes(&self) -> [DVec3; 3] {
        self.box_axes.unwrap_or_else(|| {
            let size = self.bounds.size();
            [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z]
        })
    }

    fn cell_count(&self) -> usize {
        self.cell_count
    }

    fn filled(&self) -> f64 {
        self.filled
    }

    fn scalar_range(&self) -> Option<(f64, f64)> {
        self.scalar_range
    }

    fn distribution(&self) -> Distribution {
        self.distribution.clone()
    }

    fn framed(&self, from: CameraFit, orthographic: bool, _: f64) -> Camera {
        let framing = self.framings.iter().find(|f| f.from() == from);
        let framing = framing.expect("the scene's camera may look from this side");
        framing.camera(orthographic)
    }
}

/// The part that a box of size `inner` is of one of size `outer`.
fn part(inner: DVec3, outer: DVec3) -> f64 {
    let [x, y, z] = (inner / outer).to_array();
    x * y * z
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DMat3;
    use tetrascope_core::grid::Samples;
    use tetrascope_core::mesh::Association;
    use tetrascope_core::{Grid, OpticalModel, Scalars, TetMesh};

    use super::*;
    use crate::VolumeSource;

    /// Two tetrahedra that fill a part of a box of this height.
    fn mesh(height: f64, values: [f64; 5]) -> Volume {
        let points = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::Z * height,
            DVec3::ONE,
        ];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: values.to_vec(),
        };
        let cells = vec![[0, 1, 2, 3], [1, 2, 3, 4]];
        let mesh = TetMesh::from_tetrahedra(points.to_vec(), cells, scalars);
        Volume::Mesh(mesh.expect("a mesh"))
    }

    fn grid(origin: DVec3, values: impl Fn(usize) -> f32) -> Volume {
        let samples = Samples::F32((0..1000).map(values).collect());
        let grid = Grid::new([10; 3], origin, DVec3::ONE, DMat3::IDENTITY, samples);
        Volume::Grid(grid.expect("a grid"))
    }

    fn survey(scene: &SceneFile, volumes: &[&Volume]) -> Survey {
        let mut survey = Survey::new(scene);
        volumes.iter().for_each(|volume| survey.add(volume));
        assert_eq!(survey.volumes(), volumes.len());
        survey
    }

    #[test]
    fn of_one_volume_the_scene_is_its_own() {
        let volumes = [
            mesh(2.0, [0.0, 1.0, 2.0, 3.0, 4.0]),
            mesh(1e-9, [0.0; 5]),
            grid(DVec3::splat(1e6), |i| if i < 900 { 7.0 } else { i as f32 }),
        ];
        for volume in &volumes {
            for model in OpticalModel::ALL {
                let mut scene = SceneFile::new(VolumeSource::default());
                scene.appearance.optical_model = Some(model);
                (scene.image.width, scene.image.height) = (Some(30), Some(20));
                let own = scene.resolve(volume).expect("a scene");
                let survey = survey(&scene, &[volume, volume]);
                let common = scene.resolve_for_all(&survey).expect("a scene");
                assert_eq!(own.view, common.view);
                assert_eq!(own.appearance, common.appearance);
            }
        }
    }

    #[test]
    fn of_several_volumes_the_scene_holds_all() {
        let scene = SceneFile::new(VolumeSource::default());
        let volumes = [
            grid(DVec3::ZERO, |i| i as f32),
            grid(DVec3::X * 20.0, |i| 500.0 + i as f32),
        ];
        let survey = survey(&scene, &[&volumes[0], &volumes[1]]);
        let common = scene.resolve_for_all(&survey).expect("a scene");
        let function = &common.appearance.transfer_function;
        assert_eq!(function.range(), (0.0, 1499.0));
        assert_eq!(survey.scalar_range(), Some((0.0, 1499.0)));
        let corners = volumes.iter().flat_map(|volume| volume.outline());
        let camera = Camera::frame(corners, CameraFit::PlusIso, false, 1.0);
        assert_eq!(common.view.camera, camera);
        assert_eq!(survey.bounds().max.x, 29.0);
        // Background is what fills most of all of them, not of each.
        let air = |share: usize| {
            grid(
                DVec3::ZERO,
                move |i| if i < share { 50.0 } else { (i % 100) as f32 },
            )
        };
        let (empty, full) = (air(900), air(0));
        let lines = |volumes: &[&Volume]| {
            let survey = self::survey(&scene, volumes);
            scene
                .resolve_for_all(&survey)
                .expect("a scene")
                .defaults
                .join("\n")
        };
        assert!(
            lines(&[&empty]).contains("opacity: 0 at 50"),
            "{}",
            lines(&[&empty])
        );
        assert!(!lines(&[&empty, &full]).contains("opacity: 0"));
        assert!(
            lines(&[&empty, &full, &empty]).contains("which fills 60 %"),
            "{}",
            lines(&[&empty, &full, &empty])
        );
    }

    #[test]
    fn a_scene_says_what_it_needs() {
        let volume = mesh(2.0, [0.0, 1.0, 2.0, 3.0, 4.0]);
        let mut scene = SceneFile::new(VolumeSource::default());
        for model in OpticalModel::ALL {
            scene.appearance.optical_model = Some(model);
            assert!(!scene.is_complete() && scene.appearance.needs_values());
            let complete = scene.resolve(&volume).expect("a scene").to_file();
            assert!(complete.is_complete(), "{model:?}");
            let mut open = complete.clone();
            open.camera.focal_point = None;
            assert!(!open.is_complete() && !open.appearance.needs_values());
            open.appearance.isosurfaces = None;
            let needs = model == OpticalModel::Isosurfaces;
            assert_eq!(open.appearance.needs_values(), needs);
        }
    }

    // Values that differ in each volume: what is kept of them stays bounded, and so do the
    // first and the last.
    #[test]
    fn what_is_kept_of_values_is_bounded() {
        use tetrascope_core::pick::MOST_PICKED;
        let scene = SceneFile::new(VolumeSource::default());
        let mut survey = Survey::new(&scene);
        let side = 100;
        for step in 0..3 {
            let value = |i: usize| (i * 3 + step) as f32 - 1e6;
            let samples = Samples::F32((0..side * side * side).map(value).collect());
            let dims = [side; 3];
            let grid = Grid::new(dims, DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
            survey.add(&Volume::Grid(grid.expect("a grid")));
        }
        let kept = survey.distribution.len();
        assert!(kept <= MOST_PICKED && kept > MOST_PICKED / 4, "{kept}");
        let common = scene.resolve_for_all(&survey).expect("a scene");
        assert_eq!(
            common.appearance.transfer_function.range(),
            (-1e6, 2e6 - 1.0)
        );
    }
}
