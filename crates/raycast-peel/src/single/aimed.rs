//! Rays aimed at what breaks other walks: vertices, edges, along faces, in meshes whose
//! cells are flat or inverted. None may be lost.
//!
//! The meshes are those on which published walks were measured to lose up to all rays
//! along an axis: cubes of six tetrahedra, exact or jittered, near and far from the
//! origin, and in layers so thin that jitter turns cells inside out.

use tetrascope_core::glam::{DAffine3, DVec3, Vec3};
use tetrascope_core::{Knot, OpticalModel, TransferFunction, View, VolumeRenderer as _};
use tetrascope_f32::Rays;
use tetrascope_f32::look::look;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::BufferUsages;
use tetrascope_gpu::{ComputeProgram, read_back};
use tetrascope_testing as testing;

use super::style::constants;
use super::*;
use crate::RaycastPeel;
use crate::counters::LOST_RAYS;

/// Cubes along each side of a mesh.
const CUBES: usize = 3;

/// Rays in one dispatch.
const BATCH: usize = 1 << 16;

/// A sequence of numbers without pattern (Marsaglia 2003, xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    fn below(&mut self, count: usize) -> usize {
        self.next() as usize % count
    }

    /// In [−1, 1].
    fn signed(&mut self) -> f64 {
        f64::from(self.next()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// A kind of mesh.
struct Kind {
    name: &'static str,
    /// By how much vertices are moved, in cubes.
    jitter: f64,
    /// How far from the origin, in cubes.
    offset: f64,
    /// The thickness of every other layer, in cubes.
    thickness: f64,
    /// A cube in the middle is left out.
    cavity: bool,
}

const PLAIN: Kind = Kind {
    name: "structured",
    jitter: 0.0,
    offset: 0.0,
    thickness: 1.0,
    cavity: false,
};

const KINDS: [Kind; 9] = [
    PLAIN,
    Kind {
        name: "structured with a cavity",
        cavity: true,
        ..PLAIN
    },
    Kind {
        name: "jittered",
        jitter: 0.2,
        ..PLAIN
    },
    Kind {
        name: "jittered, at 1e5",
        jitter: 0.2,
        offset: 1e5,
        ..PLAIN
    },
    Kind {
        name: "structured, at 1e6",
        offset: 1e6,
        ..PLAIN
    },
    Kind {
        name: "jittered until cells turn inside out",
        jitter: 0.9,
        cavity: true,
        ..PLAIN
    },
    Kind {
        name: "layers of 1e-4",
        jitter: 1e-5,
        thickness: 1e-4,
        ..PLAIN
    },
    // Thinner than f32 resolves, and jittered by as much: flat and inverted cells.
    Kind {
        name: "layers of 1e-6",
        jitter: 1e-6,
        thickness: 1e-6,
        ..PLAIN
    },
    Kind {
        name: "layers of no thickness",
        thickness: 0.0,
        ..PLAIN
    },
];

fn mesh(kind: &Kind) -> TetMesh {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let side = CUBES + 1;
    let height = |k: usize| {
        let (pairs, rest) = (k / 2, k % 2);
        pairs as f64 * (1.0 + kind.thickness) + rest as f64 * kind.thickness
    };
    let mut points = Vec::new();
    for place in 0..side * side * side {
        let [i, j, k] = [place % side, place / side % side, place / (side * side)];
        let at = DVec3::new(i as f64, j as f64, height(k));
        points.push(at + kind.jitter * random.vector() + kind.offset);
    }
    let tetrahedra = testing::kuhn_cells(CUBES, |at| !kind.cavity || at != [CUBES / 2; 3]);
    let scalars = testing::point_scalars(vec![0.0; points.len()]);
    TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a mesh")
}

/// One ray of `aim.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Aim {
    anchor: [f32; 4],
    direction: [f32; 4],
}

/// A ray that is hard to follow through a mesh with vertices at `points` and these cells.
fn aim(random: &mut Random, points: &[Vec3], cells: &[[u32; 4]]) -> Aim {
    let cell = cells[random.below(cells.len())];
    let first = random.below(4);
    let [a, b, c, _] = [0, 1, 2, 3].map(|i| points[cell[(first + i) % 4] as usize]);
    // At a vertex, an edge, a face; exactly but for the rounding of the mean.
    let anchor = match random.below(4) {
        0 | 1 => a,
        2 => (a + b) / 2.0,
        _ => (a + b + c) / 3.0,
    };
    let axis = [Vec3::X, Vec3::Y, Vec3::Z][random.below(3)];
    let direction = match random.below(8) {
        // Along the lattice: in faces and along edges of cubes.
        0 | 1 => axis,
        2 => Vec3::ONE - axis,
        3 => Vec3::ONE,
        // Along the edge, in the face, to a vertex elsewhere.
        4 => b - a,
        5 => (b - a) + (c - a) * random.signed() as f32,
        6 => points[random.below(points.len())] - anchor,
        _ => random.vector().as_vec3(),
    };
    // Any direction will do where two vertices are in one place.
    let direction = if direction == Vec3::ZERO {
        axis
    } else {
        direction
    };
    Aim {
        anchor: anchor.extend(0.0).to_array(),
        direction: direction.extend(0.0).to_array(),
    }
}

/// What rays did.
#[derive(Debug, Default)]
struct Sum {
    rays: u64,
    visits: u64,
    paths: u64,
    unpaired: u64,
    lost: u64,
}

/// Sends `batches` batches of rays through a mesh.
fn shoot(gpu: &Gpu, kind: &Kind, batches: u64, integer_sides: bool, seed: u64) -> Sum {
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::ZERO,
        extinction: 0.0,
    };
    let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid knots");
    let appearance = Appearance::new(function, OpticalModel::Absorption);
    let source = mesh(kind);
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
            .map(|_| aim(&mut random, &points, source.tetrahedra()))
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
    for kind in &KINDS {
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

/// As many rays as the environment variable TETRASCOPE_RAYS says, 10⁸ without it: minutes
/// on a GPU, an hour on a software adapter.
#[test]
#[ignore = "takes long; run with --ignored"]
fn no_ray_of_many_is_lost() {
    let Some(gpu) = testing::gpu("no_ray_of_many_is_lost") else {
        return;
    };
    let wanted = std::env::var("TETRASCOPE_RAYS").map_or(1e8, |n| n.parse().expect("a number"));
    let mut rays = 0;
    let mut seed = 1000;
    while (rays as f64) < wanted {
        rays += shoot_all(&gpu, 8, false, seed);
        seed += 1;
        eprintln!("{rays} rays, none lost");
    }
}

/// The walk does not depend on how products are compared: the same picture, bit by bit.
#[test]
fn integers_decide_as_floats_do() {
    let Some(gpu) = testing::gpu("integers_decide_as_floats_do") else {
        return;
    };
    let mesh = mesh(&KINDS[5]);
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
