//! Isosurfaces against the ground truth, in any order of cells, and among other geometry.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::{DMat4, DVec3, DVec4};
use tetrascope_core::{
    Appearance, Camera, CameraFit, DirectionalLight, Frame, Isosurface, Knot, Lighting,
    OpticalModel, Projection, TetMesh, TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{self, CompareFunction, TextureFormat, TextureUsages};
use tetrascope_gpu::{Draw as _, Gpu, Over, SceneDepth, Target, read_back};
use tetrascope_projection::counters::CELLS_SKIPPED;
use tetrascope_projection::{CellProjection, ProjectionOptions, SurfaceSearch};
use tetrascope_testing::{self as testing, is_near_explained};

use crate::common::mesh;

/// Surfaces at these scalars, each of its own color, under two lights.
fn surfaces(values: &[f64]) -> Appearance {
    let knot = Knot {
        scalar: 0.0,
        color: DVec3::ONE,
        extinction: 1.0,
    };
    let function = TransferFunction::new(vec![knot]).expect("one knot");
    let mut appearance = Appearance::new(function, OpticalModel::Isosurfaces);
    let colors = [[1.0, 0.3, 0.1], [0.2, 0.5, 1.0], [0.3, 0.9, 0.2]];
    let surfaces = values.iter().zip(colors.into_iter().cycle());
    appearance.isosurfaces = surfaces
        .map(|(&value, color)| Isosurface {
            value,
            color: color.into(),
        })
        .collect();
    let light = |toward: [f64; 3], color: [f64; 3]| DirectionalLight {
        toward: toward.into(),
        color: color.into(),
    };
    appearance.lighting = Lighting {
        ambient: 0.15,
        lights: vec![
            light([1.0, 2.0, 3.0], [0.7, 0.6, 0.5]),
            light([-2.0, 1.0, -1.0], [0.2, 0.3, 0.6]),
        ],
    };
    appearance
}

/// Surfaces at these shares of the range of `volume`.
fn shares(volume: &Volume, shares: &[f64]) -> Appearance {
    let (low, high) = volume.scalar_range().expect("a field");
    let values: Vec<f64> = shares.iter().map(|s| low + s * (high - low)).collect();
    surfaces(&values)
}

/// Both projections from outside, and from inside, where cells are around the eye.
fn views(volume: &Volume) -> [View; 4] {
    let bounds = volume.bounds();
    let inside = Camera {
        position: bounds.center() + bounds.size() * DVec3::new(0.11, 0.07, 0.13),
        focal_point: bounds.center() - bounds.size() * DVec3::new(0.3, 0.2, 0.1),
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle: 70.0 },
    };
    let plane_inside = Camera {
        projection: Projection::Orthographic {
            parallel_scale: 0.3 * bounds.diagonal(),
        },
        ..inside
    };
    [
        Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0),
        Camera::fit(&bounds, CameraFit::MinusIso, true, 1.0),
        inside,
        plane_inside,
    ]
    .map(|camera| View {
        camera,
        width: 48,
        height: 48,
        background: [0.1, 0.2, 0.3, 0.5],
    })
}

fn projection(gpu: &Gpu, volume: &Volume, appearance: &Appearance) -> CellProjection {
    let options = ProjectionOptions::default();
    CellProjection::new(gpu, volume, appearance, &options).expect("it fits")
}

fn depths(frame: &Frame) -> &[f32] {
    frame.depths.as_ref().expect("surfaces have depths")
}

/// Holds each pixel of `frame` to the truth, but for outlines; how many show a surface.
fn check(name: &str, volume: &Volume, appearance: &Appearance, view: &View, frame: &Frame) -> u32 {
    let reference = testing::truth(volume, appearance);
    let truth = reference.render(view).expect("a frame");
    let size = volume.bounds().diagonal() as f32;
    let (mut hits, mut outliers) = (0, 0);
    for (i, (got, want)) in frame.pixels.iter().zip(&truth.pixels).enumerate() {
        let (depth, true_depth) = (depths(frame)[i], depths(&truth)[i]);
        let same_depth = depth.is_infinite() == true_depth.is_infinite()
            && (depth.is_infinite() || (depth - true_depth).abs() <= 1e-4 * size);
        let off = (0..4).map(|c| (got[c] - want[c]).abs()).fold(0.0, f32::max);
        hits += u32::from(depth.is_finite());
        // 2⁻²⁴ of the mesh's size over the height of the thinnest cells.
        if off > 1e-3 || !same_depth {
            outliers += 1;
            assert!(
                is_near_explained(&reference, view, i, *got),
                "{name}, pixel {i}: {got:?} {depth}, truth {want:?} {true_depth}"
            );
        }
    }
    eprintln!("{name}: {hits} hits, {outliers} on outlines");
    assert!(outliers * 100 <= hits, "{name}: {outliers} of {hits}");
    hits
}

#[test]
fn surfaces_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("surfaces_agree_with_the_reference") else {
        return;
    };
    for (name, cells) in [
        ("sphere", 3000),
        ("orbital", 3000),
        ("torus", 2000),
        ("graded", 2000),
    ] {
        let volume = mesh(name, cells);
        let appearance = shares(&volume, &[0.717, 0.231, 0.489]);
        let renderer = projection(&gpu, &volume, &appearance);
        let mut hits = 0;
        for view in views(&volume) {
            let frame = renderer.render(&view).expect("a frame");
            hits += check(name, &volume, &appearance, &view, &frame);
        }
        assert!(hits > 1000, "{name}: {hits}");
    }
}

// The sphere's field is the distance from its middle: |origin + t direction| = r.
#[test]
fn spheres_are_where_they_should_be() {
    let Some(gpu) = testing::gpu("spheres_are_where_they_should_be") else {
        return;
    };
    let volume = mesh("sphere", 20_000);
    let radius = 0.8;
    let renderer = projection(&gpu, &volume, &surfaces(&[radius]));
    // A lattice of 16³ cubes of side 1/8. The distance is interpolated between vertices
    // up to d = √3/8 apart, so it is too great by up to d²/(8 r) (its second derivative
    // is 1/r across and 0 along), and as much too small is the sphere.
    let sag = (3.0 / 64.0) / (8.0 * radius);
    for view in &views(&volume)[..2] {
        let frame = renderer.render(view).expect("a frame");
        let mut hits = 0;
        for (i, &depth) in depths(&frame).iter().enumerate() {
            let (column, row) = (i as u32 % view.width, i as u32 / view.width);
            let at = |pixel: u32, size: u32| 2.0 * (f64::from(pixel) + 0.5) / f64::from(size) - 1.0;
            let (x, y) = (at(column, view.width), -at(row, view.height));
            let ray = view.camera.ray(x, y, 1.0);
            if depth.is_infinite() {
                let nearest = ray.origin.reject_from(ray.direction).length();
                assert!(
                    nearest > radius - 2.0 * sag,
                    "a hole at {column}, {row}: {nearest}"
                );
                continue;
            }
            hits += 1;
            let met = ray.at(depth.into()).length();
            let off = (radius - met) / sag;
            assert!((-1e-3..=1.001).contains(&off), "{column}, {row}: {met}");
        }
        assert!(hits > 200, "{hits}");
    }
}

#[test]
fn cells_may_come_in_any_order() {
    let Some(gpu) = testing::gpu("cells_may_come_in_any_order") else {
        return;
    };
    let volume = mesh("torus", 2000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a mesh");
    };
    let appearance = shares(&volume, &[0.2, 0.4, 0.6, 0.8]);
    // Another order, and each cell's vertices in another even permutation.
    let mut cells: Vec<[u32; 4]> = mesh.tetrahedra().to_vec();
    cells.reverse();
    let third = cells.len() / 3;
    cells.rotate_left(third);
    for (cell, i) in cells.iter_mut().zip(0..) {
        cell[..3].rotate_left(i % 3);
    }
    let points = mesh.points().to_vec();
    let other = TetMesh::from_tetrahedra(points, cells, mesh.scalars().clone());
    let other = Volume::Mesh(other.expect("the same mesh"));
    for view in views(&volume) {
        let first = projection(&gpu, &volume, &appearance).render(&view);
        let second = projection(&gpu, &other, &appearance).render(&view);
        let (first, second) = (first.expect("a frame"), second.expect("a frame"));
        // Which surface is met where is the same to the last bit; normals of cells whose
        // vertices have changed places may round otherwise, by a few 2⁻²⁴ over the
        // height of the thinnest.
        assert_eq!(depths(&first), depths(&second));
        for (a, b) in first.pixels.iter().zip(&second.pixels) {
            let off = (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
            assert!(off <= 1e-4, "{a:?} {b:?}");
        }
    }
}

/// A cube of lattice cells in five tetrahedra each, with x as its field.
fn slab(side: u32) -> Volume {
    let mesh = testing::data_set("sphere", Some(u64::from(5 * side.pow(3))));
    let values = mesh.points().iter().map(|p| p.x).collect();
    let mesh = mesh.with_scalars(testing::point_scalars(values));
    Volume::Mesh(mesh.expect("one a point"))
}

// The worst place for a surface: on the faces between cells, where the cells on both
// sides must agree about every bit.
#[test]
fn a_surface_on_faces_has_no_gaps() {
    let Some(gpu) = testing::gpu("a_surface_on_faces_has_no_gaps") else {
        return;
    };
    let volume = slab(6);
    let bounds = volume.bounds();
    // Of the lattice in [−1, 1]³ by thirds.
    let value = 1.0 / 3.0;
    let appearance = surfaces(&[value]);
    let renderer = projection(&gpu, &volume, &appearance);
    for (side, orthographic) in [
        (CameraFit::PlusX, true),
        (CameraFit::MinusX, true),
        (CameraFit::PlusX, false),
        (CameraFit::MinusX, false),
    ] {
        let camera = Camera::fit(&bounds, side, orthographic, 1.0);
        let tilt = bounds.diagonal() * DVec3::new(0.0, 0.171, 0.093);
        let view = View {
            camera: Camera {
                position: camera.position + tilt,
                ..camera
            },
            width: 64,
            height: 64,
            background: [0.0; 4],
        };
        let frame = renderer.render(&view).expect("a frame");
        let mut hits = 0;
        for (i, depth) in depths(&frame).iter().enumerate() {
            let (column, row) = (i as u32 % view.width, i as u32 / view.width);
            let x = 2.0 * (f64::from(column) + 0.5) / 64.0 - 1.0;
            let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / 64.0;
            let ray = view.camera.ray(x, y, 1.0);
            let t = (value - ray.origin.x) / ray.direction.x;
            let met = ray.at(t);
            // Inside the cube, and not on its rim, which f32 moves by 2⁻²³.
            let reach = met.y.abs().max(met.z.abs());
            if reach < 1.0 - 1e-5 {
                hits += 1;
                let off = (f64::from(*depth) - t).abs();
                assert!(off < 1e-5, "{side:?} {column}, {row}: {depth}, not {t}");
            }
        }
        assert!(hits > 500, "{hits}");
    }
}

#[test]
fn the_table_errs_by_its_samples_and_thickness_closes_gaps() {
    let Some(gpu) = testing::gpu("the_table_errs_by_its_samples_and_thickness_closes_gaps") else {
        return;
    };
    let volume = mesh("sphere", 3000);
    let appearance = shares(&volume, &[0.231, 0.489]);
    let [view, ..] = views(&volume);
    let drawn = |surfaces| {
        let options = ProjectionOptions {
            surfaces,
            ..ProjectionOptions::default()
        };
        let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
        renderer.render(&view).expect("a frame")
    };
    let exact = drawn(SurfaceSearch::Exact);
    let compare = |n, thickness| {
        let frame = drawn(SurfaceSearch::Table { n, thickness });
        let (mut missing, mut moved, mut added) = (0, 0, 0);
        for (got, want) in depths(&frame).iter().zip(depths(&exact)) {
            missing += u32::from(got.is_infinite() && want.is_finite());
            added += u32::from(got.is_finite() && want.is_infinite());
            moved += u32::from(got.is_finite() && want.is_finite() && (got - want).abs() > 1e-5);
        }
        eprintln!(
            "{n} samples, {thickness} thick: {missing} missing, {added} added, {moved} moved"
        );
        [missing, moved, added]
    };
    // A texel stands for scalars within half a sample, so with half a sample or more of
    // thickness no crossing is lost; without any, some are.
    let [gaps, ..] = compare(64, 0.0);
    assert!(gaps > 0, "a table without thickness has gaps");
    let errors = [64, 256, 1024].map(|n| {
        let [missing, moved, added] = compare(n, 1.0);
        assert_eq!(missing, 0, "{n}");
        moved + added
    });
    // What is added and moved is what is within a sample and a half of a surface's value
    // and does not cross it: a share of the pixels that goes with 1/n.
    assert!(errors[0] > errors[2], "{errors:?}");
    assert!(2 * errors[2] <= errors[0], "{errors:?}");
    for wrong in [(1, 1.0), (4096, 1.0), (64, -1.0), (64, f32::NAN)] {
        let options = ProjectionOptions {
            surfaces: SurfaceSearch::Table {
                n: wrong.0,
                thickness: wrong.1,
            },
            ..ProjectionOptions::default()
        };
        assert!(CellProjection::new(&gpu, &volume, &appearance, &options).is_err());
    }
}

/// A device with a target that an application has drawn a quadrilateral into.
struct Application {
    color: wgpu::Texture,
    depth: wgpu::Texture,
}

const TARGET: TextureFormat = TextureFormat::Rgba32Float;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
const QUAD: [f32; 4] = [0.9, 0.8, 0.1, 1.0];

impl Application {
    /// Draws the two triangles of `corners`, world space, around the quadrilateral.
    fn draw(
        gpu: &Gpu,
        size: (u32, u32),
        clip_from_world: DMat4,
        corners: [DVec3; 4],
        compare: CompareFunction,
    ) -> Self {
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let color = gpu.texture("color", size, TARGET, drawn | TextureUsages::COPY_SRC);
        let depth = gpu.texture("depth", size, DEPTH, drawn);
        let application = Application {
            color: color.expect("it fits"),
            depth: depth.expect("it fits"),
        };
        let place = |i: usize| {
            let clip = clip_from_world * corners[i].extend(1.0);
            format!(
                "vec4f({:?}, {:?}, {:?}, {:?})",
                clip.x as f32, clip.y as f32, clip.z as f32, clip.w as f32
            )
        };
        let places = [0, 1, 2, 0, 2, 3].map(place).join(", ");
        let source = format!(
            "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {{
                var places = array<vec4f, 6>({places});
                return places[i];
            }}
            @fragment fn fs() -> @location(0) vec4f {{ return vec4f({:?}, {:?}, {:?}, 1.0); }}",
            QUAD[0], QUAD[1], QUAD[2]
        );
        let device = gpu.device();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("quad"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("quad"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: Default::default(),
                targets: &[Some(TARGET.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let color_view = application.color.create_view(&Default::default());
        let depth_view = application.depth.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("quad"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(far_depth(compare)),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.draw(0..6, 0..1);
        drop(pass);
        gpu.finish(encoder).expect("a quadrilateral");
        application
    }
}

/// The depth in an empty depth buffer.
fn far_depth(compare: CompareFunction) -> f32 {
    match compare {
        CompareFunction::Greater => 0.0,
        _ => 1.0,
    }
}

/// As an application makes it: depth 0 at the near plane, 1/20 before the eye, and 1 at
/// the far plane, 100 before it; the other way around where greater depths are nearer.
fn clip_from_world(camera: &Camera, compare: CompareFunction) -> DMat4 {
    let (right, up, forward) = camera.axes();
    let (near, far) = (0.05, 100.0);
    let row = |axis: DVec3, scale: f64| (scale * axis).extend(-scale * axis.dot(camera.position));
    let slope = 1.0 / (far - near);
    let (reach, depth, w) = match camera.projection {
        Projection::Perspective { view_angle } => {
            let reach = (view_angle.to_radians() / 2.0).tan();
            (reach, far * slope, row(forward, 1.0))
        }
        Projection::Orthographic { parallel_scale } => (parallel_scale, slope, DVec4::W),
    };
    let z = row(forward, depth) - near * depth * DVec4::W;
    let z = match compare {
        CompareFunction::Greater => w - z,
        _ => z,
    };
    DMat4::from_cols(row(right, 1.0 / reach), row(up, 1.0 / reach), z, w).transpose()
}

#[test]
fn surfaces_hide_and_are_hidden_by_other_geometry() {
    let Some(gpu) = testing::gpu("surfaces_hide_and_are_hidden_by_other_geometry") else {
        return;
    };
    let volume = mesh("sphere", 3000);
    let bounds = volume.bounds();
    let appearance = surfaces(&[0.8]);
    // A plane that cuts off a part of the sphere toward the eye, wider than the image.
    let middle = 0.5 * DVec3::ONE.unit();
    let normal = DVec3::new(0.3, 0.2, 1.0).unit();
    let across = normal.cross(DVec3::X).unit();
    let along = normal.cross(across);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(a, b)| middle + 20.0 * (a * across + b * along));
    let (less, greater) = (CompareFunction::Less, CompareFunction::Greater);
    for (orthographic, compare) in [
        (false, less),
        (true, less),
        (false, greater),
        (true, greater),
    ] {
        let camera = Camera::fit(&bounds, CameraFit::PlusIso, orthographic, 1.0);
        let view = View {
            camera,
            width: 64,
            height: 64,
            background: [0.0; 4],
        };
        let clip_from_world = clip_from_world(&camera, compare);
        let application = Application::draw(&gpu, (64, 64), clip_from_world, corners, compare);
        let renderer = projection(&gpu, &volume, &appearance);
        let alone = renderer.render(&view).expect("a frame");
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let target = application.color.create_view(&Default::default());
        let depth = SceneDepth {
            texture: &application.depth,
            clip_from_world,
        };
        let target = Target {
            over: Over::WhatIsThere,
            depth: Some(depth),
            ..Target::new(&target, TARGET)
        };
        let recorded = renderer.encode(&mut encoder, &view, &target);
        let copy = read_back(&gpu, &mut encoder, Source::Texture(&application.color));
        gpu.finish(encoder).expect("nothing can fail");
        assert!(recorded.expect("recorded").statistics().is_ok());
        let pixels: Vec<[f32; 4]> = copy.expect("a copy").read().expect("readable");
        let (mut before, mut behind) = (0, 0);
        for (i, pixel) in pixels.iter().enumerate() {
            let (column, row) = (i % 64, i / 64);
            let x = 2.0 * (column as f64 + 0.5) / 64.0 - 1.0;
            let y = 1.0 - 2.0 * (row as f64 + 0.5) / 64.0;
            let ray = view.camera.ray(x, y, 1.0);
            let quad = (middle - ray.origin).dot(normal) / ray.direction.dot(normal);
            let depth = f64::from(depths(&alone)[i]);
            // A depth buffer of f32 with a near plane at 1/20 resolves some 2⁻²⁴ · 20 z², 4e-5
            // at the 6 units that the camera is away.
            if (depth - quad).abs() < 1e-3 {
                continue;
            }
            let expected = if depth < quad { alone.pixels[i] } else { QUAD };
            before += u32::from(depth < quad);
            behind += u32::from(depth.is_finite() && depth > quad);
            assert_eq!(
                *pixel, expected,
                "{column}, {row}: {depth}, quadrilateral at {quad}"
            );
        }
        eprintln!("{before} pixels before the quadrilateral, {behind} behind");
        assert!(before > 100 && behind > 100, "{before} {behind}");
    }
}

#[test]
fn targets_that_do_not_fit_are_refused() {
    let Some(gpu) = testing::gpu("targets_that_do_not_fit_are_refused") else {
        return;
    };
    let volume = mesh("sphere", 40);
    let [view, ..] = views(&volume);
    let renderer = projection(&gpu, &volume, &surfaces(&[0.8]));
    let size = (view.width, view.height);
    let texture = |(width, height), format| {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let texture = gpu.texture("the application's", (width, height), format, usage);
        texture.expect("it fits")
    };
    let refused = |color: &wgpu::Texture, over, depth: Option<(&wgpu::Texture, DMat4)>| {
        let color_view = color.create_view(&Default::default());
        let target = Target {
            over,
            depth: depth.map(|(texture, clip_from_world)| SceneDepth {
                texture,
                clip_from_world,
            }),
            ..Target::new(&color_view, color.format())
        };
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let refused = renderer.encode(&mut encoder, &view, &target).err();
        refused.expect("it does not fit").to_string()
    };
    let color = texture(size, TARGET);
    let less = texture((size.0 - 1, size.1), TARGET);
    assert!(refused(&less, Over::Background, None).contains("47x48"));
    let whole = texture(size, wgpu::TextureFormat::Rgba8Uint);
    assert!(refused(&whole, Over::Background, None).contains("Rgba8Uint"));
    let depth = texture(size, DEPTH);
    let flat = DMat4::from_diagonal(DVec4::new(1.0, 1.0, 0.0, 1.0));
    let depths = Some((&depth, flat));
    assert!(refused(&color, Over::WhatIsThere, depths).contains("no inverse"));
    let depths = Some((&color, DMat4::IDENTITY));
    assert!(refused(&color, Over::WhatIsThere, depths).contains("no depth"));
    let small = texture((size.0, 7), DEPTH);
    let depths = Some((&small, DMat4::IDENTITY));
    assert!(refused(&color, Over::WhatIsThere, depths).contains("48x7"));
}

#[test]
fn volume_and_surfaces_follow_each_other() {
    let Some(gpu) = testing::gpu("volume_and_surfaces_follow_each_other") else {
        return;
    };
    let volume = mesh("sphere", 1000);
    let surfaces = shares(&volume, &[0.3, 0.6]);
    let volumetric = Appearance {
        optical_model: OpticalModel::EmissionAbsorption,
        ..surfaces.clone()
    };
    let [view, ..] = views(&volume);
    let mut renderer = projection(&gpu, &volume, &volumetric);
    let before = renderer.render(&view).expect("a frame");
    assert!(before.depths.is_none());
    renderer.restyle(&surfaces).expect("surfaces");
    let frame = renderer.render(&view).expect("a frame");
    assert!(check("restyled", &volume, &surfaces, &view, &frame) > 100);
    let skipped = frame.stats.get(CELLS_SKIPPED).expect("counted");
    assert!(skipped > 0, "cells without a surface are not drawn");
    renderer.restyle(&volumetric).expect("a volume");
    let after = renderer.render(&view).expect("a frame");
    assert!(after.pixels == before.pixels && after.depths.is_none());
}
