//! Why a picture shows nothing, or hardly anything.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Bounds, Camera, ClipPlane, Error, Frame, OpticalModel, Projection, Ray, View,
    Volume, number,
};

/// Half a step of an 8-bit image: nothing below it can be seen in a PNG.
const INVISIBLE: f32 = 0.5 / 255.0;

/// A picture that changes no pixel's opacity or color by more than this is faint.
const FAINT: f32 = 0.1;

/// The same for light alone on a black background, where linear 0.02 is a dark gray, 15 %
/// in sRGB.
const FAINT_LIGHT: f32 = 0.02;

/// Why `frame` shows nothing but the background, or that what it shows is faint; `None` if
/// it shows something.
///
/// The reason is the first that holds of: nothing to draw, no ray meets the
/// volume's box, the transfer function is clear everywhere, it is clear over the
/// field's range, its extinction is too low for so small a volume, and at last
/// that the rays pass beside the cells. It is an [`Error::Invalid`], so that it has
/// a line of help; whether it is an error is the caller's choice.
pub fn explain(
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
    frame: &Frame,
) -> Option<Error> {
    let background = view.premultiplied_background().map(|c| c as f32);
    let mut greatest = 0.0_f32;
    for pixel in &frame.pixels {
        for (channel, background) in pixel.iter().zip(background) {
            let difference = (channel - background).abs();
            if difference.is_nan() {
                return None; // it is something
            }
            greatest = greatest.max(difference);
        }
    }
    let only_light = appearance.optical_model.only_adds_light();
    let (what, help) = if greatest < INVISIBLE {
        let (why, help) = reason(volume, appearance, view);
        (format!("the picture is empty: {why}"), help)
    } else if greatest < if only_light { FAINT_LIGHT } else { FAINT } {
        let percent = number::rounded(f64::from(100.0 * greatest));
        (
            format!("the picture is faint: it is at most {percent} % from the background"),
            "lower `unit_distance`, narrow `range`, or look from another side with `camera`".into(),
        )
    } else {
        return None;
    };
    Some(Error::Invalid {
        what,
        help: Some(help),
    })
}

fn reason(volume: &Volume, appearance: &Appearance, view: &View) -> (String, String) {
    if volume.cell_count() == 0 || volume.bounds().is_empty() {
        return (
            "the volume has no cells".into(),
            "look at what the file holds".into(),
        );
    }
    let Some((low, high)) = volume.scalar_range() else {
        return (
            "the field has no finite value in any cell".into(),
            "choose another field".into(),
        );
    };
    let bounds = volume.bounds();
    if !meets(view, &bounds) {
        let place = number::bounds(&bounds);
        let why = match sees(view, bounds.center()) {
            true => "the volume is thinner than a pixel in this view",
            false => "the camera sees no cell",
        };
        return (
            format!("{why}; it reaches from {place}"),
            "leave `camera` out, or use another side; each shows the whole volume".into(),
        );
    }
    let model = appearance.optical_model;
    if model == OpticalModel::Isosurfaces {
        let values = appearance.isosurfaces.iter();
        let values: Vec<String> = values.map(|s| number::exact(s.value)).collect();
        return (
            format!(
                "no ray meets an isosurface of {} in a field from {} to {}",
                values.join(", "),
                number::exact(low),
                number::exact(high)
            ),
            "give a value in between, or look from elsewhere".into(),
        );
    }
    let tf = &appearance.transfer_function;
    let strength = |low, high| match model {
        OpticalModel::Absorption => tf.max_extinction(low, high),
        OpticalModel::MaximumIntensity => tf.max_color(low, high),
        _ => tf.max_extinction(low, high),
    };
    let quantity = match model {
        OpticalModel::MaximumIntensity => "color",
        _ => "extinction",
    };
    if strength(f64::NEG_INFINITY, f64::INFINITY) == 0.0 {
        return (
            format!("the transfer function's {quantity} is 0 at every knot"),
            "raise it, or leave the transfer function out: a color map is the default".into(),
        );
    }
    if strength(low, high) == 0.0 {
        let knots = tf.knots();
        let (first, last) = (knots[0].scalar, knots[knots.len() - 1].scalar);
        let [first, last, low, high] = [first, last, low, high].map(number::exact);
        return (
            format!(
                "the transfer function's {quantity} is 0 over the field's range, {low} to {high}; \
                 its knots span {first} to {last}"
            ),
            format!("use `range` {low},{high}"),
        );
    }
    // No chord is longer than the diagonal, so no optical depth exceeds this.
    let depth = strength(low, high) * bounds.diagonal();
    if model != OpticalModel::MaximumIntensity && depth < f64::from(INVISIBLE) {
        return (
            format!(
                "opacity is too low: the optical depth of the whole volume is at most {depth:.3e}"
            ),
            "lower `unit_distance`, or raise the transfer function's extinction".into(),
        );
    }
    if model != OpticalModel::Absorption && tf.max_color(low, high) == 0.0 {
        return (
            "the transfer function's color is black, as is what lies behind".into(),
            "use `background` white, or `colormap` viridis".into(),
        );
    }
    if is_cut_away(appearance, &bounds) {
        return (
            "the clip planes cut away the whole volume".into(),
            "turn a normal of `clip_planes` round, or move its point into the volume: what is behind the plane is cut away"
                .into(),
        );
    }
    (
        "the rays meet the volume's box, but pass beside its cells or through clear ones".into(),
        "use the `camera` fit+iso and the default colors, and change one of them at a time".into(),
    )
}

/// Whether one clip plane has the whole box behind it.
fn is_cut_away(appearance: &Appearance, bounds: &Bounds) -> bool {
    let cuts = |plane: &ClipPlane| {
        let corners = bounds.corners();
        let is_behind = |corner: &DVec3| (*corner - plane.point).dot(plane.normal) <= 0.0;
        corners.iter().all(is_behind)
    };
    appearance.clip_planes.iter().any(cuts)
}

/// Whether `point` lies in the image.
fn sees(view: &View, point: DVec3) -> bool {
    let Camera {
        position,
        projection,
        ..
    } = view.camera;
    let (right, up, forward) = view.camera.axes();
    let p = point - position;
    let depth = p.dot(forward);
    let half = match projection {
        Projection::Perspective { view_angle } => depth * (view_angle.to_radians() / 2.0).tan(),
        Projection::Orthographic { parallel_scale } => parallel_scale,
    };
    let aspect = f64::from(view.width) / f64::from(view.height);
    depth > 0.0 && p.dot(up).abs() <= half && p.dot(right).abs() <= half * aspect
}

/// Whether the ray of any pixel meets `bounds`.
fn meets(view: &View, bounds: &Bounds) -> bool {
    (0..view.height).any(|row| (0..view.width).any(|column| hits(&view.ray(column, row), bounds)))
}

/// The slab test: whether the ray is inside all three pairs of planes at once.
fn hits(ray: &Ray, bounds: &Bounds) -> bool {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    let axes = |v: DVec3| v.to_array();
    let slabs = axes(bounds.min).into_iter().zip(axes(bounds.max));
    for ((low, high), (origin, direction)) in
        slabs.zip(axes(ray.origin).into_iter().zip(axes(ray.direction)))
    {
        if direction == 0.0 {
            if !(low..=high).contains(&origin) {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave
}

#[cfg(test)]
mod tests {
    use tetrascope_core::mesh::Association;
    use tetrascope_core::{FrameStats, Knot, Scalars, TetMesh};
    use tetrascope_scene::{AppearanceSpec, SceneFile, VolumeSource};

    use super::*;

    /// One cell with scalars 1 to 4.
    fn tet(values: [f64; 4]) -> Volume {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: values.to_vec(),
        };
        let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars);
        Volume::Mesh(mesh.expect("a tet is valid"))
    }

    /// The explanation of a black 8x8 picture of `volume`, the scene changed by `change`.
    fn why(volume: &Volume, change: impl FnOnce(&mut SceneFile)) -> String {
        let mut file = SceneFile::new(VolumeSource::default());
        (file.image.width, file.image.height) = (Some(8), Some(8));
        change(&mut file);
        let scene = file.resolve(volume).expect("the scene is valid");
        let frame = Frame::new((8, 8), vec![[0.0; 4]; 64], FrameStats::default());
        let error = explain(volume, &scene.appearance, &scene.view, &frame);
        error.expect("the picture is empty").to_string()
    }

    fn knots(pairs: &[(f64, f64)]) -> AppearanceSpec {
        let knot = |&(scalar, extinction)| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        };
        AppearanceSpec {
            transfer_function: Some(pairs.iter().map(knot).collect()),
            ..AppearanceSpec::default()
        }
    }

    #[test]
    fn each_cause_has_its_own_words() {
        let volume = tet([1.0, 2.0, 3.0, 4.0]);
        let away = why(&volume, |file| {
            file.camera.position = Some(DVec3::splat(5.0));
            file.camera.focal_point = Some(DVec3::splat(9.0));
        });
        assert!(away.contains("the camera sees no cell"), "{away}");
        let clear = why(&volume, |file| {
            file.appearance = knots(&[(0.0, 0.0), (9.0, 0.0)])
        });
        assert!(clear.contains("0 at every knot"), "{clear}");
        let outside = why(&volume, |file| {
            file.appearance = knots(&[(5.0, 0.0), (9.0, 1.0)]);
        });
        assert!(outside.contains("range, 1 to 4"), "{outside}");
        let faint = why(&volume, |file| file.appearance = knots(&[(0.0, 1e-6)]));
        assert!(faint.contains("opacity is too low"), "{faint}");
        let black = why(&volume, |file| {
            file.appearance = knots(&[(0.0, 1.0)]);
            for knot in file.appearance.transfer_function.iter_mut().flatten() {
                knot.color = DVec3::ZERO;
            }
            file.image.background = Some([0.0, 0.0, 0.0, 0.0]);
        });
        assert!(black.contains("black"), "{black}");
        let beside = why(&volume, |_| {});
        assert!(beside.contains("pass beside"), "{beside}");
    }

    #[test]
    fn a_plane_that_leaves_nothing_is_named() {
        let volume = tet([1.0, 2.0, 3.0, 4.0]);
        let why = |point: f64| {
            why(&volume, |file| {
                let (point, normal) = (DVec3::splat(point), DVec3::ONE);
                file.appearance.clip_planes = Some(vec![ClipPlane { point, normal }]);
            })
        };
        assert!(why(5.0).contains("cut away the whole volume"));
        assert!(why(0.1).contains("pass beside"));
    }

    #[test]
    fn nan_everywhere_is_named() {
        let volume = tet([f64::NAN; 4]);
        let nan = why(&volume, |file| file.appearance = knots(&[(0.0, 1.0)]));
        assert!(nan.contains("no finite value"), "{nan}");
    }

    #[test]
    fn a_picture_with_something_in_it_is_not_explained() {
        let volume = tet([1.0, 2.0, 3.0, 4.0]);
        let scene = SceneFile::new(VolumeSource::default())
            .resolve(&volume)
            .expect("defaults suffice");
        let explained = |value: f32| {
            let mut frame = Frame::new((2, 1), vec![[0.0; 4]; 2], FrameStats::default());
            frame.pixels[1][3] = value;
            explain(&volume, &scene.appearance, &scene.view, &frame)
        };
        for value in [0.2, 1.0, f32::NAN] {
            assert!(explained(value).is_none(), "{value}");
        }
        let faint = explained(0.04).expect("hardly anything");
        assert!(faint.to_string().contains("at most 4 %"), "{faint}");
        let help = faint.help().expect("what to do");
        assert!(
            help.contains("`unit_distance`") && help.contains("`range`"),
            "{help}"
        );
    }

    #[test]
    fn a_plate_on_edge_is_thinner_than_a_pixel() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.3, 0.3, 1e-6)];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: vec![1.0, 2.0, 3.0, 4.0],
        };
        let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars);
        let plate = Volume::Mesh(mesh.expect("valid"));
        let edge = why(&plate, |file| {
            file.camera.fit = Some(tetrascope_core::CameraFit::PlusX);
        });
        assert!(edge.contains("thinner than a pixel"), "{edge}");
    }
}
