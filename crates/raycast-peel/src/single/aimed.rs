//! Rays aimed at what breaks other walks (`hard_ray` of `tetrascope-testing`). None may be lost.

use tetrascope_core::glam::{DAffine3, DVec3, Vec3};
use tetrascope_core::{Knot, OpticalModel, TransferFunction, View, VolumeRenderer as _};
use tetrascope_f32::Rays;
use tetrascope_f32::look::look;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::BufferUsages;
use tetrascope_gpu::{ComputeProgram, read_back};
use tetrascope_testing::{self as testing, HARD_MESHES, HardMesh, Random, hard_ray};

use super::style::constants;
use super::*;
use crate::RaycastPeel;
use crate::counters::LOST_RAYS;

/// Rays in one dispatch.
const BATCH: usize = 1 << 16;

/// One ray of `aim.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Aim {
    anchor: [f32; 4],
    direction: [f32; 4],
}

/// Counts of rays by their fate.
#[derive(Debug, Default)]
struct Sum {
    rays: u64,
    visits: u64,
    paths: u64,
    unpaired: u64,
    lost: u64,
}

/// Sends `batches` batches of rays through a mesh.
fn shoot(gpu: &Gpu, kind: &HardMesh, batches: u64, integer_sides: bool, seed: u64) -> Sum {
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::ZERO,
        extinction: 0.0,
    };
    let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid knots");
    let appearance = Appearance::new(function, OpticalModel::Absorption);
    let source = kind.mesh();
    let volume = Volume::Mesh(source.clone());
    let options = RaycastOptions {
        integer_sides,
        ..RaycastOptions::default()
    };
    let single = Single::new(gpu, &volume, &appearance, &options).expect("a mesh");
    let normalization = &single.mesh.normalization;
    let mut constants = constants(gpu, &single.mesh, &appearance, &options).expect("constants");
    constants.extend(Budget::new(&appearance).expect("few").constants());
    let points: Vec<Vec3> = source
        .points()
        .iter()
        .map(|&point| normalization.position(point))
        .collect();

    let device = gpu.device();
    let pipeline = gpu.compute_pipeline(&ComputeProgram {
        label: "aim",
        source: tetrascope_shaders::raycast_peel::AIM,
        entry: Some("cs_aim"),
        constants,
        ..Default::default()
    });
    let pipeline = pipeline.expect("compiles");
    let group = |index: u32, resources: &[(u32, wgpu::BindingResource)]| {
        let entries: Vec<_> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("aim"),
            layout: &pipeline.get_bind_group_layout(index),
            entries: &entries,
        })
    };
    // One tile with every boundary face: where it begins and ends, then the faces.
    let faces = single.mesh.layout.boundary.len() as u32;
    let lists: Vec<u32> = [2, 2 + faces].into_iter().chain(0..faces).collect();
    let view = View {
        camera: tetrascope_core::Camera::fit(
            &source.bounds(),
            tetrascope_core::CameraFit::PlusX,
            true,
            1.0,
        ),
        width: 1,
        height: 1,
        background: [0.0; 4],
    };
    let rays = Rays::new(&view, normalization);
    let (look, items) = look(
        &appearance,
        &view,
        &source.bounds(),
        normalization,
        &single.mesh.scalar_map,
        &DAffine3::IDENTITY,
    );
    let storage = BufferUsages::STORAGE;
    let uniform = BufferUsages::UNIFORM;
    let march = gpu
        .upload("aim", &[single.march(&view, &rays)], storage)
        .expect("small");
    let lists = gpu.upload("aim", &lists, storage).expect("small");
    let look = gpu.upload("aim", &[look], uniform).expect("small");
    let items = gpu.upload("aim", &items, storage).expect("small");
    let layers = layers::none(gpu).expect("small");
    let bytes = (BATCH * 16) as u64;
    let traces = gpu.buffer("aim", bytes, storage | BufferUsages::COPY_SRC);
    let traces = traces.expect("small");
    let textures = single.mesh.textures();
    let views = textures.map(|texture| texture.create_view(&Default::default()));
    let volume: Vec<_> = (0..)
        .zip(views.iter().map(wgpu::BindingResource::TextureView))
        .collect();
    let intervals = single.style.intervals.create_view(&Default::default());
    let mut random = Random(seed);
    let mut sum = Sum::default();
    for _ in 0..batches {
        let aims: Vec<Aim> = (0..BATCH)
            .map(|_| {
                let ray = hard_ray(&mut random, &points, source.tetrahedra());
                let [anchor, direction] = ray.map(|v| v.extend(0.0).to_array());
                Aim { anchor, direction }
            })
            .collect();
        let aims = gpu.upload("aim", &aims, storage).expect("small");
        let groups = [
            group(
                0,
                &[
                    (0, march.as_entire_binding()),
                    (3, lists.as_entire_binding()),
                    (5, look.as_entire_binding()),
                    (6, items.as_entire_binding()),
                    (7, wgpu::BindingResource::TextureView(&layers)),
                ],
            ),
            group(1, &volume),
            group(
                2,
                &[
                    (0, wgpu::BindingResource::TextureView(&intervals)),
                    (1, single.style.table.binding()),
                ],
            ),
            group(
                3,
                &[
                    (2, aims.as_entire_binding()),
                    (3, traces.as_entire_binding()),
                ],
            ),
        ];
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        for (index, group) in (0..).zip(&groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(BATCH as u32 / 64, 1, 1);
        drop(pass);
        let traces = read_back(gpu, &mut encoder, Source::Buffer(&traces, bytes)).expect("small");
        gpu.finish(encoder).expect("runs");
        for [visits, paths, unpaired, lost] in traces.read::<[u32; 4]>().expect("readable") {
            sum.rays += 1;
            sum.visits += u64::from(visits);
            sum.paths += u64::from(paths);
            sum.unpaired += u64::from(unpaired != 0);
            sum.lost += u64::from(lost);
        }
    }
    sum
}

/// All kinds of meshes; panics where a ray is lost.
fn shoot_all(gpu: &Gpu, batches: u64, integer_sides: bool, seed: u64) -> u64 {
    let mut rays = 0;
    for kind in HARD_MESHES.iter().chain([&HardMesh::random(seed)]) {
        let sum = shoot(gpu, kind, batches, integer_sides, seed);
        assert_eq!((sum.lost, sum.unpaired), (0, 0), "{}: {sum:?}", kind.name);
        // They did go through: every ray is aimed at the mesh.
        assert!(sum.paths > sum.rays / 2, "{}: {sum:?}", kind.name);
        assert!(sum.visits > 2 * sum.rays, "{}: {sum:?}", kind.name);
        rays += sum.rays;
    }
    rays
}

#[test]
fn no_ray_is_lost() {
    let Some(gpu) = testing::gpu("no_ray_is_lost") else {
        return;
    };
    let rays = shoot_all(&gpu, 2, false, 1);
    assert!(rays > 1_000_000);
}

#[test]
fn no_ray_is_lost_by_comparing_integers() {
    let Some(gpu) = testing::gpu("no_ray_is_lost_by_comparing_integers") else {
        return;
    };
    shoot_all(&gpu, 1, true, 2);
}

/// 10⁸ rays, if not told otherwise ([`testing::cast_many`]).
#[test]
#[ignore = "takes long; run with --ignored"]
fn no_ray_of_many_is_lost() {
    let Some(gpu) = testing::gpu("no_ray_of_many_is_lost") else {
        return;
    };
    testing::cast_many(100_000_000, |seed| shoot_all(&gpu, 8, false, seed));
}

/// The walk does not depend on how products are compared: the same picture, bit by bit.
#[test]
fn integers_decide_as_floats_do() {
    let Some(gpu) = testing::gpu("integers_decide_as_floats_do") else {
        return;
    };
    let mesh = HARD_MESHES[5].mesh();
    let count = mesh.points().len();
    let field = testing::point_scalars((0..count).map(|i| i as f64 / count as f64).collect());
    let volume = Volume::Mesh(mesh.with_scalars(field).expect("as many values"));
    let knot = |scalar, extinction| Knot {
        scalar,
        color: DVec3::ONE,
        extinction,
    };
    let function =
        TransferFunction::new(vec![knot(0.0, 0.0), knot(1.0, 1.0)]).expect("valid knots");
    let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
    let bounds = volume.bounds();
    let view = View {
        camera: tetrascope_core::Camera::fit(&bounds, tetrascope_core::CameraFit::PlusZ, true, 1.0),
        width: 48,
        height: 48,
        background: [0.0; 4],
    };
    let draw = |integer_sides| {
        let options = RaycastOptions {
            integer_sides,
            ..RaycastOptions::default()
        };
        let renderer = RaycastPeel::new(&gpu, &volume, &appearance, &options);
        renderer.expect("a mesh").render(&view).expect("a frame")
    };
    let (floats, integers) = (draw(false), draw(true));
    assert!(floats.pixels == integers.pixels);
    assert_eq!(floats.stats.get(LOST_RAYS), Some(0));
}
