//! Ray parameters at vertices (§4) and the layouts of cells (§6, §7) against the ground
//! truth.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, Error, Frame, Knot, OpticalModel, Projection, TetMesh, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::{Gpu, RenderProgram, read_back, wgpu};
use tetrascope_projection::{CellLayout, CellProjection, ExitSearch, Order, ProjectionOptions};
use tetrascope_testing as testing;

use crate::common::{crooked, drawn, scene, truth};

fn options(exit_search: ExitSearch, cell_layout: CellLayout) -> ProjectionOptions {
    ProjectionOptions {
        exit_search,
        cell_layout,
        order: Order::Mpvo,
        ..ProjectionOptions::default()
    }
}

/// Root mean square, and the number of pixels that are off by more than `most`.
fn off_by(a: &Frame, b: &Frame, most: f32) -> (f64, usize) {
    let off = |(p, q): (&[f32; 4], &[f32; 4])| {
        let off = p.iter().zip(q).map(|(x, y)| (x - y).abs());
        off.fold(0.0, f32::max)
    };
    let off: Vec<f32> = a.pixels.iter().zip(&b.pixels).map(off).collect();
    let square = off.iter().map(|o| f64::from(*o).powi(2)).sum::<f64>();
    (
        (square / off.len() as f64).sqrt(),
        off.iter().filter(|o| **o > most).count(),
    )
}

// What is left of §4.3's artifacts: one endpoint of an edge is not classified, so rays
// within 2⁻¹⁶ of an edge from a vertex may miss a cell: of 96² pixels none is expected so
// near to one of 700 vertices, and none is singular.
//
// The rasterizer is on its own grid of 1/256 pixel. Chords are continuous across edges, so
// there a pixel is off by 1/256 of what a pixel beside it differs: cells are 6 pixels wide
// and have opacities up to 1/3, 1/3 · 1/6 · 1/256 = 2e-4, and not 4e-3 in any. One ray of 100
// is so near to an edge: an RMSE of 2e-5. The gradient of a cell is rounded by 2⁻²³ of its
// scalars over its height, as the cells are well shaped.
//
// Vulkan lets that grid be 1/16 of a pixel (subPixelPrecisionBits is 4 or more) and
// interpolates between the vertices that were moved to it, so every parameter is that of a
// point d pixels beside the ray, d up to 1/32 along each axis; SwiftShader is such. llvmpipe
// interpolates between the vertices as they were. So d is measured (`displacement`). What a
// cell adds goes from nothing to most of it, v, on half of its 6 pixels: a cell is off by up
// to v d/3, and all 20 of a ray by 20 times that. An RMSE is √20 of it, as cells err in
// either direction, and 1/√3, as vertices are moved by anything up to d. v is 1/3 where it
// is an opacity; of a sum along the ray, thrice the share of one in 20.
//
// 16 bits round the scalar by 2⁻¹⁷ and the gradient by 2⁻⁹ of up to a tenth of the range in
// a cell, 2e-4, which slopes of the transfer function up to 20 and 20 cells on a ray of
// opacities up to 1/3 make 2e-4 · 20 · √20 · 1/3 = 6e-3 where all add up; the tilt of
// planes whose normals lie in z = 0, √(2⁻¹⁵) of a cell, is rarer.
#[test]
fn interpolated_parameters_draw_the_same_picture() {
    let test = "interpolated_parameters_draw_the_same_picture";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let (volume, transfer_function) = scene("sphere", 3000);
    let view = crooked(&volume, true, 96);
    let beside = displacement(&gpu);
    eprintln!("parameters are those of points {beside:.1e} pixels beside the ray");
    for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
        let appearance = Appearance::new(transfer_function.clone(), model);
        let truth = truth(&volume, &appearance, &view);
        let greatest = truth.pixels.iter().flat_map(|p| &p[..3]);
        let greatest = f64::from(greatest.copied().fold(0.0, f32::max));
        let of_cell = match model {
            OpticalModel::EmissionAbsorption => 1.0 / 3.0,
            _ => 3.0 / 20.0 * greatest,
        };
        let one_cell = of_cell * beside / 3.0;
        for (name, layout) in CellLayout::ALL {
            let options = options(ExitSearch::PerVertex, layout);
            let picture = drawn(&gpu, &volume, &appearance, &view, &options);
            let bounds = match layout {
                CellLayout::TwelveShorts => (6e-3, 2e-2),
                _ => (2e-5, 4e-3),
            };
            let allowed = bounds.0 + one_cell * (20.0_f64 / 3.0).sqrt();
            let most = bounds.1 + 20.0 * one_cell;
            let (rmse, off) = off_by(&picture, &truth, most as f32);
            eprintln!("{model:?} {name}: RMSE {rmse:.1e} of {allowed:.1e}, {off} over {most:.1e}");
            assert!(rmse <= allowed, "{model:?} {name}: {rmse:e}");
            assert_eq!(off, 0, "{model:?} {name}");
        }
    }
}

/// How far from a pixel's center the point is, along either axis, whose parameters a
/// fragment gets; pixels. The most of sixteen triangles at places of no grid.
fn displacement(gpu: &Gpu) -> f64 {
    const SIDE: u32 = 64;
    const PROBE: &str = "
        struct Placed {
            @builtin(position) position: vec4f,
            @location(0) pixel: vec2f,
        }
        @vertex
        fn vs(@builtin(vertex_index) i: u32) -> Placed {
            let triangle = vec2u(i / 3u % 4u, i / 12u);
            let corner = array(vec2f(1.0, 1.0), vec2f(3.0, 14.0), vec2f(14.0, 5.0))[i % 3u];
            let shift = fract(vec2f(0.7548777, 0.5698403) * f32(i + 1u));
            let pixel = 16.0 * vec2f(triangle) + corner + shift;
            let at = vec2f(pixel.x / 32.0 - 1.0, 1.0 - pixel.y / 32.0);
            return Placed(vec4f(at, 0.5, 1.0), pixel);
        }
        @fragment
        fn fs(in: Placed) -> @location(0) vec4f {
            return vec4f(abs(in.pixel - in.position.xy), 0.0, 1.0);
        }";
    let format = wgpu::TextureFormat::Rgba32Float;
    let pipeline = gpu.render_pipeline(&RenderProgram {
        label: "probe",
        source: PROBE,
        vertex: "vs",
        fragment: Some("fs"),
        targets: vec![Some(format.into())],
        ..Default::default()
    });
    let pipeline = pipeline.expect("compiles");
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let texture = gpu.texture("probe", (SIDE, SIDE), format, usage);
    let texture = texture.expect("it fits");
    let view = texture.create_view(&Default::default());
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.draw(0..3 * 16, 0..1);
    }
    let pixels = read_back(gpu, &mut encoder, Source::Texture(&texture)).expect("it fits");
    gpu.finish(encoder).expect("it draws");
    let pixels: Vec<[f32; 4]> = pixels.read().expect("readable");
    let drawn: Vec<&[f32; 4]> = pixels.iter().filter(|p| p[3] == 1.0).collect();
    assert!(
        drawn.len() > 16 * 20,
        "triangles of some 70 pixels: {}",
        drawn.len()
    );
    let beside = drawn.iter().flat_map(|p| &p[..2]);
    f64::from(beside.copied().fold(0.0, f32::max))
}

/// A box of one cube, n times as long as wide, in five tetrahedra.
fn stretched(n: f64) -> Volume {
    let corner = |i: u32| {
        DVec3::new(
            n * f64::from(i & 1),
            f64::from(i >> 1 & 1),
            f64::from(i >> 2),
        )
    };
    let points: Vec<DVec3> = (0..8).map(corner).collect();
    let cells = vec![
        [0, 3, 5, 6],
        [0, 1, 3, 5],
        [0, 3, 2, 6],
        [0, 5, 6, 4],
        [3, 5, 7, 6],
    ];
    let scalars = testing::point_scalars(vec![1.0; 8]);
    Volume::Mesh(TetMesh::from_tetrahedra(points, cells, scalars).expect("a valid mesh"))
}

// Between samples the minimum is rounded off by up to a sample's width, of the longest edge:
// a chord across cells n times as long as wide is off by n times as much (§4.1). So the
// error falls with the samples and grows with the stretching.
#[test]
fn minimum_textures_lose_stretched_cells() {
    let Some(gpu) = testing::gpu("minimum_textures_lose_stretched_cells") else {
        return;
    };
    let knot = Knot {
        scalar: 1.0,
        color: DVec3::ONE,
        extinction: 1.0,
    };
    let transfer_function = TransferFunction::new(vec![knot]).expect("one knot");
    let appearance = Appearance::new(transfer_function, OpticalModel::Absorption);
    let error = |aspect: f64, side: Option<u32>| {
        let volume = stretched(aspect);
        // Along z, where the box is 1 deep, at its middle.
        let camera = Camera {
            position: DVec3::new(0.5 * aspect + 0.013, 0.507, 9.0),
            focal_point: DVec3::new(0.5 * aspect + 0.013, 0.507, 0.0),
            view_up: DVec3::Y,
            projection: Projection::Orthographic {
                parallel_scale: 0.4,
            },
        };
        let view = View {
            camera,
            width: 48,
            height: 48,
            background: [0.0; 4],
        };
        let exit = side.map_or(ExitSearch::PerVertex, |_| ExitSearch::PerVertexTexture);
        let options = ProjectionOptions {
            minimum_side: side.unwrap_or(128),
            ..options(exit, CellLayout::SharedVertices)
        };
        let picture = drawn(&gpu, &volume, &appearance, &view, &options);
        off_by(&picture, &truth(&volume, &appearance, &view), 1.0).0
    };
    let mut last = f64::INFINITY;
    for side in [16, 32, 64, 128] {
        let (cube, bar) = (error(1.0, Some(side)), error(8.0, Some(side)));
        eprintln!("{side}: {cube:.1e} in a cube, {bar:.1e} in a bar of 8");
        // A sample of the cube's diagonal, √2/side, for each of at most three cells.
        assert!(cube < 3.0 * 1.5 / f64::from(side), "{side}: {cube:e}");
        assert!(bar > 2.0 * cube, "{side}: {bar:e} and {cube:e}");
        assert!(bar < last, "{side}: {bar:e} after {last:e}");
        last = bar;
    }
    // Compared, not looked up: rounding alone, but on the rasterizer's edges between the
    // few cells, whose chords are continuous there.
    assert!(error(8.0, None) < 1e-4, "{:e}", error(8.0, None));
}

#[test]
fn layouts_take_the_bytes_that_were_published() {
    let Some(gpu) = testing::gpu("layouts_take_the_bytes_that_were_published") else {
        return;
    };
    let (volume, transfer_function) = scene("sphere", 3000);
    let appearance = Appearance::new(transfer_function, OpticalModel::Emission);
    let view = crooked(&volume, true, 96);
    let bytes = |exit, layout| {
        let picture = drawn(&gpu, &volume, &appearance, &view, &options(exit, layout));
        let stats = picture.stats;
        let cells = volume.cell_count() as f64;
        let per_cell = stats.bytes_per_cell.expect("counted");
        assert!(stats.bytes_resident as f64 >= per_cell * cells);
        per_cell
    };
    let at_vertices = ExitSearch::PerVertex;
    assert_eq!(bytes(at_vertices, CellLayout::TwelveFloats), 720.0);
    assert_eq!(bytes(at_vertices, CellLayout::TwelveShorts), 456.0);
    // Four indices per cell, and three coordinates and a scalar for each vertex, of which
    // there is one for every four to six cells.
    for exit in [at_vertices, ExitSearch::PerFragment] {
        let shared = bytes(exit, CellLayout::SharedVertices);
        assert!((18.0..=64.0).contains(&shared), "{shared}");
    }
}

#[test]
fn what_cannot_be_had_together_is_refused() {
    let Some(gpu) = testing::gpu("what_cannot_be_had_together_is_refused") else {
        return;
    };
    let (volume, transfer_function) = scene("sphere", 500);
    let sorted = Appearance::new(transfer_function, OpticalModel::EmissionAbsorption);
    let refused = |options: &ProjectionOptions, appearance: &Appearance| {
        let error = CellProjection::new(&gpu, &volume, appearance, options).expect_err("refused");
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    };
    refused(
        &options(ExitSearch::PerFragment, CellLayout::TwelveFloats),
        &sorted,
    );
    let at_vertices = options(ExitSearch::PerVertex, CellLayout::SharedVertices);
    let per_pixel = ProjectionOptions {
        order: Order::PerPixel,
        ..at_vertices.clone()
    };
    refused(&per_pixel, &sorted);
    let surfaces = Appearance {
        optical_model: OpticalModel::Isosurfaces,
        ..sorted.clone()
    };
    refused(&at_vertices, &surfaces);
    let renderer = CellProjection::new(&gpu, &volume, &sorted, &at_vertices).expect("it fits");
    let error = renderer
        .render(&crooked(&volume, false, 96))
        .expect_err("refused");
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    let many = ProjectionOptions {
        exit_search: ExitSearch::PerVertexTexture,
        minimum_side: 1,
        ..at_vertices
    };
    let error = CellProjection::new(&gpu, &volume, &sorted, &many).expect_err("one sample");
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
}
