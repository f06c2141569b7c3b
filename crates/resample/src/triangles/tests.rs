use tetrascope_core::Unit as _;
use tetrascope_core::glam::{DMat3, DVec2, DVec3};

use super::*;

/// Where a vertical line meets a tetrahedron: depth and scalar in front and behind, in f64.
fn met(p: [Vec4; 4], at: DVec2) -> Option<[DVec2; 2]> {
    let q = p.map(|p| p.as_dvec4());
    let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let mut found: Vec<DVec2> = Vec::new();
    for [a, b, c] in faces.map(|face| face.map(|corner| q[corner])) {
        let [ab, ac, ap] = [b.xy() - a.xy(), c.xy() - a.xy(), at - a.xy()];
        let area = ab.perp_dot(ac);
        if area == 0.0 {
            continue;
        }
        let (y, z) = (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area);
        if y >= 0.0 && z >= 0.0 && y + z <= 1.0 {
            found.push(a.zw() + y * (b - a).zw() + z * (c - a).zw());
        }
    }
    found.sort_by(|a, b| a.x.total_cmp(&b.x));
    Some([*found.first()?, *found.last()?])
}

/// The corners of triangle `k` with what is at them: place, front, back.
fn triangle(p: &[Vec4; 4], fan: &Fan, k: usize) -> [[DVec2; 3]; 3] {
    let outer = |i: usize| {
        let corner = p[fan.outline[i % fan.sides]].as_dvec4();
        [corner.xy(), corner.zw(), corner.zw()]
    };
    let center = [fan.center, fan.front, fan.back].map(|v| v.as_dvec2());
    [center, outer(k), outer(k + 1)]
}

fn doubled_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Twice the area of what is seen of four points.
fn silhouette(p: &[Vec4; 4]) -> f64 {
    // The outlines of 3 and of 4 points, all of them: the greatest is the hull's.
    let q = p.map(|p| p.xy().as_dvec2());
    let orders = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 1, 3]];
    let quads = orders.map(|o| {
        let [a, b, c, d] = o.map(|i| q[i]);
        (c - a).perp_dot(d - b).abs()
    });
    let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let faces = faces.map(|f| doubled_area(f.map(|i| q[i])).abs());
    // A quad that crosses itself, or is not convex, has less than the greatest face or convex one.
    quads.into_iter().chain(faces).fold(0.0, f64::max)
}

/// Holds a fan to its tetrahedron, all lengths being some `size`.
fn check(p: [Vec4; 4], fan: &Fan, what: &str) {
    let size = (0..4).map(|i| (p[i] - p[0]).xyz().abs().max_element());
    let size = f64::from(size.fold(0.0, f32::max));
    let scalars = f64::from((0..4).map(|i| (p[i].w - p[0].w).abs()).fold(0.0, f32::max));
    let mut sum = 0.0;
    let mut with_area = 0;
    for k in 0..fan.sides {
        let corners = triangle(&p, fan, k);
        let area = doubled_area(corners.map(|c| c[0]));
        // The center is off by some roundings of 2⁻²⁴.
        assert!(
            area >= -1e-6 * size * size,
            "{what}: triangle {k} of {fan:?} is turned over: {area}"
        );
        sum += area;
        with_area += u32::from(area > 1e-5 * size * size);
        if area < 1e-2 * size * size {
            continue;
        }
        for [y, z] in [[0.3, 0.3], [0.1, 0.1], [0.8, 0.1], [0.1, 0.8], [0.02, 0.5]] {
            let [center, second, third] = corners;
            let at =
                |i: usize| center[i] + y * (second[i] - center[i]) + z * (third[i] - center[i]);
            let [front, back] = met(p, at(0)).expect("inside of the silhouette");
            for (found, truth) in [(at(1), front), (at(2), back)] {
                let off = (found - truth).abs();
                // Slopes are at most some 100, as no triangle is smaller.
                assert!(
                    off.x <= 2e-4 * size,
                    "{what}: depth {found} for {truth} in {fan:?}"
                );
                assert!(
                    off.y <= 2e-4 * scalars + 1e-9,
                    "{what}: scalar {found} for {truth} in {fan:?}"
                );
            }
        }
    }
    // As none is turned over, and they add up to the silhouette, none overlap.
    let whole = silhouette(&p);
    assert!(
        (sum - whole).abs() <= 1e-5 * size * size,
        "{what}: {sum} of {whole}: {fan:?}"
    );
    assert_eq!(with_area, fan.triangles, "{what}: {fan:?}");
}

fn permutations() -> Vec<[usize; 4]> {
    let all = (0..256).map(|i| [i % 4, i / 4 % 4, i / 16 % 4, i / 64]);
    let is_whole = |o: &[usize; 4]| (0..4).all(|i| o.contains(&i));
    all.filter(is_whole).collect()
}

/// All places on a lattice of 3×3 for four corners, with depths that give each pair both orders: all
/// signs of areas, and all zeros, in all numberings of corners.
#[test]
fn every_pattern_of_corners_is_tiled_once() {
    let depths = [0.0, 1.0, 2.0, 4.0_f32];
    let mut by_triangles = [0; 5];
    let mut flat = 0;
    for places in 0..9_usize.pow(4) {
        let place = |i: u32| {
            let number = places / 9_usize.pow(i) % 9;
            Vec2::new((number % 3) as f32, (number / 3) as f32)
        };
        for order in permutations() {
            let p: [Vec4; 4] = std::array::from_fn(|i| {
                let scalar = [3.0, -1.0, 5.0, 0.5][i];
                Vec4::from((place(i as u32), Vec2::new(depths[order[i]], scalar)))
            });
            let corners = p.map(|p| p.as_dvec4().xyz());
            let edges = [1, 2, 3].map(|i| corners[i] - corners[0]);
            let volume = DMat3::from_cols(edges[0], edges[1], edges[2]).determinant();
            match fan_of(p) {
                None => {
                    flat += 1;
                    // Coincident in all, or in one plane.
                    assert!(volume.abs() < 1e-9 || silhouette(&p) == 0.0, "{p:?}");
                }
                Some(fan) => {
                    assert!(volume != 0.0, "{p:?}");
                    by_triangles[fan.triangles as usize] += 1;
                    check(p, &fan, "lattice");
                }
            }
        }
    }
    eprintln!("{by_triangles:?} and {flat} flat");
    assert!(by_triangles[1..].iter().all(|count| *count > 1000) && flat > 1000);
}

/// One tetrahedron seen from many sides, and needles and plates of any proportions.
#[test]
fn shapes_seen_from_anywhere_are_tiled_once() {
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    let mut by_triangles = [0; 5];
    for case in 0..20_000 {
        let thin = [1.0, 0.1, 1e-3][case % 3];
        let turn = DMat3::from_axis_angle(
            DVec3::new(random(), random(), random() + 1e-3).unit(),
            6.0 * random(),
        );
        let p: [Vec4; 4] = std::array::from_fn(|_| {
            let point = turn * DVec3::new(random(), random(), thin * random());
            Vec4::from((point.as_vec3(), random() as f32))
        });
        let Some(fan) = fan_of(p) else { continue };
        by_triangles[fan.triangles as usize] += 1;
        // What is thin as seen has neither an area nor a slope to speak of.
        if silhouette(&p) > 0.05 {
            let is_clear =
                (0..fan.sides).all(|k| doubled_area(triangle(&p, &fan, k).map(|c| c[0])) > 1e-2);
            if is_clear {
                check(p, &fan, "turned");
            }
        }
    }
    eprintln!("{by_triangles:?}");
    assert!(by_triangles[3] > 1000 && by_triangles[4] > 1000);
}

#[test]
fn published_classes_are_told_apart() {
    let at = |x: f32, y: f32, z: f32| Vec4::new(x, y, z, x);
    let base = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(0.0, 4.0, 0.0)];
    let with = |p: Vec4| fan_of([base[0], base[1], base[2], p]);
    let triangles = |p: Vec4| with(p).map(|fan| fan.triangles);
    assert_eq!(
        triangles(at(1.0, 1.0, 1.0)),
        Some(3),
        "class 1, in front or behind"
    );
    assert_eq!(triangles(at(1.0, 1.0, -1.0)), Some(3));
    assert_eq!(triangles(at(3.0, 3.0, 1.0)), Some(4), "class 2");
    assert_eq!(
        triangles(at(-1.0, -1.0, 1.0)),
        Some(3),
        "class 1, a corner of the base inside"
    );
    assert_eq!(triangles(at(2.0, 2.0, 1.0)), Some(2), "class 3, on an edge");
    assert_eq!(
        triangles(at(8.0, 0.0, 1.0)),
        Some(2),
        "class 3, beyond an edge"
    );
    assert_eq!(triangles(at(4.0, 0.0, 1.0)), Some(1), "class 4");
    assert_eq!(with(at(1.0, 1.0, 0.0)), None, "flat");
    let line = [0.0, 1.0, 2.0, 5.0].map(|x| at(x, x, x * x));
    assert_eq!(fan_of(line), None, "edge on");
}
