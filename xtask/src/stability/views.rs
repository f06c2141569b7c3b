//! Rays through vertices and along edges and faces; cameras where nobody expects one.

use tetrascope::core::glam::DVec3;
use tetrascope::core::{Camera, Projection, View};
use tetrascope_testing::kuhn;

use super::case::{Case, Group, Shot};
use super::scenes::{Pieces, SIDE, parallel, perspective, plain, seen, waves, whole};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        in_void(),
        nearly_up(),
        case("one pixel", |view| View {
            width: 1,
            height: 1,
            ..*view
        }),
        case("8192×1 pixels", |view| {
            let mut view = View {
                width: 8192,
                height: 1,
                ..*view
            };
            // As wide as the cube, so that pixels are 2⁻¹² of it.
            view.camera.projection = Projection::Orthographic {
                parallel_scale: 1.5 / 8192.0,
            };
            view
        }),
        case("1×777 pixels", |view| View {
            width: 1,
            height: 777,
            ..*view
        }),
    ];
    let axes = [
        ("x", DVec3::X),
        ("y", DVec3::Y),
        ("−z", DVec3::NEG_Z),
        ("(1, 1, 0)", DVec3::new(1.0, 1.0, 0.0)),
        ("(1, 1, 1)", DVec3::ONE),
    ];
    cases.extend(axes.map(|(name, toward)| lattice(name, toward)));
    cases.extend(places().map(|(name, position)| {
        let view = perspective(position, DVec3::new(0.03, 0.02, -0.04), 60.0);
        of(name, Pieces::cube(4, 0.2, waves), view)
    }));
    cases.extend([
        far_away(),
        angle("an angle of 0.01°", 0.01),
        angle("an angle of 170°", 170.0),
    ]);
    cases
}

fn of(name: impl Into<String>, pieces: Pieces, view: View) -> Case {
    Case::new(
        Group::Views,
        name,
        Shot::new(pieces.volume(), plain(), view),
    )
}

/// A jittered cube in a picture like no other.
fn case(name: &str, change: impl Fn(&View) -> View) -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let view = change(&whole(&pieces.clone().volume()));
    of(name, pieces, view)
}

/// Parallel rays down a lattice of cubes, whose pixels lie on its planes, edges and vertices: places
/// and directions are sums of few powers of 2, so that this is so to the last bit.
fn lattice(name: &str, toward: DVec3) -> Case {
    let from = toward * 4.0;
    let mut view = parallel(from, DVec3::ZERO, 0.75);
    // Pixels are 2⁻⁴ wide, and their centers on multiples of that.
    let (right, up, _) = view.camera.axes();
    let half_a_pixel = 0.75 / f64::from(SIDE);
    let shift = half_a_pixel * (right + up);
    view.camera.position += shift;
    view.camera.focal_point += shift;
    of(
        format!("along {name} of a lattice"),
        Pieces::cube(4, 0.0, waves),
        view,
    )
}

/// Places on the cube's vertices, edges and faces and inside, none of which is moved.
fn places() -> impl Iterator<Item = (&'static str, DVec3)> {
    [
        ("from a vertex of the border", DVec3::new(1.0, 0.5, 0.5)),
        ("from an edge of the border", DVec3::new(1.0, 0.5, 0.25)),
        ("from a face of the border", DVec3::new(1.0, 0.4, 0.2)),
        ("from inside", DVec3::new(0.61, 0.47, 0.33)),
    ]
    .into_iter()
}

/// From a vertex, in a lattice that has its vertices where they are said to be.
fn in_void() -> Case {
    let (points, cells) = kuhn(5, DVec3::NEG_ONE, DVec3::ONE, |c| c != [2; 3]);
    let view = perspective(
        DVec3::new(0.05, 0.03, 0.02),
        DVec3::new(1.0, 0.4, 0.1),
        100.0,
    );
    of(
        "from inside a void",
        Pieces::with_field(points, cells, waves),
        view,
    )
}

/// The up vector is 1e-7 from the direction of view.
fn nearly_up() -> Case {
    let mut view = perspective(DVec3::new(4.0, 0.0, 0.0), DVec3::ZERO, 30.0);
    view.camera.view_up = DVec3::new(1.0, 0.0, 1e-7);
    of(
        "up nearly along the view",
        Pieces::cube(4, 0.2, waves),
        view,
    )
}

/// From a million sizes, through so narrow an angle that the cube fills the picture.
fn far_away() -> Case {
    let distance = 2e6;
    let position = DVec3::new(0.6, 0.64, 0.48) * distance;
    let angle = 2.0 * (1.8 / distance).atan().to_degrees();
    let view = perspective(position, DVec3::ZERO, angle);
    of("from 1e6 sizes away", Pieces::cube(4, 0.2, waves), view)
}

/// From where the cube fills this angle, or from just before it where it cannot.
fn angle(name: &str, view_angle: f64) -> Case {
    let distance = (1.5 / (view_angle.to_radians() / 2.0).tan()).max(1.1);
    let camera = Camera {
        position: DVec3::new(distance, 0.1, 0.07),
        focal_point: DVec3::ZERO,
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle },
    };
    of(name, Pieces::cube(4, 0.2, waves), seen(camera))
}
