//! Every optical model in both projections on the meshes that ray casting is judged by.

use tetrascope_core::{
    Appearance, CameraFit, Frame, OpticalModel, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::{LOST_RAYS, UNPAIRED_FACES};
use tetrascope_reference::Reference;
use tetrascope_testing::{
    ImageError, angular_sector, blunt_fin, data_set, fitted, is_explained, liquid_oxygen_post,
    ramp, scale, super_phoenix, surfaces, truth,
};

use crate::common::{MAX, RMSE, renderer};

/// Whether to draw what the bars are stated for, by hand and in release: 512 pixels per side
/// and data sets of their own size.
fn at_full_size() -> bool {
    std::env::var_os("TETRASCOPE_FULL").is_some()
}

fn side() -> u32 {
    if at_full_size() { 512 } else { 60 }
}

/// A perspective and an orthographic view of `volume`.
fn views(volume: &Volume) -> [(&'static str, View); 2] {
    [
        (
            "perspective",
            fitted(volume, CameraFit::PlusIso, false, side()),
        ),
        (
            "orthographic",
            fitted(volume, CameraFit::MinusIso, true, side()),
        ),
    ]
}

fn of_model(volume: &Volume, model: OpticalModel) -> Appearance {
    match model {
        OpticalModel::Isosurfaces => surfaces(volume, ramp(volume)),
        _ => Appearance {
            optical_model: model,
            ..ramp(volume)
        },
    }
}

/// Replaces the pixels that are off and explained, and returns how many there are: those of rays
/// that meet a surface within a rounding of the face between two cells, whose facets are tilted.
fn explain(
    frame: &mut Frame,
    exact: &[[f64; 4]],
    reference: &Reference,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
) -> usize {
    let mut explained = 0;
    for (i, (got, want)) in frame.pixels.iter_mut().zip(exact).enumerate() {
        let errors = (0..4).map(|c| (f64::from(got[c]) - want[c]).abs());
        let is_off = errors.fold(0.0, f64::max) > 10.0 * RMSE;
        if is_off && is_explained(reference, volume, appearance, view, i, *got) {
            *got = want.map(|c| c as f32);
            explained += 1;
        }
    }
    explained
}

fn check(name: &str, volume: &Volume) {
    let mut reference = truth(volume, &ramp(volume));
    for model in OpticalModel::ALL {
        let appearance = of_model(volume, model);
        reference.restyle(&appearance).expect("it draws all");
        let renderer = renderer(volume, &appearance);
        for (from, view) in views(volume) {
            let what = format!("{name}, {}, {from}", model.name());
            let exact = reference.render_exact(&view).expect("a frame");
            let mut frame = renderer.render(&view).expect("a frame");
            assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{what}");
            assert_eq!(frame.stats.get(UNPAIRED_FACES), Some(0), "{what}");
            let scale = scale(&exact.pixels);
            let outlines = match model {
                OpticalModel::Isosurfaces => explain(
                    &mut frame,
                    &exact.pixels,
                    &reference,
                    volume,
                    &appearance,
                    &view,
                ),
                _ => 0,
            };
            let errors = ImageError::against(&exact.pixels, &frame);
            println!(
                "{what}: rmse {:.1e}, max {:.1e} of {scale:.1}, {outlines} on outlines",
                errors.rmse, errors.max
            );
            assert!(
                errors.rmse <= RMSE * scale && errors.max <= MAX * scale,
                "{what}: {errors:?}"
            );
            assert!(outlines <= frame.pixels.len() / 1000, "{what}: {outlines}");
        }
    }
}

macro_rules! judged {
    ($($test:ident: $mesh:expr;)+) => {$(
        #[test]
        fn $test() {
            let test = stringify!($test);
            let make: fn(&str) -> Option<TetMesh> = $mesh;
            let Some(mesh) = make(test) else { return };
            check(test, &Volume::Mesh(mesh));
        }
    )+};
}

fn made(name: &str) -> Option<TetMesh> {
    let cells = if at_full_size() { None } else { Some(5000) };
    Some(data_set(name, cells))
}

judged! {
    sphere: |_| made("sphere");
    heat_sink: |_| made("heat-sink");
    torus: |_| made("torus");
    the_blunt_fin: blunt_fin;
    the_super_phoenix: super_phoenix;
    the_liquid_oxygen_post: liquid_oxygen_post;
    the_angular_sector: angular_sector;
}
