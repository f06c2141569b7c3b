//! The defaults of a first picture: a side to look from, a range, an opacity.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::DVec3;
use tetrascope_core::transfer_function::{MAX_OPACITY, OpacityRamp};
use tetrascope_core::{CameraFit, Error, OpticalModel, Volume, number};

use crate::subject::Subject;

/// A picture in which the volume's box covers less of the square around it than this is a
/// thin line: a box 60 times as long as wide, seen from (1, 1, 1).
const LINE: f64 = 0.03;

/// The side from which a volume is seen, and the reason unless it is the usual one.
///
/// That is (1, 1, 1); but where the volume would be a line, because it is a needle or a
/// plate seen on edge, the side on which its box fills most of a square.
pub fn default_side(volume: &Volume) -> (CameraFit, Option<&'static str>) {
    side_of(volume)
}

pub(crate) fn side_of(volume: &dyn Subject) -> (CameraFit, Option<&'static str>) {
    let filled = |fit: CameraFit| filled(&volume.box_axes(), fit);
    let usual = CameraFit::PlusIso;
    let is_line = filled(usual) < LINE; // not if it is NaN, as of a volume without extent
    if !is_line {
        return (usual, None);
    }
    let mut best = usual;
    for (_, fit) in CameraFit::ALL {
        if filled(fit) > filled(best) {
            best = fit;
        }
    }
    if best == usual {
        return (usual, None);
    }
    let why = "in parallel, as from elsewhere the volume is a thin line";
    (best, Some(why))
}

/// The part of the square around its picture that the box with the edges `axes` covers,
/// seen in parallel.
fn filled(axes: &[DVec3; 3], fit: CameraFit) -> f64 {
    let (toward_eye, view_up) = fit.axes();
    let right = view_up.cross(toward_eye).unit();
    let up = toward_eye.cross(right);
    let extent = |along: DVec3| axes.iter().map(|axis| axis.dot(along).abs()).sum::<f64>();
    let side = extent(right).max(extent(up));
    // Lengths relative to the side, as squares of lengths could overflow.
    let axes = axes.map(|axis| axis / side);
    shadow(&axes, toward_eye).iter().sum()
}

/// The areas of the shadows of a box's three pairs of faces: a light from afar along the
/// unit vector `direction` shows one of each pair.
fn shadow(&[a, b, c]: &[DVec3; 3], direction: DVec3) -> [f64; 3] {
    [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(direction).abs())
}

/// Lengths of parallel rays along `forward` in the volume.
struct Chords {
    /// The mean, over the shadow of the volume's box: its cells' volume over that area.
    mean: f64,
    /// The longest one in the volume's box.
    longest: f64,
}

/// `None` for a volume without extent in some direction.
fn chords(volume: &dyn Subject, forward: DVec3) -> Option<Chords> {
    let axes = volume.box_axes();
    let size = axes.iter().map(|a| a.length()).fold(0.0, f64::max);
    let axes = axes.map(|axis| axis / size);
    let content = axes[0].dot(axes[1].cross(axes[2])).abs();
    let areas = shadow(&axes, forward);
    // A ray along the box's diagonal leaves by the face that it is steepest to.
    let longest = content / areas.iter().copied().fold(0.0, f64::max);
    let mean = content / areas.iter().sum::<f64>() * volume.filled().min(1.0);
    let chords = Chords {
        mean: mean * size,
        longest: longest * size,
    };
    let usable = |length: f64| length > 0.0 && length.is_finite();
    (usable(chords.mean) && usable(chords.longest)).then_some(chords)
}

/// A distance over which the default opacity counts, world units, and the reason; the
/// camera looks along the unit vector `forward`.
///
/// ParaView's rule, diagonal / ∛(cells), makes one cell of full opacity opaque. In a thin
/// volume no ray goes as far as that; there it is the mean length of rays in the volume, so
/// that an opacity is that of the whole volume. Models without hiding add up over the whole
/// depth instead, so there the length of the longest ray keeps the picture from burning out.
pub fn default_unit_distance(
    volume: &Volume,
    model: OpticalModel,
    forward: DVec3,
) -> (f64, &'static str) {
    unit_distance_of(volume, model, forward)
}

pub(crate) fn unit_distance_of(
    volume: &dyn Subject,
    model: OpticalModel,
    forward: DVec3,
) -> (f64, &'static str) {
    let diagonal = volume.bounds().diagonal();
    let chords = chords(volume, forward);
    let (distance, why) = if model == OpticalModel::EmissionAbsorption {
        let cells = volume.cell_count().max(1) as f64;
        let cell = diagonal / cells.cbrt();
        match chords {
            Some(Chords { mean, .. }) if mean < cell => {
                (mean, "the mean length of rays in the volume")
            }
            _ => (
                cell,
                "the bounding box's diagonal over the cube root of the cell count",
            ),
        }
    } else {
        match chords {
            Some(Chords { longest, .. }) if longest < diagonal => {
                (longest, "the length of the longest ray in the volume's box")
            }
            _ => (diagonal, "the bounding box's diagonal"),
        }
    };
    if distance > 0.0 {
        (distance, why)
    } else {
        (1.0, "as the volume has no extent")
    }
}

/// A ray through the volume shall have this optical depth in the mean: that of a picture
/// that is 5 % opaque, or a twentieth of which is hidden half and more.
const LEAST_DEPTH: f64 = 0.05;

/// The range and opacity that the field's values suggest.
pub(crate) struct Suggestion {
    /// The range of a color map and how opacity rises in it.
    pub(crate) ramp: OpacityRamp,
    /// The choices in words, one line each.
    pub(crate) lines: Vec<String>,
    /// The unit distance with which a ray has [`LEAST_DEPTH`] in the mean; no default is
    /// longer.
    pub(crate) longest_unit: f64,
}

/// The range and opacity chosen by the field's values, for a camera that looks along `forward`.
pub(crate) fn default_ramp(volume: &dyn Subject, forward: DVec3) -> Result<Suggestion, Error> {
    let full = full_range(volume)?;
    let (unit, _) = unit_distance_of(volume, OpticalModel::EmissionAbsorption, forward);
    let mean_chord = chords(volume, forward).map_or(unit, |chords| chords.mean);
    let distribution = volume.distribution();
    let choice = distribution.choose(mean_chord / unit);
    let choice = choice.ok_or_else(no_finite_value)?;
    let ramp = OpacityRamp {
        range: choice.range,
        background: choice.background.map(|(band, _)| band),
        clear_below: choice.clear_below,
        clear_above: choice.clear_above,
    };
    let range = number::range(ramp.range);
    let mut lines = vec![match &choice.left_out {
        None => format!("range: {range}, the field's"),
        Some(left_out) => {
            let clear = match (ramp.clear_below, ramp.clear_above) {
                (false, false) => "",
                (true, false) => ", and what is below is clear",
                (false, true) => ", and what is above is clear",
                (true, true) => ", and what is beyond is clear",
            };
            format!(
                "range: {range}, without {left_out}: the field's is {}{clear}",
                number::range(full)
            )
        }
    }];
    if let Some(((from, to), filled)) = choice.background {
        let values = match from < to {
            true => format!("{} to {}", number::rounded(from), number::rounded(to)),
            false => number::exact(from),
        };
        lines.push(format!(
            "opacity: 0 at {values}, which fills {:.0} % of the volume, and rising away from it",
            100.0 * filled
        ));
    }
    let depth = |scalar| -(-ramp.opacity(scalar).min(MAX_OPACITY)).ln_1p();
    Ok(Suggestion {
        ramp,
        lines,
        longest_unit: distribution.mean(depth) * mean_chord / LEAST_DEPTH,
    })
}

/// The middle of the range; where most of the volume is background, of what lies to the
/// farther side of it.
pub(crate) fn default_isovalue(ramp: &OpacityRamp) -> f64 {
    let (low, high) = ramp.range;
    match ramp.background {
        Some((from, to)) if high * 0.5 - to * 0.5 >= from * 0.5 - low * 0.5 => {
            0.5 * to + 0.5 * high
        }
        Some((from, _)) => 0.5 * low + 0.5 * from,
        None => 0.5 * low + 0.5 * high,
    }
}

fn full_range(volume: &dyn Subject) -> Result<(f64, f64), Error> {
    volume.scalar_range().ok_or_else(no_finite_value)
}

fn no_finite_value() -> Error {
    Error::Invalid {
        what: "the field has no finite value in any cell".into(),
        help: Some("choose another field".into()),
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DMat3;
    use tetrascope_core::grid::Samples;
    use tetrascope_core::mesh::Association;
    use tetrascope_core::{Camera, Grid, Projection, Scalars, TetMesh};

    use super::*;
    use crate::{Scene, SceneFile, VolumeSource};

    /// Samples 0, 1, 2 … in a box, the axes of which are the columns of `turn`.
    fn grid(dims: [usize; 3], spacing: DVec3, turn: DMat3) -> Volume {
        let count = dims.iter().product::<usize>();
        let samples = Samples::F32((0..count).map(|i| i as f32).collect());
        let grid = Grid::new(dims, DVec3::ZERO, spacing, turn, samples);
        Volume::Grid(grid.expect("a valid grid"))
    }

    fn box_of(x: f64, y: f64, z: f64) -> Volume {
        let cells = DVec3::new(x, y, z) / 10.0;
        grid([11; 3], cells, DMat3::IDENTITY)
    }

    fn resolve(volume: &Volume, change: impl FnOnce(&mut SceneFile)) -> Scene {
        let mut file = SceneFile::new(VolumeSource::default());
        change(&mut file);
        file.resolve(volume).expect("the scene is valid")
    }

    #[test]
    fn a_needle_is_seen_along_its_axis_and_a_plate_from_the_side() {
        for (volume, side) in [
            (box_of(1.0, 2.0, 3.0), CameraFit::PlusIso),
            (box_of(1000.0, 1000.0, 1.0), CameraFit::PlusIso),
            (box_of(1.0, 1000.0, 300.0), CameraFit::PlusIso),
            (box_of(1e-9, 1e-9, 1e-9), CameraFit::PlusIso),
            (box_of(500.0, 1.0, 1.0), CameraFit::PlusX),
            (box_of(1.0, 1e100, 1.0), CameraFit::PlusY),
            (box_of(11.0, 9.0, 700.0), CameraFit::PlusZ),
        ] {
            let (found, why) = default_side(&volume);
            assert_eq!(found, side);
            assert_eq!(why.is_some(), side != CameraFit::PlusIso);
            let scene = resolve(&volume, |_| {});
            let parallel = matches!(
                scene.view.camera.projection,
                Projection::Orthographic { .. }
            );
            assert_eq!(parallel, why.is_some());
        }
        // A plate that is on edge from (1, 1, 1): its thin axis is (1, -1, 0).
        let quarter = DMat3::from_rotation_z(-std::f64::consts::FRAC_PI_4);
        let plate = grid([2, 11, 11], DVec3::new(0.01, 1.0, 1.0), quarter);
        let (side, why) = default_side(&plate);
        assert_ne!(side, CameraFit::PlusIso);
        assert!(why.is_some());
    }

    // From (1, 1, 1) a box of volume xyz has the shadow (xy + yz + zx)/√3.
    #[test]
    fn the_unit_distance_is_no_longer_than_what_rays_cross() {
        let forward = -DVec3::ONE.unit();
        let model = OpticalModel::EmissionAbsorption;
        let distance = |volume: &Volume, model| default_unit_distance(volume, model, forward).0;
        let slab = box_of(1000.0, 1000.0, 1.0);
        let expected = 3f64.sqrt() * 1e6 / (1e6 + 2e3);
        assert!((distance(&slab, model) / expected - 1.0).abs() < 1e-12);
        // No ray along (1, 1, 1) stays longer than √3 in a layer of thickness 1.
        let longest = distance(&slab, OpticalModel::Emission);
        assert!((longest / 3f64.sqrt() - 1.0).abs() < 1e-12);
        // An ordinary volume has ParaView's, and the diagonal.
        let cube = box_of(10.0, 10.0, 10.0);
        assert!((distance(&cube, model) / 3f64.sqrt() - 1.0).abs() < 1e-12);
        let longest = distance(&cube, OpticalModel::Emission);
        assert!((longest / 300f64.sqrt() - 1.0).abs() < 1e-12);
        // A tetrahedron fills a sixth of its box; the size of all does not matter.
        for size in [1e-9, 1.0, 1e100] {
            let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p * size);
            let scalars = Scalars {
                name: "s".into(),
                association: Association::Point,
                values: vec![0.0, 1.0, 2.0, 3.0],
            };
            let mesh = TetMesh::from_tetrahedra(points.to_vec(), vec![[0, 1, 2, 3]], scalars);
            let tet = Volume::Mesh(mesh.expect("a tet is valid"));
            let expected = size / 6.0 / 3f64.sqrt();
            assert!((distance(&tet, model) / expected - 1.0).abs() < 1e-12);
        }
    }

    // The unit distance follows the camera that the scene has.
    #[test]
    fn each_view_has_its_own_unit_distance() {
        let slab = box_of(1000.0, 1000.0, 1.0);
        let extinction = |fit| {
            let scene = resolve(&slab, |file| file.camera.fit = Some(fit));
            let function = scene.appearance.transfer_function;
            function.max_extinction(f64::NEG_INFINITY, f64::INFINITY)
        };
        let [above, beside] = [CameraFit::PlusZ, CameraFit::PlusX].map(extinction);
        // Above, rays cross 1; beside, 1000, and ParaView's 141 is less.
        assert!((above / beside - 2_000_001_f64.sqrt() / 10.0).abs() < 1e-6);
    }

    #[test]
    fn a_signed_map_is_clear_at_zero_and_a_range_makes_a_plain_ramp() {
        let mut samples = vec![0.0_f32; 4096];
        for (i, sample) in samples.iter_mut().take(100).enumerate() {
            *sample = (i as f32 - 49.5) / 49.5 * 4.0;
        }
        let samples = Samples::F32(samples);
        let [origin, spacing] = [DVec3::ZERO, DVec3::ONE];
        let grid = Grid::new([16; 3], origin, spacing, DMat3::IDENTITY, samples);
        let map = Volume::Grid(grid.expect("valid"));
        let scene = resolve(&map, |_| {});
        let extinction = |scene: &Scene, scalar| {
            let function = &scene.appearance.transfer_function;
            function.sample(scalar).expect("a number").1
        };
        assert_eq!(extinction(&scene, 0.0), 0.0);
        for end in [-4.0, 4.0] {
            assert!(extinction(&scene, end) > extinction(&scene, end / 2.0));
            assert!(extinction(&scene, end / 2.0) > 0.0);
        }
        let said = scene.defaults.join("\n");
        assert!(said.contains("opacity: 0 at 0, which fills 98 %"), "{said}");
        let isosurfaces = resolve(&map, |file| {
            file.appearance.optical_model = Some(OpticalModel::Isosurfaces);
        });
        assert_eq!(isosurfaces.appearance.isosurfaces[0].value, 2.0);
        let plain = resolve(&map, |file| file.appearance.range = Some([-4.0, 4.0]));
        assert!(extinction(&plain, 0.0) > 0.0);
        assert!(
            !plain
                .defaults
                .iter()
                .any(|line| line.starts_with("opacity"))
        );
    }

    // One sample in 27 000 that is not clear: 30 cells deep, but hardly to be seen at the
    // length of a cell.
    #[test]
    fn what_little_is_not_clear_is_made_opaque() {
        let mut samples = vec![0.0_f32; 27_000];
        samples[13_000..13_003].fill(0.2);
        samples[13_003] = 1.0;
        let samples = Samples::F32(samples);
        let [origin, spacing] = [DVec3::ZERO, DVec3::ONE];
        let grid = Grid::new([30; 3], origin, spacing, DMat3::IDENTITY, samples);
        let scene = resolve(&Volume::Grid(grid.expect("valid")), |_| {});
        // 3 ln(1/0.8) + ln(1/0.002) over 27 000, times the mean ray, 29/√3.
        let depth = (3.0 * 1.25f64.ln() + 500f64.ln()) / 27_000.0 * 29.0 / 3f64.sqrt();
        let unit = depth / LEAST_DEPTH;
        let extinction = scene.appearance.transfer_function.max_extinction(0.0, 1.0);
        // 0.2 is stored in f32.
        assert!((extinction * unit / 500f64.ln() - 1.0).abs() < 1e-7);
        let said = scene.defaults.join("\n");
        assert!(said.contains("nearly all of the volume is clear"), "{said}");
    }

    #[test]
    fn what_is_left_out_of_the_range_is_said() {
        let mut samples: Vec<f32> = (0..1000).map(|i| (i % 251) as f32).collect();
        samples[500] = 1e7;
        let samples = Samples::F32(samples);
        let [origin, spacing] = [DVec3::ZERO, DVec3::ONE];
        let grid = Grid::new([10; 3], origin, spacing, DMat3::IDENTITY, samples);
        let scene = resolve(&Volume::Grid(grid.expect("valid")), |_| {});
        assert_eq!(scene.appearance.transfer_function.range(), (0.0, 250.0));
        let said = scene.defaults.join("\n");
        let line = "range: [0, 250], without 1 of 1000 values: the field's is [0, 10000000]";
        assert!(said.contains(line), "{said}");
    }

    #[test]
    fn the_volume_fills_the_picture_of_each_side() {
        let volume = box_of(3.0, 2.0, 1.0);
        let corners = volume.bounds().corners();
        let camera = resolve(&volume, |_| {}).view.camera;
        let expected = Camera::frame(corners, CameraFit::PlusIso, false, 1.0);
        assert_eq!(camera, expected);
        let named = resolve(&volume, |file| {
            file.camera.fit = Some(CameraFit::MinusY);
            (file.image.width, file.image.height) = (Some(300), Some(100));
        });
        let expected = Camera::frame(corners, CameraFit::MinusY, false, 3.0);
        assert_eq!(named.view.camera, expected);
    }
}
