//! The walk: a ray in each lane, each on a path of its own, from cell to cell.
//!
//! A lane whose path ends takes its ray's next path, or the next ray that waits, so that all lanes
//! are busy until a block has no rays left. Which face a ray crosses is decided in `sides`.

use fearless_simd::prelude::*;

use super::Scene;
use super::crossings::Crossings;
use super::integral::{
    ABSORPTION, EMISSION, EMISSION_ABSORPTION, Gathered, ISOSURFACES, MAXIMUM_INTENSITY, Piece,
};
use super::lanes::{End, Lanes, NO_RAY, lanes_of};
use super::packed::{Cell, Kind, LEAST_NO_SCALAR, NO_SCALAR, Vertex};
use super::rays::BlockRays;
use super::sides::{Corner, Shear, Side, mean, shares};
use super::style::{HIGH, INVERSE_WIDTH, LOW, STEP_HIGH, STEP_LOW};
use crate::simd::{MOST_LANES, columns, each, load, load_ids, store, store_ids};

/// Steps after which what was gathered is put aside, so that sums of many small terms keep their
/// digits, and after which it is looked whether a path ends.
const STEPS_IN_A_SUM: u64 = 32;

/// A cell in which a ray has no more than this length is a layer; its scalar changes by more than rounding
/// makes of two at one point, and its length is more than none.
const THIN: f32 = 1.0 / (1 << 21) as f32;
const GRAZED: f32 = 1.0 / (1 << 20) as f32;
const LAYER: f32 = 1e-20;

/// A path's way through one cell.
struct Crossed<S: Simd> {
    /// z and scalar where the ray comes in and goes out.
    near: [S::f32s; 2],
    far: [S::f32s; 2],
}

/// Casts all rays of a block that cross something; leaves them in `lanes.done`.
#[inline(always)]
pub(super) fn walk<S: Simd, const MODEL: u8>(
    simd: S,
    scene: &Scene,
    rays: &BlockRays,
    crossings: &mut Crossings,
    lanes: &mut Lanes,
) {
    let count = S::f32s::LEN;
    let splat = |value: f32| S::f32s::splat(simd, value);
    let mesh = scene.mesh;
    let cells = &mesh.cells[..];
    let behind_all = S::i32s::splat(simd, mesh.cell_count as i32);
    let least_transmittance = splat(scene.style.least_transmittance);
    lanes.start(count);
    let all_lanes = (1_u64 << count) - 1;
    // All lanes look for a ray first.
    let (mut done, mut left, mut endless) = (all_lanes, 0, 0);
    let nothing = [splat(0.0); 4];
    let mut shear = Shear {
        through: [splat(0.0); 2],
        slope: [splat(0.0); 2],
    };
    let mut face = [shear.corner(nothing); 3];
    let mut ids = [S::i32s::splat(simd, 0); 3];
    let mut areas = [splat(0.0); 3];
    let mut near = [splat(0.0); 2];
    let mut seen = splat(0.0);
    let mut gathered = Gathered::<S> {
        light: [splat(0.0); 3],
        transmittance: splat(1.0),
        lost: splat(0.0),
    };
    let mut active = 0_u64;
    // Whether a scalar may be in another interval than its lane: not along a path on which it is
    // continuous.
    let may_jump_always = mesh.kind != Kind::Vertices || mesh.has_gaps;
    let mut may_jump = true;
    for step in 1_u64.. {
        if done != 0 {
            for i in 0..3 {
                store::<S>(gathered.light[i], &mut lanes.light[i]);
            }
            store::<S>(gathered.transmittance, &mut lanes.transmittance);
            store::<S>(gathered.lost, &mut lanes.lost);
            store::<S>(seen, &mut lanes.seen);
            for lane in lanes_of(done) {
                let end = match (left >> lane & 1, endless >> lane & 1) {
                    (0, 0) => End::Stopped,
                    (0, _) => End::Never,
                    _ => End::Left(lanes.cell[lane] as u32 - mesh.cell_count as u32),
                };
                lanes.go_on(lane, end, step, scene, rays, crossings);
            }
            if lanes.are_idle() {
                return;
            }
            gathered = Gathered {
                light: each!([0, 1, 2], i => load(simd, &lanes.light[i])),
                transmittance: load(simd, &lanes.transmittance),
                lost: load(simd, &lanes.lost),
            };
            shear = Shear {
                through: [load(simd, &lanes.line[0]), load(simd, &lanes.line[1])],
                slope: [load(simd, &lanes.line[2]), load(simd, &lanes.line[3])],
            };
            let fresh = S::mask32s::from_bitmask(simd, done);
            face = each!([0, 1, 2], i => shear.corner(columns(simd, &lanes.face[i])).or(fresh, face[i]));
            ids = each!([0, 1, 2], i => fresh.select(load_ids(simd, &lanes.ids[i]), ids[i]));
            let [a, b, c] = face;
            let sides = [Side::of(&b, &c), Side::of(&c, &a), Side::of(&a, &b)];
            areas = each!([0, 1, 2], i => fresh.select(sides[i].area, areas[i]));
            let entered = match scene.by_path {
                true => each!([0, 1], i => load(simd, &lanes.entered[i])),
                false => crossing_point::<S, MODEL>(simd, &face, areas, mesh.has_gaps),
            };
            near = each!([0, 1], i => fresh.select(entered[i], near[i]));
            seen = fresh.select(near[0], seen);
            fetch(simd, cells, scene.vertices, lanes);
            may_jump = true;
            active = (0..count).fold(0, |bits, lane| {
                bits | u64::from(lanes.ray[lane] != NO_RAY) << lane
            });
        }
        lanes.counts.visits += u64::from(active.count_ones());

        // The fourth vertex, and the face through which the ray leaves: of the three around it the
        // one whose two edges at it pass the ray on the side of the entry face's edges.
        let mut fourth = shear.corner(columns(simd, &lanes.fourth));
        let fourth_id = load_ids(simd, &lanes.fourth_id);
        if mesh.kind == Kind::Corners {
            let own = own_scalars(simd, scene, lanes, [ids[0], ids[1], ids[2], fourth_id]);
            for i in 0..3 {
                face[i].scalar = own[i];
            }
            fourth.scalar = own[3];
            near[1] = crossing_point::<S, MODEL>(simd, &face, areas, mesh.has_gaps)[1];
        }
        let [a, b, c] = face;
        let mut sides = [
            Side::of(&a, &fourth),
            Side::of(&b, &fourth),
            Side::of(&c, &fourth),
        ];
        if (sides[0].tied | sides[1].tied | sides[2].tied).any_true() {
            sides = each!([0, 1, 2], i => sides[i].untied(simd, &face[i], &fourth));
        }
        let [of_a, of_b, of_c] = sides;
        let leaves_c = !of_a.is_positive & of_b.is_positive;
        let leaves_b = of_a.is_positive & !of_c.is_positive;
        let leaves_a = !(leaves_b | leaves_c);
        let leaves = [leaves_a, leaves_b, leaves_c];
        let left_id = leaves_a.select(ids[0], leaves_b.select(ids[1], ids[2]));
        let entry_ids = ids;
        for i in 0..3 {
            face[i] = fourth.or(leaves[i], face[i]);
            ids[i] = leaves[i].select(fourth_id, ids[i]);
        }
        areas = [
            leaves_c.select(of_b.area, leaves_b.select(-of_c.area, areas[0])),
            leaves_c.select(-of_a.area, leaves_b.select(areas[1], of_c.area)),
            leaves_c.select(areas[2], leaves_b.select(of_a.area, -of_b.area)),
        ];
        let before = each!([0, 1, 2], i => ids[i].simd_lt(left_id).to_vector());
        store_ids::<S>(before[0] + before[1] + before[2], &mut lanes.rank);
        store_ids::<S>(ids[0] ^ ids[1] ^ ids[2], &mut lanes.crossed);
        let here = load_ids(simd, &lanes.cell);
        if mesh.kind == Kind::Cells {
            for lane in 0..count {
                lanes.scalar[lane] = mesh.cells[lanes.cell[lane] as usize].scalar;
            }
        }

        // What is behind is read before this cell is integrated, so that both overlap.
        for lane in 0..count {
            let rank = (lanes.rank[lane] & 3) as usize;
            lanes.cell[lane] = cells[lanes.cell[lane] as usize].neighbors[rank] as i32;
        }
        fetch(simd, cells, scene.vertices, lanes);

        let mut far = crossing_point::<S, MODEL>(simd, &face, areas, mesh.has_gaps);
        if scene.by_path {
            let left = load_ids(simd, &lanes.cell).simd_ge(behind_all);
            let left = left.to_bitmask() & active;
            if left != 0 {
                far = leave(simd, scene, lanes, far, left);
            }
        }
        let crossed = Crossed { near, far };
        let end = load(simd, &lanes.line[6]);
        let ids = [entry_ids[0], entry_ids[1], entry_ids[2], fourth_id, here];
        let (mut stopped, is_whole) = gather::<S, MODEL>(
            simd,
            scene,
            lanes,
            &mut gathered,
            &crossed,
            seen,
            end,
            may_jump,
            ids,
        );
        may_jump = !is_whole || may_jump_always;
        seen = seen.max(far[0]);
        near = far;
        endless = 0;
        if step % STEPS_IN_A_SUM == 0 {
            endless = lanes.endless(step, mesh.cell_count) & active;
            if matches!(MODEL, EMISSION_ABSORPTION | EMISSION | ABSORPTION) {
                put_aside(simd, lanes, &mut gathered);
            }
        }
        if MODEL == EMISSION_ABSORPTION {
            stopped |= gathered.transmittance.simd_lt(least_transmittance);
        }
        stopped |= seen.simd_ge(end);
        let is_out = load_ids(simd, &lanes.cell).simd_ge(behind_all);
        let ended = stopped | is_out;
        done = 0;
        if ended.any_true() || endless != 0 {
            let stopped = stopped.to_bitmask();
            left = is_out.to_bitmask() & active & !stopped;
            done = (stopped & active) | left | endless;
        }
    }
}

/// z and scalar where rays cross a face, the scalar between its corners'. A corner without a scalar
/// leaves the face without one, however small its share is.
#[inline(always)]
fn crossing_point<S: Simd, const MODEL: u8>(
    simd: S,
    [a, b, c]: &[Corner<S>; 3],
    areas: [S::f32s; 3],
    has_gaps: bool,
) -> [S::f32s; 2] {
    let shares = shares(simd, [a, b, c], areas);
    let z = mean::<S>(shares, [a.z, b.z, c.z]);
    let mut scalar = mean::<S>(shares, [a.scalar, b.scalar, c.scalar]);
    let greatest = a.scalar.max(b.scalar).max(c.scalar);
    if matches!(MODEL, MAXIMUM_INTENSITY | ISOSURFACES) {
        // Elsewhere a rounding beyond adds a rounding.
        let least = a.scalar.min(b.scalar).min(c.scalar);
        scalar = scalar.max(least).min(greatest);
    }
    if !has_gaps {
        return [z, scalar];
    }
    let is_gap = greatest.simd_ge(S::f32s::splat(simd, LEAST_NO_SCALAR));
    [z, is_gap.select(S::f32s::splat(simd, NO_SCALAR), scalar)]
}

/// The crossings of faces, where lanes leave a part of a mesh those that other parts have there.
#[inline(always)]
fn leave<S: Simd>(
    simd: S,
    scene: &Scene,
    lanes: &Lanes,
    far: [S::f32s; 2],
    left: u64,
) -> [S::f32s; 2] {
    let mut values = [[0.0; MOST_LANES]; 2];
    for i in 0..2 {
        store::<S>(far[i], &mut values[i]);
    }
    for lane in lanes_of(left) {
        let face = lanes.cell[lane] as u32 - scene.mesh.cell_count as u32;
        let [z, scalar] = lanes.at_seam(lane, face, scene);
        values[0][lane] = z;
        // Scalars of cells are each cell's own.
        if scene.mesh.kind == Kind::Vertices {
            values[1][lane] = scalar;
        }
    }
    each!([0, 1], i => load(simd, &values[i]))
}

/// Reads the fourth vertices of the cells that lanes are in.
#[inline(always)]
fn fetch<S: Simd>(_: S, cells: &[Cell], vertices: &[Vertex], lanes: &mut Lanes) {
    let last = vertices.len() as u32 - 1;
    for lane in 0..S::f32s::LEN {
        let id = cells[lanes.cell[lane] as usize].sum ^ lanes.crossed[lane] as u32;
        lanes.fourth_id[lane] = id as i32;
        // A lane without a ray may have any id.
        lanes.fourth[lane] = vertices[id.min(last) as usize];
    }
}

/// The scalars that cells have at their corners, as the field jumps between cells.
#[inline(always)]
fn own_scalars<S: Simd>(
    simd: S,
    scene: &Scene,
    lanes: &mut Lanes,
    ids: [S::i32s; 4],
) -> [S::f32s; 4] {
    let mut scalars = [S::f32s::splat(simd, 0.0); 4];
    for i in 0..4 {
        let mut rank = S::i32s::splat(simd, 0);
        for j in 0..4 {
            rank += ids[j].simd_lt(ids[i]).to_vector();
        }
        store_ids::<S>(rank, &mut lanes.rank);
        for lane in 0..S::f32s::LEN {
            let own = scene.mesh.corners.get(lanes.cell[lane] as usize);
            let rank = (lanes.rank[lane].wrapping_neg() & 3) as usize;
            // A lane without a ray is in no cell.
            lanes.scalar[lane] = own.map_or(0.0, |own| own[rank]);
        }
        scalars[i] = load(simd, &lanes.scalar);
    }
    scalars
}

/// Adds what was gathered to what earlier steps gathered, with what rounding takes from it (Knuth's
/// two-sum).
#[inline(always)]
fn put_aside<S: Simd>(simd: S, lanes: &mut Lanes, gathered: &mut Gathered<S>) {
    for i in 0..3 {
        let (before, more) = (load(simd, &lanes.light_before[i]), gathered.light[i]);
        let sum = before + more;
        let added = sum - before;
        let lost = (before - (sum - added)) + (more - added);
        store::<S>(sum, &mut lanes.light_before[i]);
        store::<S>(
            load(simd, &lanes.light_lost[i]) + lost,
            &mut lanes.light_lost[i],
        );
        gathered.light[i] = S::f32s::splat(simd, 0.0);
    }
}

/// Adds the ray's way through a cell: what of it is behind `seen`, as an inverted cell goes back,
/// and between the ray's own ends. Returns which rays have met an isosurface, in the cells whose
/// vertices and own numbers are in `ids`, and whether all went all the way.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "inlined into one loop, whose state it reads"
)]
fn gather<S: Simd, const MODEL: u8>(
    simd: S,
    scene: &Scene,
    lanes: &mut Lanes,
    gathered: &mut Gathered<S>,
    crossed: &Crossed<S>,
    seen: S::f32s,
    line_end: S::f32s,
    may_jump: bool,
    ids: [S::i32s; 5],
) -> (S::mask32s, bool) {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let none = S::mask32s::splat(simd, false);
    let Crossed { near, far } = crossed;
    let shows_layers = matches!(MODEL, MAXIMUM_INTENSITY | ISOSURFACES);
    // Where a layer is seen wholly, rounding back into what was seen cuts nothing of the next cell.
    let seen = if shows_layers {
        seen - splat(THIN)
    } else {
        seen
    };
    let begin = near[0].max(seen).max(load(simd, &lanes.line[5]));
    let end = far[0].min(line_end);
    let (mut front, mut back) = (near[1], far[1]);
    let mut is_there = end.simd_gt(begin);
    let mut is_whole = is_there.all_true();
    match scene.mesh.kind {
        Kind::Cells => {
            front = load(simd, &lanes.scalar);
            back = front;
        }
        _ => {
            let (cut_before, cut_behind) = (begin.simd_gt(near[0]), end.simd_lt(far[0]));
            if (cut_before | cut_behind).any_true() {
                is_whole = false;
                let whole = far[0] - near[0];
                let [cut_front, cut_back] = each!([begin, end], z => {
                    let share = ((z - near[0]) / whole).max(splat(0.0)).min(splat(1.0));
                    share.mul_add(far[1] - near[1], near[1])
                });
                front = cut_before.select(cut_front, front);
                back = cut_behind.select(cut_back, back);
            }
        }
    }
    // A layer is wholly seen: shaders/wgsl/common/layer.wgsl says why.
    let mut in_layer = none;
    if shows_layers && scene.mesh.kind != Kind::Cells {
        let is_thin = (far[0] - near[0]).abs().simd_le(splat(THIN));
        let changes = (far[1] - near[1]).abs().simd_gt(splat(GRAZED));
        let is_seen = far[0].simd_ge(seen)
            & near[0].simd_ge(load(simd, &lanes.line[5]))
            & far[0].simd_le(line_end);
        in_layer = is_thin & changes & is_seen;
        is_there |= in_layer;
        front = in_layer.select(near[1], front);
        back = in_layer.select(far[1], back);
    }
    if scene.mesh.has_gaps {
        is_there &= front.max(back).simd_lt(splat(LEAST_NO_SCALAR));
        front = is_there.select(front, splat(0.0));
        back = is_there.select(back, splat(0.0));
    }
    if MODEL == ISOSURFACES {
        let [below, above] = [load(simd, &lanes.band[0]), load(simd, &lanes.band[1])];
        // A band that is not known, NaN, is no band.
        let within = each!([front, back], scalar => scalar.simd_ge(below) & scalar.simd_lt(above));
        let hits = is_there & !(within[0] & within[1]);
        if !hits.any_true() {
            return (none, is_whole);
        }
        let mut piece = [[0.0; MOST_LANES]; 4];
        for (values, vector) in piece.iter_mut().zip([front, back, begin, end]) {
            store::<S>(vector, values);
        }
        let mut corners = [[0; MOST_LANES]; 5];
        for (values, id) in corners.iter_mut().zip(ids) {
            store_ids::<S>(id, values);
        }
        let met = lanes.meet_surfaces(hits.to_bitmask(), &piece, &corners, scene);
        let met = S::mask32s::from_bitmask(simd, met);
        gathered.transmittance = met.select(splat(0.0), gathered.transmittance);
        return (met, is_whole);
    }
    let length = is_there.select((end - begin) * load(simd, &lanes.line[4]), splat(0.0));
    let length = (in_layer & is_there).select(length.max(splat(LAYER)), length);
    let cue = match scene.has_cue {
        true => {
            let (at_0, slope) = (load(simd, &lanes.line[7]), load(simd, &lanes.line[8]));
            each!([begin, end], z => slope.mul_add(z, at_0).max(splat(0.0)).min(splat(1.0)))
        }
        false => [splat(1.0); 2],
    };
    integrate::<S, MODEL>(
        simd,
        scene,
        lanes,
        gathered,
        [front, back],
        length,
        cue,
        is_there,
        may_jump || !is_whole,
    );
    (none, is_whole)
}

/// Adds a piece with linear scalar, split at the knots of the transfer function, one interval of each
/// lane at a time.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "inlined into one loop, whose state it reads"
)]
fn integrate<S: Simd, const MODEL: u8>(
    simd: S,
    scene: &Scene,
    lanes: &mut Lanes,
    gathered: &mut Gathered<S>,
    [front, back]: [S::f32s; 2],
    length: S::f32s,
    cue: [S::f32s; 2],
    is_there: S::mask32s,
    may_jump: bool,
) {
    if may_jump {
        let [low, high] = [
            load(simd, &lanes.interval[LOW]),
            load(simd, &lanes.interval[HIGH]),
        ];
        let outside = (front.simd_lt(low) | front.simd_gt(high)) & is_there;
        if outside.any_true() {
            let mut ends = [[0.0; MOST_LANES]; 2];
            store::<S>(front, &mut ends[0]);
            store::<S>(back, &mut ends[1]);
            lanes.find_intervals(outside.to_bitmask(), [&ends[0], &ends[1]], scene);
        }
    }
    let mut on_step = S::mask32s::splat(simd, false);
    if scene.style.has_steps {
        let [low, high] = [STEP_LOW, STEP_HIGH];
        on_step = front.simd_eq(load(simd, &lanes.interval[low]))
            | front.simd_eq(load(simd, &lanes.interval[high]));
        on_step = on_step & front.simd_eq(back) & is_there;
        if on_step.any_true() {
            let mut scalar = [0.0; MOST_LANES];
            store::<S>(front, &mut scalar);
            lanes.halve_steps(on_step.to_bitmask(), &scalar, scene);
        }
    }
    let [low, high] = [
        load(simd, &lanes.interval[LOW]),
        load(simd, &lanes.interval[HIGH]),
    ];
    if ((back.simd_gt(high) | back.simd_lt(low)) & is_there).any_true() {
        split::<S, MODEL>(
            simd,
            scene,
            lanes,
            gathered,
            [front, back],
            length,
            cue,
            is_there,
        );
    } else {
        add_piece::<S, MODEL>(
            simd,
            scene,
            lanes,
            gathered,
            [front, back],
            length,
            cue,
            is_there,
        );
    }
    if scene.style.has_steps && on_step.any_true() {
        lanes.restore_intervals(on_step.to_bitmask(), scene);
    }
}

/// Adds pieces that end in other intervals than they begin in.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "inlined into one loop, whose state it reads"
)]
fn split<S: Simd, const MODEL: u8>(
    simd: S,
    scene: &Scene,
    lanes: &mut Lanes,
    gathered: &mut Gathered<S>,
    [front, back]: [S::f32s; 2],
    length: S::f32s,
    cue: [S::f32s; 2],
    is_there: S::mask32s,
) {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let (zero, one) = (splat(0.0), splat(1.0));
    let whole = (back - front).abs();
    // Each piece is as long as its share of the scalars; a constant one is whole. So is one whose
    // share f32 cannot name.
    let is_constant = whole.simd_lt(splat(1e-36));
    let back = is_constant.select(front, back);
    let per_scalar = one / is_constant.select(one, whole);
    let mut from = front;
    let mut is_there = is_there;
    loop {
        let [low, high] = [
            load(simd, &lanes.interval[LOW]),
            load(simd, &lanes.interval[HIGH]),
        ];
        let to = back.max(low).min(high);
        let share = is_constant.select(one, (to - from).abs() * per_scalar);
        let length = is_there.select(length * share, zero);
        let cue = match scene.has_cue {
            true => each!([(from, zero), (to, one)], (scalar, of_constant) => {
                let share = (scalar - front).abs() * per_scalar;
                let share = is_constant.select(of_constant, share);
                share.mul_add(cue[1] - cue[0], cue[0])
            }),
            false => cue,
        };
        let shows = is_there & length.simd_gt(zero);
        add_piece::<S, MODEL>(simd, scene, lanes, gathered, [from, to], length, cue, shows);
        let (up, down) = (back.simd_gt(high) & is_there, back.simd_lt(low) & is_there);
        is_there = up | down;
        if !is_there.any_true() {
            return;
        }
        lanes.next_intervals(up.to_bitmask(), down.to_bitmask(), scene);
        from = to;
    }
}

/// Adds a piece in one interval.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "inlined into one loop, whose state it reads"
)]
fn add_piece<S: Simd, const MODEL: u8>(
    simd: S,
    scene: &Scene,
    lanes: &Lanes,
    gathered: &mut Gathered<S>,
    [front, back]: [S::f32s; 2],
    length: S::f32s,
    cue: [S::f32s; 2],
    is_there: S::mask32s,
) {
    let zero = S::f32s::splat(simd, 0.0);
    let low = load(simd, &lanes.interval[LOW]);
    let inverse_width = load(simd, &lanes.interval[INVERSE_WIDTH]);
    let (extinction, more) = (
        load(simd, &lanes.interval[3]),
        load(simd, &lanes.interval[7]),
    );
    let at = each!([front, back], scalar => (scalar - low) * inverse_width);
    let ends = each!([at[0], at[1]], at => more.mul_add(at, extinction).max(zero) * length);
    if MODEL != MAXIMUM_INTENSITY && !(ends[0] + ends[1]).simd_gt(zero).any_true() {
        return;
    }
    let piece = Piece {
        base: each!([0, 1, 2], i => load(simd, &lanes.interval[i])),
        more: each!([4, 5, 6], i => load(simd, &lanes.interval[i])),
        at,
        ends,
        cue,
        is_there,
    };
    gathered.add::<MODEL>(simd, &piece, scene.has_cue);
}
