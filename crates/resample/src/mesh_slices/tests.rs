//! Pictures against the ground truth.

use tetrascope_core::appearance::{ClipPlane, DepthCue};
use tetrascope_core::glam::{DMat4, DVec3, DVec4};
use tetrascope_core::mesh::Association;
use tetrascope_core::{CameraFit, OpticalModel, Projection, Scalars, TransferFunction};
use tetrascope_testing::{Application, ImageError, data_set, fitted, gpu, grid, ramp, truth};

use super::*;

const SIDE: u32 = 48;

fn with(planes: u32, evaluation: Evaluation) -> MeshSlicesOptions {
    MeshSlicesOptions {
        planes,
        evaluation,
        ..MeshSlicesOptions::default()
    }
}

fn drawn(
    gpu: &Gpu,
    volume: &Volume,
    look: &Appearance,
    view: &View,
    options: &MeshSlicesOptions,
) -> Frame {
    let slices = MeshSlices::new(gpu, volume, look, options).expect("it fits");
    slices.render(view).expect("a frame")
}

fn sphere() -> Volume {
    Volume::Mesh(data_set("sphere", Some(5 * 7 * 7 * 7)))
}

/// The field is continuous and its gradient is not, and rays end where the box does, which planes know
/// to the distance of two: of first order at the ends, of second between.
#[test]
fn the_error_falls_with_the_number_of_planes() {
    let Some(gpu) = gpu("the_error_falls_with_the_number_of_planes") else {
        return;
    };
    let volume = sphere();
    for model in [
        OpticalModel::EmissionAbsorption,
        OpticalModel::Emission,
        OpticalModel::Absorption,
        OpticalModel::MaximumIntensity,
    ] {
        for orthographic in [false, true] {
            let mut look = ramp(&volume);
            look.optical_model = model;
            let view = fitted(&volume, CameraFit::PlusIso, orthographic, SIDE);
            let truth = truth(&volume, &look).render(&view).expect("a frame");
            let errors = [16, 64, 256, 1024].map(|planes| {
                let options = with(planes, Evaluation::PerFragment);
                let frame = drawn(&gpu, &volume, &look, &view, &options);
                ImageError::between(&truth, &frame).rmse
            });
            eprintln!("{}, {orthographic}: {errors:?}", model.name());
            // A fourth each time at first order, with room for where planes happen to lie. The
            // greatest color may be on the surface, and between two planes for many pixels at once.
            let least = match model {
                OpticalModel::MaximumIntensity => 1.0,
                _ => 2.5,
            };
            let fell = errors.windows(2).all(|e| e[1] < e[0] / least);
            let all = errors[3] < errors[0] / 40.0;
            assert!(fell && all, "{}: {errors:?}", model.name());
        }
    }
}

#[test]
fn cues_clip_planes_and_fields_of_cells_are_drawn() {
    let Some(gpu) = gpu("cues_clip_planes_and_fields_of_cells_are_drawn") else {
        return;
    };
    let volume = sphere();
    let Volume::Mesh(mesh) = &volume else {
        panic!("a mesh");
    };
    let bounds = mesh.bounds();
    let mut cued = ramp(&volume);
    cued.depth_cue = Some(DepthCue { strength: 0.8 });
    let mut clipped = ramp(&volume);
    clipped.clip_planes.push(ClipPlane {
        point: bounds.center() + 0.1 * bounds.size(),
        normal: DVec3::new(1.0, 0.5, -0.3),
    });
    let values = (0..mesh.cell_count()).map(|c| (c % 7) as f64).collect();
    let of_cells = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values,
    };
    let of_cells = Volume::Mesh(mesh.with_scalars(of_cells).expect("as many"));
    let cases = [
        ("cue", &volume, cued),
        ("clip", &volume, clipped),
        ("cells", &of_cells, ramp(&of_cells)),
    ];
    for (name, volume, look) in cases {
        for orthographic in [false, true] {
            let view = fitted(volume, CameraFit::PlusIso, orthographic, SIDE);
            let truth = truth(volume, &look).render(&view).expect("a frame");
            let errors = [64, 1024].map(|planes| {
                let options = with(planes, Evaluation::PerFragment);
                let frame = drawn(&gpu, volume, &look, &view, &options);
                ImageError::between(&truth, &frame).rmse
            });
            eprintln!("{name}, {orthographic}: {errors:?}");
            assert!(
                errors[1] < errors[0] / 6.0 && errors[1] < 3e-3,
                "{name}: {errors:?}"
            );
        }
    }
}

/// Rays end in the middle of the mesh, along parallel rays as far from the camera everywhere.
#[test]
fn an_applications_geometry_hides_what_is_behind_it() {
    let Some(gpu) = gpu("an_applications_geometry_hides_what_is_behind_it") else {
        return;
    };
    if !gpu.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
        return;
    }
    let volume = sphere();
    let look = ramp(&volume);
    let mut view = fitted(&volume, CameraFit::PlusIso, true, SIDE);
    view.background = [0.0; 4];
    let camera = &view.camera;
    let (right, up, forward) = camera.axes();
    let Projection::Orthographic { parallel_scale } = camera.projection else {
        panic!("parallel rays");
    };
    let distance = (volume.bounds().center() - camera.position).dot(forward);
    let row = |axis: DVec3, scale: f64| (scale * axis).extend(-scale * axis.dot(camera.position));
    // The middle of the mesh has a depth of 1/2.
    let clip = DMat4::from_cols(
        row(right, parallel_scale.recip()),
        row(up, parallel_scale.recip()),
        row(forward, 0.5 / distance),
        DVec4::W,
    );
    let size = (SIDE, SIDE);
    let pixels = (SIDE * SIDE) as usize;
    let format = TextureFormat::Depth32Float;
    let there = Application::draw(
        &gpu,
        size,
        &vec![[0.0; 4]; pixels],
        &vec![0.5; pixels],
        format,
    );
    let there = there.expect("drawn");
    let options = with(1024, Evaluation::PerFragment);
    let slices = MeshSlices::new(&gpu, &volume, &look, &options).expect("it fits");
    let color = there.color.create_view(&Default::default());
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let target = there.target(&color, clip.transpose());
    let recorded = slices.encode(&mut encoder, &view, &target);
    gpu.finish(encoder).expect("it runs");
    recorded.expect("recorded").statistics().expect("read");
    let (found, _) = there.read(&gpu).expect("read");
    let found = Frame::new(size, found, FrameStats::default());
    let truth = truth(&volume, &look);
    let before = truth.render_before(&view, &vec![distance; pixels]);
    let whole = truth.render(&view).expect("a frame");
    let error = ImageError::between(&before.expect("a frame").to_frame(), &found).rmse;
    let hidden = ImageError::between(&whole, &found).rmse;
    eprintln!("{error}, and {hidden} if nothing were hidden");
    assert!(error < 2e-3 && hidden > 10.0 * error, "{error} {hidden}");
}

/// A scalar is off by 1/N of a cell's range at most, and nothing else differs.
#[test]
fn textures_agree_within_their_resolution() {
    let Some(gpu) = gpu("textures_agree_within_their_resolution") else {
        return;
    };
    let volume = sphere();
    let look = ramp(&volume);
    let view = fitted(&volume, CameraFit::PlusIso, true, SIDE);
    let expected = drawn(
        &gpu,
        &volume,
        &look,
        &view,
        &with(128, Evaluation::PerFragment),
    );
    let errors = [32, 128, 512].map(|weights| {
        let options = with(128, Evaluation::Textures { weights });
        let frame = drawn(&gpu, &volume, &look, &view, &options);
        ImageError::between(&expected, &frame).rmse
    });
    eprintln!("{errors:?}");
    // A cell has a seventh of the field's range or so, of which 1/32 is 0.0045; errors of texels
    // along a ray are of both signs and cancel.
    let fell = errors[2] < errors[0] / 4.0;
    assert!(errors[0] < 4.5e-3 && fell, "{errors:?}");
}

/// Where color and extinction are linear over all scalars both orders are one; else what lies
/// between the scalars of vertices is lost.
#[test]
fn pre_shading_is_exact_for_linear_transfer_functions() {
    let Some(gpu) = gpu("pre_shading_is_exact_for_linear_transfer_functions") else {
        return;
    };
    let volume = sphere();
    let kinked = ramp(&volume);
    let mut linear = kinked.clone();
    let knots = linear.transfer_function.knots();
    let ends = vec![knots[0], knots[2]];
    linear.transfer_function = TransferFunction::new(ends).expect("two knots");
    for (orthographic, textured) in [(false, false), (true, false), (true, true)] {
        let view = fitted(&volume, CameraFit::PlusIso, orthographic, SIDE);
        let evaluation = match textured {
            true => Evaluation::Textures { weights: 256 },
            false => Evaluation::PerFragment,
        };
        let difference = |look: &Appearance| {
            let frame = |shading| {
                let options = MeshSlicesOptions {
                    shading,
                    ..with(64, evaluation)
                };
                drawn(&gpu, &volume, look, &view, &options)
            };
            ImageError::between(&frame(Shading::Post), &frame(Shading::Pre)).rmse
        };
        let differences = [difference(&linear), difference(&kinked)];
        eprintln!("{orthographic}, {textured}: {differences:?}");
        // Colors are interpolated where rasterizers round: to 2⁻⁴ of a pixel at most, of 48 for the
        // whole range, in a random direction for each fragment of a ray.
        assert!(differences[0] < 5e-4, "{differences:?}");
        assert!(differences[1] > 1e-3, "{differences:?}");
    }
}

#[test]
fn slabs_change_nothing() {
    let Some(gpu) = gpu("slabs_change_nothing") else {
        return;
    };
    let volume = sphere();
    let look = ramp(&volume);
    let view = fitted(&volume, CameraFit::PlusX, false, SIDE);
    let frame = |slabs: u32| {
        let options = MeshSlicesOptions {
            slabs,
            ..with(50, Evaluation::PerFragment)
        };
        drawn(&gpu, &volume, &look, &view, &options)
    };
    let expected = frame(40);
    for slabs in [1, 7, 50, 1000] {
        assert_eq!(frame(slabs).pixels, expected.pixels, "{slabs} slabs");
    }
}

#[test]
fn reloaded_and_restyled_is_as_made_anew() {
    let Some(gpu) = gpu("reloaded_and_restyled_is_as_made_anew") else {
        return;
    };
    let first = sphere();
    let second = Volume::Mesh(data_set("torus", Some(2_000)));
    let options = with(40, Evaluation::PerFragment);
    let mut slices = MeshSlices::new(&gpu, &first, &ramp(&first), &options).expect("it fits");
    for volume in [&second, &first, &second] {
        slices.reload(volume).expect("it fits");
        let mut look = ramp(volume);
        look.optical_model = OpticalModel::Emission;
        slices.restyle(&look).expect("a look");
        let view = fitted(volume, CameraFit::PlusIso, false, SIDE);
        let frame = slices.render(&view).expect("a frame");
        let fresh = drawn(&gpu, volume, &look, &view, &options);
        let error = ImageError::between(&fresh, &frame).rmse;
        // A map of scalars that still suits is kept: rounding.
        assert!(error < 1e-5, "{error}");
        let drawn = slices.drawn().expect("read");
        assert!(
            drawn.elements.len() == 40 && drawn.triangles > 1000,
            "{drawn:?}"
        );
    }
}

/// Each step of a change is refused in turn: the picture stays.
#[test]
fn an_error_leaves_the_picture_as_it_was() {
    let Some(gpu) = gpu("an_error_leaves_the_picture_as_it_was") else {
        return;
    };
    let first = sphere();
    let second = Volume::Mesh(data_set("torus", Some(3_000)));
    let (look, mut other) = (ramp(&first), ramp(&second));
    other.optical_model = OpticalModel::Absorption;
    let options = with(20, Evaluation::PerFragment);
    let mut slices = MeshSlices::new(&gpu, &first, &look, &options).expect("it fits");
    let view = fitted(&first, CameraFit::PlusIso, false, SIDE);
    let before = slices.render(&view).expect("a frame").pixels;
    for change in ["reload", "restyle"] {
        let mut refused = 0;
        // More steps than there are. A buffer with room to grow is made without, if refused.
        for step in 0..40 {
            gpu.refuse_after(Some(step));
            let changed = match change {
                "reload" => slices.reload(&second),
                _ => slices.restyle(&other),
            };
            gpu.refuse_after(None);
            if changed.is_ok() {
                slices.reload(&first).expect("it fits");
                slices.restyle(&look).expect("a look");
                continue;
            }
            refused += 1;
            let frame = slices.render(&view).expect("a frame");
            assert!(frame.pixels == before, "{change}, step {step}");
        }
        eprintln!("{change}: {refused} steps");
        assert!(refused > 2 && refused < 40, "{change}: {refused} steps");
    }
}

#[test]
fn what_is_not_drawn_is_refused_in_words() {
    let Some(gpu) = gpu("what_is_not_drawn_is_refused_in_words") else {
        return;
    };
    let volume = sphere();
    let look = ramp(&volume);
    let mut surfaces = look.clone();
    surfaces.optical_model = OpticalModel::Isosurfaces;
    surfaces.isosurfaces = vec![tetrascope_core::appearance::Isosurface {
        value: 0.5,
        color: DVec3::ONE,
    }];
    let samples = Volume::Grid(grid(&tetrascope_testing::Place::unit(4), |p| p.x));
    let usual = MeshSlicesOptions::default();
    let no_planes = with(0, Evaluation::PerFragment);
    let odd = with(16, Evaluation::Textures { weights: 33 });
    let cases = [
        (&volume, &surfaces, usual, "isosurfaces"),
        (&samples, &look, usual, "regular grids"),
        (&volume, &look, no_planes, "planes"),
        (&volume, &look, odd, "even"),
    ];
    for (volume, look, options, words) in cases {
        let error = MeshSlices::new(&gpu, volume, look, &options);
        let error = error.expect_err(words).to_string();
        assert!(error.contains(words) && !error.contains('\n'), "{error}");
    }
    let slices = |options| MeshSlices::new(&gpu, &volume, &look, &options).expect("it fits");
    let mut view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let textured = slices(with(16, Evaluation::Textures { weights: 64 }));
    let error = textured.render(&view).expect_err("perspective").to_string();
    assert!(error.contains("perspective"), "{error}");
    view.camera.position = volume.bounds().center() + 0.1 * volume.bounds().size();
    let error = slices(usual).render(&view).expect_err("inside").to_string();
    assert!(error.contains("eye"), "{error}");
}

#[test]
fn the_uniform_has_the_layout_of_its_twin() {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::mesh_slices::{MESH_SLICE, VIEW_ELEMENTS};

    use super::frame::CameraUniform;

    for program in [VIEW_ELEMENTS, MESH_SLICE] {
        assert_layout!(
            program,
            CameraUniform {
                right,
                up,
                forward,
                extent,
                slope,
                size,
                inverse_anchor_depth,
                first_depth,
                step,
                plane_count,
                cell_count,
                padding
            }
        );
    }
}
