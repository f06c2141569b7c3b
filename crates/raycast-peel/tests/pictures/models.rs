//! Every optical model in both projections on the seven meshes that ray casting is judged by.

use tetrascope_core::{Appearance, CameraFit, OpticalModel, View, Volume, VolumeRenderer as _};
use tetrascope_gpu::{Gpu, testing};
use tetrascope_raycast_peel::RaycastOptions;

use crate::common::{
    angular_sector, blunt_fin, difference, fitted, is_explained, liquid_oxygen_post, mesh, ramp,
    renderer, scale, super_phoenix, surfaces, truth,
};

/// Whether to draw what the bars are stated for, by hand and in release: 512 pixels a side
/// and data sets of their own size.
fn at_full_size() -> bool {
    std::env::var_os("TETRASCOPE_FULL").is_some()
}

fn side() -> u32 {
    if at_full_size() { 512 } else { 40 }
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

/// The bars for a ray in one dispatch.
const RMSE: f64 = 1e-5;
const MAX: f64 = 1e-3;

fn check(gpu: &Gpu, name: &str, volume: &Volume) {
    let mut reference = truth(volume, &ramp(volume));
    for model in OpticalModel::ALL {
        let appearance = of_model(volume, model);
        reference.restyle(&appearance).expect("it draws all");
        let single = renderer(gpu, volume, &appearance, &RaycastOptions::default());
        for (from, view) in views(volume) {
            let what = format!("{name}, {}, {from}", model.name());
            let exact = reference.render_exact(&view).expect("a frame");
            let mut frame = single.render(&view).expect("a frame");
            assert_eq!(frame.stats.lost_rays, Some(0), "{what}");
            assert_eq!(frame.stats.unpaired_faces, Some(0), "{what}");
            let scale = scale(&exact.pixels);
            // Which of two surfaces a ray along an outline meets is f32's guess.
            let mut outlines = 0;
            if model == OpticalModel::Isosurfaces {
                for (i, (got, want)) in frame.pixels.iter_mut().zip(&exact.pixels).enumerate() {
                    let errors = (0..4).map(|c| (f64::from(got[c]) - want[c]).abs());
                    if errors.fold(0.0, f64::max) > MAX && is_explained(&reference, &view, i, *got)
                    {
                        *got = want.map(|c| c as f32);
                        outlines += 1;
                    }
                }
            }
            let errors = difference(&frame, &exact.pixels);
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
            let Some(gpu) = testing::gpu(test) else { return };
            let make: fn(&str) -> Option<tetrascope_core::TetMesh> = $mesh;
            let Some(mesh) = make(test) else { return };
            check(&gpu, test, &Volume::Mesh(mesh));
        }
    )+};
}

fn made(name: &str) -> Option<tetrascope_core::TetMesh> {
    let cells = if at_full_size() { None } else { Some(5000) };
    Some(mesh(name, cells))
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
