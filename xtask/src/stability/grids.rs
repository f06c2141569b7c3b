//! Regular grids: of every type, size, shape and place, and seen from where rays run along their planes.

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::grid::Samples;
use tetrascope::core::{Appearance, Grid, Volume};
use tetrascope_testing::{Place, grid, grid_of, knot};

use super::case::{Case, Group, Shot};
use super::scenes::{
    ORANGE, SIDE, along_x, down_x, look, one_color, parallel, perspective, plain, plain_over,
    seven_steps, waves, whole,
};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        sizes(),
        far_from_the_origin(),
        turned(),
        of("2×2×2 samples", cube([2; 3]), plain()),
        of("2×2×200 samples", cube([2, 2, 200]), plain()),
        of("200×2×3 samples", cube([200, 2, 3]), plain()),
        flat("samples 1e-5 apart along z", 1e-5),
        flat("samples 1e5 apart along z", 1e5),
        no_values(),
        opaque_at_once(),
        steps(),
        whole_range(),
        one_ulp(),
    ];
    cases.extend(constants());
    cases.extend([1e38, 1e-37].map(values));
    let axes = [
        ("x", DVec3::X),
        ("−y", DVec3::NEG_Y),
        ("z", DVec3::Z),
        ("(1, 1, 0)", DVec3::new(1.0, 1.0, 0.0)),
        ("(1, 1, 1)", DVec3::ONE),
    ];
    cases.extend(axes.map(|(name, toward)| along(name, toward)));
    let places = [
        ("a grid from a sample", DVec3::new(0.25, 0.0, -0.5)),
        ("a grid from a cell's face", DVec3::new(0.25, 0.1, 0.1)),
        ("a grid from its border", DVec3::new(1.0, 0.3, 0.2)),
    ];
    cases.extend(places.map(|(name, position)| {
        let view = perspective(position, DVec3::new(-0.4, 0.03, 0.02), 70.0);
        case(
            name,
            Shot::new(Volume::Grid(waves_on(&cube([9; 3]))), plain(), view),
        )
    }));
    cases
}

fn case(name: impl Into<String>, shot: Shot) -> Case {
    Case::new(Group::Grids, name, shot)
}

/// [−1, 1]³.
fn cube(dims: [usize; 3]) -> Place {
    Place {
        dims,
        origin: DVec3::NEG_ONE,
        spacing: 2.0 / DVec3::from(dims.map(|n| (n - 1) as f64)),
        direction: DMat3::IDENTITY,
    }
}

/// Which of the samples of a cube of 9³ lies here.
fn number_of(p: DVec3) -> usize {
    ((p + 1.0) * 4.0).round().dot(DVec3::new(1.0, 9.0, 81.0)) as usize
}

fn waves_on(place: &Place) -> Grid {
    grid(place, waves)
}

/// The waves on these samples, from a corner.
fn of(name: &str, place: Place, appearance: Appearance) -> Case {
    let volume = Volume::Grid(waves_on(&place));
    let view = whole(&volume);
    case(name, Shot::new(volume, appearance, view))
}

/// The samples of the waves on a cube, where another place has them.
fn elsewhere(place: Place) -> Volume {
    Volume::Grid(place.grid(waves_on(&cube(place.dims)).samples().clone()))
}

/// Lengths times k and extinction by k: the same picture.
fn sizes() -> Case {
    let shots = [1.0, 1e-30, 1e-12, 1e12, 1e30].map(|k| {
        let place = cube([7, 8, 9]);
        let volume = elsewhere(Place {
            origin: k * place.origin,
            spacing: k * place.spacing,
            ..place
        });
        let view = parallel(DVec3::new(2.0, 3.0, 2.5) * k, DVec3::ZERO, 1.75 * k);
        Shot::new(volume, plain_over(0.0, 1.0, k), view)
    });
    Case::same(
        Group::Grids,
        "a grid's lengths times 1e-30 to 1e30",
        shots.into(),
    )
    .for_each()
}

/// Places and distances are sums of few powers of 2, which doubles have there, too.
fn far_from_the_origin() -> Case {
    let shots = [DVec3::ZERO, DVec3::new(5e6, -2e7, 1e7)].map(|by| {
        let place = cube([9, 5, 17]);
        let volume = elsewhere(Place {
            origin: place.origin + by,
            ..place
        });
        let view = parallel(DVec3::new(2.0, 3.0, 2.5) + by, by, 1.75);
        Shot::new(volume, plain(), view)
    });
    Case::same(
        Group::Grids,
        "a grid 1e7 sizes from the origin",
        shots.into(),
    )
    .for_each()
}

/// Axes that are turned, and one that is mirrored as well, with the camera.
fn turned() -> Case {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, -0.48, 0.64), 2.1);
    let from = DVec3::new(2.0, 3.0, 2.5);
    let shots = [
        (DMat3::IDENTITY, false),
        (turn, false),
        (DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), true),
    ];
    let shots = shots.map(|(direction, mirrored)| {
        let place = cube([7, 8, 9]);
        let volume = elsewhere(Place {
            origin: direction * place.origin,
            direction,
            ..place
        });
        let mut view = parallel(direction * from, DVec3::ZERO, 1.75);
        view.camera.view_up = direction * DVec3::Z;
        Shot {
            mirrored,
            ..Shot::new(volume, plain(), view)
        }
    });
    Case::same(
        Group::Grids,
        "a grid that is turned or mirrored",
        shots.into(),
    )
    .for_each()
}

/// The waves on samples that are this far apart along z, and a ¼ along x and y.
fn flat(name: &str, spacing: f64) -> Case {
    let place = cube([9; 3]);
    let stretch = DVec3::new(1.0, 1.0, 4.0 * spacing);
    let volume = elsewhere(Place {
        origin: place.origin * stretch,
        spacing: place.spacing * stretch,
        ..place
    });
    let view = match spacing < 1.0 {
        true => parallel(DVec3::new(0.3, 0.2, 3.0), DVec3::ZERO, 0.8),
        false => parallel(DVec3::new(3.0, 0.2, 0.4), DVec3::ZERO, 0.8),
    };
    let across = if spacing < 1.0 { 4.0 * spacing } else { 1.0 };
    case(name, Shot::new(volume, plain_over(0.0, 1.0, across), view))
}

/// Missing samples make the cells around them transparent.
fn no_values() -> Case {
    let place = cube([9; 3]);
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let volume = grid(&place, |p| {
        let sample = number_of(p);
        match sample % 97 {
            40 => values[sample % 3].into(),
            _ => waves(p),
        }
    });
    let volume = Volume::Grid(volume);
    let view = whole(&volume);
    case(
        "samples that are not finite",
        Shot::new(volume, plain(), view),
    )
}

/// One value everywhere, of each type: whatever is between samples, the light is known.
fn constants() -> Vec<Case> {
    let place = cube([9; 3]);
    let volumes = [
        ("u8", 255.0, grid_of(&place, |_| u8::MAX, Samples::U8)),
        ("u16", 65535.0, grid_of(&place, |_| u16::MAX, Samples::U16)),
        ("i16", -32768.0, grid_of(&place, |_| i16::MIN, Samples::I16)),
        ("f32", -0.3, grid(&place, |_| f64::from(-0.3f32))),
    ];
    let of_type = |(name, value, grid): (&str, f64, Grid)| {
        let knots = [value - 1.0, value + 1.0].map(|s| knot(s, ORANGE, 0.75));
        let shot = Shot::new(Volume::Grid(grid), look(knots.into()), down_x());
        let name = format!("one value of {name} everywhere");
        Case::known(Group::Grids, name, shot, |_| one_color(ORANGE, 1.5)).for_all()
    };
    volumes.map(of_type).into()
}

fn opaque_at_once() -> Case {
    let extinction = 20.0 / 0.25e-6;
    let appearance = look(vec![
        knot(0.0, ORANGE, extinction),
        knot(1.0, ORANGE, extinction),
    ]);
    let shot = Shot::new(
        Volume::Grid(grid(&cube([9; 3]), along_x)),
        appearance,
        down_x(),
    );
    let name = "a grid's cell opaque in 1e-6 of its length";
    Case::known(Group::Grids, name, shot, |_| {
        one_color(ORANGE, f64::INFINITY)
    })
    .for_all()
}

/// Two knots at each of 7 places, on 0 to 1 along x.
fn steps() -> Case {
    let (knots, mean) = seven_steps();
    let depth = mean * 2.0;
    let volume = Volume::Grid(grid(&cube([9; 3]), along_x));
    let shot = Shot::new(volume, look(knots), down_x());
    Case::known(Group::Grids, "7 steps over a grid", shot, move |_| {
        one_color(ORANGE, depth)
    })
}

/// From the least to the greatest 16-bit number, in one cell and in many.
fn whole_range() -> Case {
    let place = cube([9; 3]);
    let samples = grid_of(
        &place,
        |p| match number_of(p) % 5 {
            0 => i16::MIN,
            1 => i16::MAX,
            _ => (waves(p) * 65535.0 - 32768.0) as i16,
        },
        Samples::I16,
    );
    let volume = Volume::Grid(samples);
    let view = whole(&volume);
    let appearance = plain_over(-32768.0, 32767.0, 1.0);
    case("all that 16 bits hold", Shot::new(volume, appearance, view))
}

/// Neighboring floats, and the same picture with 0 and 1.
fn one_ulp() -> Case {
    let shots = [(0.0f32, 1.0f32), (1.0, 1.0f32.next_up())].map(|(low, high)| {
        let value = |p| f64::from(if along_x(p) < 0.5 { low } else { high });
        let volume = Volume::Grid(grid(&cube([7, 8, 9]), value));
        let view = whole(&volume);
        let (low, high) = (f64::from(low), f64::from(high));
        let appearance = look(vec![
            knot(low, [0.1, 0.2, 0.8], 0.1),
            knot(high, [1.0, 0.3, 0.1], 2.0),
        ]);
        Shot::new(volume, appearance, view)
    });
    Case::same(Group::Grids, "a grid with a range of one ulp", shots.into()).for_each()
}

/// The waves times this.
fn values(factor: f64) -> Case {
    let volume = Volume::Grid(grid(&cube([7, 8, 9]), |p| factor * waves(p)));
    let view = whole(&volume);
    let appearance = plain_over(0.0, factor, 1.0);
    let name = format!("a grid with values of {factor:e}");
    case(name, Shot::new(volume, appearance, view))
}

/// Parallel rays whose pixels lie on the planes of samples.
fn along(name: &str, toward: DVec3) -> Case {
    let mut view = parallel(toward * 4.0, DVec3::ZERO, 0.75);
    let (right, up, _) = view.camera.axes();
    let shift = 0.75 / f64::from(SIDE) * (right + up);
    view.camera.position += shift;
    view.camera.focal_point += shift;
    let volume = Volume::Grid(waves_on(&cube([9; 3])));
    case(
        format!("along {name} of a grid"),
        Shot::new(volume, plain(), view),
    )
}
