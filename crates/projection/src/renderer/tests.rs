//! Tests of what a renderer keeps and of what it makes again.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Scalars;
use tetrascope_core::{Camera, CameraFit, Knot, OpticalModel, TransferFunction};
use tetrascope_gpu::Integration;
use tetrascope_testing as testing;

use super::*;

fn tetrahedron(scalars: [f64; 4], size: f64) -> TetMesh {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| size * p);
    let scalars = testing::point_scalars(scalars.to_vec());
    TetMesh::from_tetrahedra(points.to_vec(), vec![[0, 1, 2, 3]], scalars).expect("valid")
}

fn ramp(low: f64, high: f64) -> Appearance {
    let knot = |scalar, extinction| Knot {
        scalar,
        color: DVec3::ONE,
        extinction,
    };
    let knots = vec![knot(low, 0.0), knot(high, 1.0)];
    let function = TransferFunction::new(knots).expect("sorted");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

// Around the depth of 1 that the weights of a segment are good for: all below it; some
// above it; so many, or so far, that the loop over steps is left to do it.
#[test]
fn pieces_too_deep_for_one_step_are_drawn_in_parts() {
    let Some(gpu) = testing::gpu("pieces_too_deep_for_one_step_are_drawn_in_parts") else {
        return;
    };
    let volume = Volume::Mesh(testing::data_set("sphere", Some(12_000)));
    let bounds = volume.bounds();
    let range = volume.scalar_range().expect("numbers");
    let order = ProjectionOptions {
        order: crate::Order::Mpvo,
        ..ProjectionOptions::default()
    };
    let view = View {
        camera: Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0),
        width: 64,
        height: 64,
        background: [0.2, 0.3, 0.1, 0.6],
    };
    // Up to so many depths across the box, where scalars are greater than a share of the range.
    let dense = [
        (5.0, 0.93, true),
        (100.0, 0.93, true),
        (400.0, 0.93, true),
        (5000.0, 0.93, false),
        // Few cells, but of more parts than are counted.
        (1e6, 0.9999, false),
    ];
    for (densest, from, in_parts) in dense {
        let knot = |share: f64, extinction: f64| Knot {
            scalar: range.0 + share * (range.1 - range.0),
            color: DVec3::new(share, 0.8, 1.0 - share),
            extinction: extinction / bounds.diagonal(),
        };
        let knots = vec![knot(0.0, 0.1), knot(from, 0.2), knot(1.0, densest)];
        let function = TransferFunction::new(knots).expect("sorted");
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
            let appearance = Appearance::new(function.clone(), model);
            let renderer =
                CellProjection::new(&gpu, &volume, &appearance, &order).expect("it fits");
            let culled = &renderer.style.classified.culled;
            let expected = in_parts && model == OpticalModel::EmissionAbsorption;
            eprintln!(
                "{densest} {model:?}: {} cells, {} items",
                culled.cells, culled.items
            );
            assert_eq!(culled.in_parts, expected, "{densest} {model:?}");
            let reference = testing::truth(&volume, &appearance);
            let truth = reference.render(&view).expect("a picture");
            let picture = renderer.render(&view).expect("a picture");
            let pairs = picture
                .pixels
                .iter()
                .flatten()
                .zip(truth.pixels.iter().flatten());
            // Chords are wrong by 2e-7 of the mesh's size (tests/pictures/common.rs), so
            // depths by that times the extinction. No light is added behind what hides it:
            // 1e-4 is far below what a part left out or drawn twice would change.
            let mut limit = 2e-7 * densest;
            if model == OpticalModel::EmissionAbsorption {
                limit = limit.min(1e-4);
            }
            let worst = pairs
                .map(|(a, b)| f64::from((a - b).abs()))
                .fold(0.0, f64::max);
            eprintln!("    {worst:e}");
            assert!(worst <= limit, "{densest} {model:?}: {worst:e}");
        }
    }
}

#[test]
fn the_table_is_made_by_restyle_alone() {
    let Some(gpu) = testing::gpu("the_table_is_made_by_restyle_alone") else {
        return;
    };
    let mesh = tetrahedron([0.0, 0.3, 0.6, 0.9], 1.0);
    let options = ProjectionOptions {
        integration: Integration::Table3d { n: 8 },
        ..ProjectionOptions::default()
    };
    let volume = Volume::Mesh(mesh.clone());
    let mut renderer =
        CellProjection::new(&gpu, &volume, &ramp(0.0, 1.0), &options).expect("it fits");
    let table = |renderer: &CellProjection| renderer.style.classified.table.texture().clone();
    let first = table(&renderer);

    // Another view.
    for side in [CameraFit::PlusX, CameraFit::MinusIso] {
        let view = View {
            camera: Camera::fit(&mesh.bounds(), side, false, 1.0),
            width: 8,
            height: 8,
            background: [0.0; 4],
        };
        renderer.render(&view).expect("a picture");
        assert_eq!(table(&renderer), first);
    }
    // The next step of a time series, beyond the transfer function's knots too.
    let scalars = Scalars {
        values: vec![-2.0, 0.5, 0.1, 7.0],
        ..mesh.scalars().clone()
    };
    let next = Volume::Mesh(mesh.with_scalars(scalars).expect("four numbers"));
    renderer.reload(&next).expect("it fits");
    assert_eq!(table(&renderer), first);
    // The same appearance, again.
    renderer.restyle(&ramp(0.0, 1.0)).expect("it fits");
    assert_eq!(table(&renderer), first);

    // Another transfer function, near enough for the scalars to stay as they are.
    renderer.restyle(&ramp(0.0, 0.75)).expect("it fits");
    let second = table(&renderer);
    assert_ne!(second, first);
    // A mesh of which every segment is as long in normalized units, so that extinction
    // per normalized unit is what changes.
    let larger = Volume::Mesh(tetrahedron([0.0, 0.3, 0.6, 0.9], 4.0));
    renderer.reload(&larger).expect("it fits");
    assert_ne!(table(&renderer), second);
}

#[test]
fn a_model_without_a_table_leaves_the_renderer_as_it_was() {
    let Some(gpu) = testing::gpu("a_model_without_a_table_leaves_the_renderer_as_it_was") else {
        return;
    };
    let volume = Volume::Mesh(tetrahedron([0.0, 0.3, 0.6, 0.9], 1.0));
    let options = |integration| ProjectionOptions {
        integration,
        ..ProjectionOptions::default()
    };
    let sorted = ramp(0.0, 1.0);
    let flat = options(Integration::Table2d { n: 8 });
    let refused = CellProjection::new(&gpu, &volume, &sorted, &flat);
    assert!(matches!(refused, Err(Error::Unsupported { .. })));
    let glow = Appearance {
        optical_model: OpticalModel::Emission,
        ..sorted.clone()
    };
    let mut renderer = CellProjection::new(&gpu, &volume, &glow, &flat).expect("it fits");
    let refused = renderer.restyle(&sorted);
    assert!(matches!(refused, Err(Error::Unsupported { .. })));
    assert_eq!(renderer.style.appearance, glow);
    let huge = options(Integration::Table3d { n: 512 });
    let refused = CellProjection::new(&gpu, &volume, &sorted, &huge).expect_err("2 GiB");
    assert!(
        refused.to_string().contains("512 samples a side"),
        "{refused}"
    );
}
