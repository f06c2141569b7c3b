use tetrascope_core::Unit as _;
use tetrascope_core::glam::DMat3;
use tetrascope_core::{Grid, Knot, OpticalModel, TransferFunction};

use super::*;

/// A grid of bytes by a formula of the sample's place.
fn grid(dims: [usize; 3], value: impl Fn(usize, usize, usize) -> u8) -> Grid {
    let samples = places(dims).map(|[x, y, z]| value(x, y, z)).collect();
    let samples = Samples::U8(samples);
    let grid = Grid::new(dims, DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
    grid.expect("the grid is valid")
}

/// No box is outside of it.
fn everything() -> Frustum {
    Frustum::default()
}

/// Opaque from `threshold` on.
fn step(threshold: f64) -> Appearance {
    let knot = |scalar, extinction| Knot {
        scalar,
        color: DVec3::ONE,
        extinction,
    };
    let knots = vec![knot(0.0, 0.0), knot(threshold, 0.0), knot(threshold, 1.0)];
    Appearance::new(
        TransferFunction::new(knots).expect("two knots at a step"),
        OpticalModel::EmissionAbsorption,
    )
}

/// Every level against a search through the samples that it should cover.
#[test]
fn ranges_are_those_of_the_samples_in_reach() {
    let source = grid([71, 20, 33], |x, y, z| {
        ((x * 7) ^ (y * 13) ^ (z * 29)) as u8
    });
    for reach in [0, 1] {
        let octree = Octree::build(&source, reach).expect("it is in memory");
        assert_eq!(octree.boxes.deepest(), 3);
        assert_eq!(octree.boxes.box_size(0), [72, 20, 32]);
        assert_eq!(octree.boxes.box_size(3), [9, 10, 8]);
        for level in 0..=octree.boxes.deepest() {
            for place in places(octree.boxes.divisions(level)) {
                let truth = octree.boxes.region(level, place, reach).map(|region| {
                    let Ok(Samples::U8(samples)) = source.read(region) else {
                        panic!("bytes in memory");
                    };
                    let range = [samples.iter().min(), samples.iter().max()];
                    range.map(|s| f32::from(*s.expect("no box is empty")))
                });
                let truth = truth.unwrap_or([f32::INFINITY, f32::NEG_INFINITY]);
                assert_eq!(octree.range(level, place), truth, "level {level} {place:?}");
            }
        }
    }
}

/// A single bright sample is in reach of all boxes that touch it, and of no other.
#[test]
fn only_boxes_that_can_show_are_visited() {
    let source = grid([65, 65, 65], |x, y, z| {
        if [x, y, z] == [16, 20, 33] { 200 } else { 9 }
    });
    let octree = Octree::build(&source, 0).expect("it is in memory");
    let visibility = octree.visibility(&octree.table(&step(100.0)));
    let viewer = Viewer::Direction(DVec3::ONE);
    let found = octree.back_to_front(3, &visibility, viewer, &everything());
    // Sample 16 is the border of boxes 1 and 2 along x; 20 and 33 are inside.
    assert_eq!(found, [[2, 2, 4], [1, 2, 4]]);
    assert_eq!(visibility.count(3), 2);
    assert_eq!(
        octree
            .back_to_front(0, &visibility, viewer, &everything())
            .len(),
        1
    );
    let nothing = octree.visibility(&octree.table(&step(201.0)));
    assert!(
        octree
            .back_to_front(3, &nothing, viewer, &everything())
            .is_empty()
    );
}

/// On every ray, sampled finely, the boxes come in the order of the list, reversed.
#[test]
fn boxes_come_back_to_front() {
    let source = grid([65, 33, 17], |_, _, _| 200);
    let octree = Octree::build(&source, 0).expect("it is in memory");
    let visibility = octree.visibility(&octree.table(&step(100.0)));
    let viewers = [
        Viewer::Eye(DVec3::new(-50.0, 10.0, 90.0)),
        Viewer::Eye(DVec3::new(30.5, 12.25, 7.0)),
        Viewer::Eye(DVec3::new(32.0, 16.0, 8.0)),
        Viewer::Direction(DVec3::new(0.3, -1.0, 0.2)),
        Viewer::Direction(DVec3::NEG_Z),
    ];
    for viewer in viewers {
        for level in 0..=octree.boxes.deepest() {
            let order = octree.back_to_front(level, &visibility, viewer, &everything());
            assert_eq!(order.len(), octree.boxes.box_count(level));
            let size = octree.boxes.box_size(level);
            for target in places([9, 7, 5]) {
                let target = DVec3::from_array(target.map(|t| t as f64 * 7.9 + 0.3));
                let (start, direction) = match viewer {
                    Viewer::Eye(eye) => (eye, (target - eye).unit()),
                    Viewer::Direction(d) => (target - 200.0 * d.unit(), d.unit()),
                };
                let mut last = usize::MAX;
                for i in 0..4000 {
                    let p = start + direction * (f64::from(i) * 0.1);
                    let inside =
                        p.cmpge(DVec3::ZERO).all() && p.cmplt(DVec3::new(64.0, 32.0, 16.0)).all();
                    if !inside {
                        continue;
                    }
                    let place = [0, 1, 2].map(|a| p[a] as usize / size[a]);
                    let rank = order
                        .iter()
                        .position(|o| *o == place)
                        .expect("all are listed");
                    assert!(rank <= last, "{viewer:?}: {place:?} is drawn too late");
                    last = rank;
                }
            }
        }
    }
}
