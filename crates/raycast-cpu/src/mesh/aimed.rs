//! Rays aimed at what breaks other walks (`hard_ray` of `tetrascope-testing`). None may be lost.

use std::sync::Arc;

use fearless_simd::Level;
use tetrascope_core::glam::{DVec3, Vec3};
use tetrascope_core::{Knot, TransferFunction};
use tetrascope_testing::{HARD_MESHES, HardMesh, Random, cast_many, fitted, hard_ray};

use super::crossings::{Crossings, SeenFace};
use super::integral::ABSORPTION;
use super::lanes::{Counts, Lanes};
use super::rays::{BlockRays, STRIDE};
use super::walk::walk;
use super::*;
use crate::simd::widest;

/// Sends `count` rays through a mesh, which may be spoilt before; those of one class at a time, in a block
/// of one row a ray.
fn shoot(
    kind: &HardMesh,
    level: Level,
    count: usize,
    seed: u64,
    spoil: impl Fn(&mut Packed),
) -> (u64, Counts) {
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::ZERO,
        extinction: 0.0,
    };
    let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid knots");
    let appearance = Appearance::new(function, tetrascope_core::OpticalModel::Absorption);
    let source = kind.mesh();
    let options = RaycastCpuOptions::default();
    let mut caster = Caster::new(&source, &appearance, &options).expect("a mesh");
    spoil(&mut caster.mesh);
    let mesh = &caster.mesh;
    let normalization = mesh.places.normalization;
    let points = source.points().iter();
    let points: Vec<Vec3> = points.map(|p| normalization.position(*p)).collect();
    let volume = tetrascope_core::Volume::Mesh(source.clone());
    let view = fitted(&volume, tetrascope_core::CameraFit::PlusX, true, 1);
    let camera = Camera::new(
        &view,
        Rays::new(&view, &normalization),
        normalization,
        &appearance,
        &source.bounds(),
        None,
    );
    let mut random = Random(seed);
    let rays: Vec<[DVec3; 2]> = (0..count)
        .map(|_| hard_ray(&mut random, &points, source.tetrahedra()).map(|v| v.as_dvec3()))
        .collect();
    let faces: Vec<SeenFace> = (0..mesh.places.boundary.len() as u32)
        .map(|face| SeenFace {
            face,
            columns: [0, MOST_SIDE as u16 - 1],
            rows: [0, MOST_SIDE as u16 - 1],
        })
        .collect();
    let (mut block, mut crossings) = (BlockRays::default(), Crossings::default());
    let mut lanes = Box::new(Lanes::new());
    let mut counts = Counts::default();
    for class in (0..Class::COUNT).map(Class) {
        let vertices: Vec<Vertex> = mesh.vertices.iter().map(|v| class.vertex(*v)).collect();
        let scene = Scene {
            mesh,
            style: &caster.style,
            camera: &camera,
            vertices: &vertices,
            class,
            has_cue: false,
            columns: [0, MOST_SIDE],
            rows: [0, MOST_SIDE],
            lights: &[],
            by_path: false,
        };
        let of_class: Vec<_> = rays.iter().filter(|r| Class::of(r[1]) == class).collect();
        for part in of_class.chunks(MOST_SIDE * MOST_SIDE) {
            camera.put(class, part, &mut block);
            let places = [[0, MOST_SIDE]; 2];
            let boundary = &mesh.places.boundary;
            widest!(level, simd => {
                crossings.find(simd, boundary, &vertices, &faces, &block, places)
            });
            crossings.sort(MOST_SIDE * STRIDE);
            widest!(level, simd => {
                walk::<_, ABSORPTION>(simd, &scene, &block, &mut crossings, &mut lanes)
            });
            counts += lanes.counts;
        }
    }
    (count as u64, counts)
}

/// All kinds of meshes; panics where a ray is lost.
fn shoot_all(level: Level, count: usize, seed: u64) -> u64 {
    let mut rays = 0;
    for kind in HARD_MESHES.iter().chain([&HardMesh::random(seed)]) {
        let (shot, counts) = shoot(kind, level, count, seed, |_| ());
        let name = kind.name;
        assert_eq!((counts.lost, counts.unpaired), (0, 0), "{name}: {counts:?}");
        // They did go through: every ray is aimed at the mesh.
        assert!(counts.paths > shot / 2, "{name}: {counts:?}");
        assert!(counts.visits > 2 * shot, "{name}: {counts:?}");
        rays += shot;
    }
    rays
}

#[test]
fn no_ray_is_lost() {
    for (seed, level) in [(1, Level::new()), (2, Level::baseline())] {
        assert!(shoot_all(level, 1 << 16, seed) > 500_000);
    }
}

/// Thinner than f32 resolves: rays along such layers see all corners of a face at one point.
#[test]
fn a_face_seen_at_one_point_is_not_crossed() {
    let seed = 16023;
    let (_, counts) = shoot(&HardMesh::random(seed), Level::new(), 1 << 17, seed, |_| ());
    assert_eq!((counts.lost, counts.unpaired), (0, 0), "{counts:?}");
}

/// A neighbor that leads back is what a broken rule would look like: such rays are given up, and counted.
#[test]
fn paths_that_go_round_in_a_circle_end_and_are_counted() {
    let (shot, counts) = shoot(&HARD_MESHES[0], Level::new(), 1000, 3, |mesh| {
        let count = mesh.cell_count as u32;
        let cells = Arc::get_mut(&mut mesh.cells).expect("nobody else has them");
        for (cell, inner) in (0..count).zip(&mut cells[..mesh.cell_count]) {
            let neighbors = inner.neighbors.iter_mut();
            neighbors
                .filter(|neighbor| **neighbor < count)
                .for_each(|neighbor| *neighbor = cell);
        }
    });
    assert!(counts.lost > shot / 4, "{counts:?}");
}

/// 10⁹ rays, if not told otherwise ([`cast_many`]).
#[test]
#[ignore = "takes long; run with --ignored"]
fn no_ray_of_many_is_lost() {
    cast_many(1_000_000_000, |seed| {
        let parts = (0..16_u64).into_par_iter();
        parts
            .map(|part| shoot_all(Level::new(), 1 << 17, 16 * seed + part))
            .sum()
    });
}
