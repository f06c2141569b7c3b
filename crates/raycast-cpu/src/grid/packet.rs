//! The cells of eight rays at once.
//!
//! Lanes are rays, each on its own way through the grid. In each step a lane integrates one part
//! of its cell: up to the next extreme of the cubic, the next knot of the transfer function or
//! the depth for which the quadrature serves, whichever is first. On such a part extinction
//! and color are linear in a cubic x that only rises or only falls. A lane whose cell is done
//! takes its ray's next cell that shows; one whose ray is done takes the next pixel of its tile.
//!
//! With g = σ l, on a part 0 ≤ u ≤ 1, m = ∫g is exact, the opacity α = 1 − e^(−m), and
//! w = ∫ x g e^(−∫g) by quadrature, the light is c₀ α + (c₁ − c₀) w. A depth cue multiplies both
//! integrands by a line.
//!
//! Sums of light and of depth are compensated (Kahan), as rays may have thousands of parts, and
//! transmittance comes from the depth, so that nothing drifts.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, i32x8, mask32x8};
use tetrascope_core::OpticalModel;
use tetrascope_core::appearance::CueRamp;
use tetrascope_core::glam::DVec3;

use super::field::Field;
use super::gathered::{Finish, Pixel};
use super::rays::Rays;
use super::table::{COLUMNS, Row, Table};
use super::tree::Tree;
use super::walk::{Line, Stretch, Walk};

/// Rays of a packet.
const LANES: usize = 8;

/// Mapped scalars beyond this are as good as infinite, and products of a few still fit f32.
const HUGE: f32 = 1e30;

/// What all packets of a frame share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shared<'a> {
    pub(crate) field: &'a Field,
    pub(crate) tree: &'a Tree,
    pub(crate) table: &'a Table,
    pub(crate) rays: &'a Rays<'a>,
    pub(crate) finish: Finish,
    pub(crate) stop_depth: f32,
}

/// Pixels to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    pub(crate) first: [u32; 2],
    pub(crate) size: [u32; 2],
}

/// What was done for a square.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    pub(crate) visits: u64,
    pub(crate) skipped: u64,
}

/// A ray in a lane.
#[derive(Clone, Copy, Debug, Default)]
struct Lane {
    walk: Walk,
    line: Line,
    cue: Option<CueRamp>,
    pixel: u32,
}

/// The lanes' next cells and present rows, one array for each number.
#[derive(Clone, Copy, Debug, Default)]
struct Inbox {
    corners: [[f32; LANES]; 8],
    entry: [[f32; LANES]; 3],
    exit: [[f32; LANES]; 3],
    length: [f32; LANES],
    cue: [[f32; LANES]; 2],
    rows: [[f32; LANES]; COLUMNS],
    index: [u32; LANES],
}

impl Inbox {
    #[inline(always)]
    fn put_row(&mut self, lane: usize, row: &Row) {
        for (column, number) in self.rows.iter_mut().zip(row) {
            column[lane] = *number;
        }
    }

    /// Takes a cell for a lane.
    #[inline(always)]
    fn put_cell(&mut self, shared: &Shared, lane: usize, ray: &Lane, stretch: &Stretch) {
        let corners = shared.field.corners(stretch.cell);
        for (corner, sample) in self.corners.iter_mut().zip(corners) {
            corner[lane] = sample;
        }
        let entry = stretch.place(&ray.line, stretch.t_in);
        let exit = stretch.place(&ray.line, stretch.t_out);
        for axis in 0..3 {
            self.entry[axis][lane] = entry[axis] as f32;
            self.exit[axis][lane] = exit[axis] as f32;
        }
        let length = stretch.t_out - stretch.t_in;
        self.length[lane] = (length / shared.table.length) as f32;
        if let Some(ramp) = ray.cue {
            let [near, far] = [stretch.t_in, stretch.t_out].map(|t| ramp.at(t));
            self.cue[0][lane] = near as f32;
            self.cue[1][lane] = (far - near) as f32;
        }
    }
}

/// The pixels that no lane has taken yet.
struct Queue {
    square: Square,
    next: u32,
    empty: Pixel,
}

impl Queue {
    /// Starts the next ray that meets anything; draws those before it, which do not.
    #[inline(always)]
    fn start(
        &mut self,
        shared: &Shared,
        pixels: &mut [Pixel],
        work: &mut Work,
    ) -> Option<(Lane, Stretch)> {
        let [width, height] = self.square.size;
        while self.next < width * height {
            let pixel = self.next;
            self.next += 1;
            let [x, y] = self.square.first;
            let ray = shared.rays.ray(x + pixel % width, y + pixel / width);
            if let Some(mut walk) = Walk::new(ray.line, shared.tree, ray.kept) {
                if let Some(stretch) = walk.next(shared.tree) {
                    let lane = Lane {
                        walk,
                        line: ray.line,
                        cue: ray.cue,
                        pixel,
                    };
                    return Some((lane, stretch));
                }
                work.skipped += walk.skipped;
            }
            pixels[pixel as usize] = self.empty;
        }
        None
    }
}

/// Draws a square of pixels, row by row. `MODEL` is an optical model as a number.
#[inline(always)]
pub(crate) fn draw<S: Simd>(simd: S, shared: &Shared, square: Square) -> (Vec<Pixel>, Work) {
    simd.vectorize(
        #[inline(always)]
        || march(simd, shared, square),
    )
}

#[inline(always)]
fn march<S: Simd>(simd: S, shared: &Shared, square: Square) -> (Vec<Pixel>, Work) {
    let mut work = Work::default();
    let empty = (shared.finish.pixel(DVec3::ZERO, 0.0), f32::INFINITY);
    let mut pixels = vec![empty; (square.size[0] * square.size[1]) as usize];
    let mut queue = Queue {
        square,
        next: 0,
        empty,
    };
    let splat = |value: f32| f32x8::splat(simd, value);
    let mask = |bits: u64| mask32x8::from_bitmask(simd, bits);
    let (zero, one) = (splat(0.0), splat(1.0));
    let model = shared.finish.model;
    let absorbs = model == OpticalModel::EmissionAbsorption;
    let is_cued = shared.rays.is_cued();
    let weighs = shared.table.is_colored;
    let rule = shared.table.rule;
    let deepest = splat(match absorbs && weighs {
        true => rule.deepest,
        false => f32::INFINITY,
    });

    let mut lanes = [Lane::default(); LANES];
    let mut inbox = Inbox::default();
    // Lanes with a ray, with a new cell, and with a new ray.
    let mut alive = 0u64;
    let mut fresh = 0u64;
    for lane in 0..LANES {
        if let Some((ray, stretch)) = queue.start(shared, &mut pixels, &mut work) {
            inbox.put_cell(shared, lane, &ray, &stretch);
            lanes[lane] = ray;
            alive |= 1 << lane;
            fresh |= 1 << lane;
        }
    }
    let mut started = fresh;

    // The cubic in powers of τ, the share of the way through the cell.
    let mut cubic = [zero; 4];
    let mut extremes = [one; 2];
    let mut tau = one;
    let mut length = zero;
    let mut light = [[zero; 2]; 3];
    let mut depth = [zero; 2];
    while alive != 0 {
        if fresh != 0 {
            let is_fresh = mask(fresh);
            if started != 0 {
                let is_started = mask(started);
                for sum in light.iter_mut().chain([&mut depth]) {
                    for part in sum {
                        *part = is_started.select(zero, *part);
                    }
                }
                started = 0;
            }
            let (new, turns) = power_form(simd, &inbox, shared.table);
            for i in 0..4 {
                cubic[i] = is_fresh.select(new[i], cubic[i]);
            }
            for i in 0..2 {
                extremes[i] = is_fresh.select(turns[i], extremes[i]);
            }
            tau = is_fresh.select(zero, tau);
            length = is_fresh.select(f32x8::load_array_ref(simd, &inbox.length), length);
            let flat = (new[1].simd_eq(zero) & new[2].simd_eq(zero)) & new[3].simd_eq(zero);
            let flat = flat.to_bitmask();
            let scalars = cubic[0].to_array();
            let mut bits = fresh;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                if flat >> lane & 1 == 1
                    && let Some(row) = shared.table.step(inbox.corners[0][lane])
                {
                    inbox.put_row(lane, row);
                    continue;
                }
                let index = shared.table.find(scalars[lane]);
                inbox.index[lane] = index;
                inbox.put_row(lane, shared.table.row(index));
            }
        }
        let row = |column: usize| f32x8::load_array_ref(simd, &inbox.rows[column]);

        // To the next extreme or to the end of the cell.
        let before_first = tau.simd_lt(extremes[0]);
        let before_second = tau.simd_lt(extremes[1]);
        let turn = before_first.select(extremes[0], before_second.select(extremes[1], one));
        let [c0, c1, c2, c3] = cubic;
        let at = |t: f32x8<S>| c3.mul_add(t, c2).mul_add(t, c1).mul_add(t, c0);
        let (front, back) = (at(tau), at(turn));
        // To the knot, if one is before that.
        let (low, high) = (row(0), row(1));
        let rises = back.simd_ge(front);
        let crosses = (rises & back.simd_gt(high)) | (!rises & back.simd_lt(low));
        let mut until = turn;
        if crosses.any_true() {
            let knot = rises.select(high, low);
            let found = root(simd, &cubic, knot, [tau, turn], [front, back], crosses);
            until = crosses.select(found, turn);
        }
        let mut step = until - tau;

        // x in powers of the way behind τ.
        let inverse = row(2);
        let x0 = ((front - low) * inverse).max(zero).min(one);
        let slope = (c3 * 3.0).mul_add(tau, c2 * 2.0).mul_add(tau, c1);
        let bend = (c3 * 3.0).mul_add(tau, c2);
        let (x1, x2, x3) = (slope * inverse, bend * inverse, c3 * inverse);

        if model == OpticalModel::MaximumIntensity {
            let end = x3.mul_add(step, x2).mul_add(step, x1).mul_add(step, x0);
            let end = end.max(zero).min(one);
            for channel in 0..3 {
                let (color, change) = (row(5 + 2 * channel), row(6 + 2 * channel));
                let most = change.mul_add(x0, color).max(change.mul_add(end, color));
                light[channel][0] = light[channel][0].max(most);
            }
            let ended = !crosses & turn.simd_ge(one);
            tau = until;
            let crossed = crosses.to_bitmask() & alive;
            next_rows(&mut inbox, shared.table, crossed, rises.to_bitmask());
            let done = ended.to_bitmask() & alive;
            fresh = next_cells(
                shared,
                &mut lanes,
                &mut inbox,
                &mut queue,
                &mut pixels,
                &mut work,
                (done, 0),
                (&mut alive, &mut started),
                (&light, &depth),
            );
            continue;
        }

        // To the depth for which the rule serves.
        let (e0, de) = (row(3), row(4));
        let mut limited = mask(0);
        if absorbs && weighs {
            let near = de.mul_add(x0, e0);
            for _ in 0..40 {
                let x = x3.mul_add(step, x2).mul_add(step, x1).mul_add(step, x0);
                let most = near.max(de.mul_add(x, e0)) * (length * step);
                let is_deep = most.simd_gt(deepest);
                if !is_deep.any_true() {
                    break;
                }
                limited |= is_deep;
                step = is_deep.select(step * 0.5, step);
            }
        }

        // x and g in powers of u.
        let (step2, span) = (step * step, length * step);
        let (x1, x2, x3) = (x1 * step, x2 * step2, x3 * (step2 * step));
        let scale = de * span;
        let (g0, g1) = (scale.mul_add(x0, e0 * span), scale * x1);
        let (g2, g3) = (scale * x2, scale * x3);
        let (d1, d2, d3) = (g1 * 0.5, g2 * (1.0 / 3.0), g3 * 0.25);
        let part = ((g0 + d1) + (d2 + d3)).max(zero);

        let (mut all, mut far) = (part, zero);
        match model {
            OpticalModel::Absorption => {}
            OpticalModel::Emission if !is_cued => {
                // ∫ x g, of degree 6.
                far = moment([x0, x1, x2, x3], [g0, g1, g2, g3])
                    .max(zero)
                    .min(part);
            }
            _ => {
                let opacity = if absorbs { opacity(simd, part) } else { part };
                all = opacity;
                if weighs || is_cued {
                    let (cue, fall) = match is_cued {
                        true => {
                            let [at, fall] = inbox.cue.map(|cue| f32x8::load_array(simd, cue));
                            (fall.mul_add(tau, at), fall * step)
                        }
                        false => (one, zero),
                    };
                    let mut cued = zero;
                    for &[u, weight] in rule.nodes {
                        let x = ((x3 * u + x2) * u + x1) * u + x0;
                        let g = ((g3 * u + g2) * u + g1) * u + g0;
                        let mut light = g * weight;
                        if absorbs {
                            let before = (((d3 * u + d2) * u + d1) * u + g0) * u;
                            light *= exp(simd, -before);
                        }
                        if is_cued {
                            light *= fall * u + cue;
                            cued += light;
                        }
                        far = light.mul_add(x, far);
                    }
                    if is_cued {
                        all = cued.max(zero).min(opacity);
                    }
                    far = far.max(zero).min(all);
                }
            }
        }
        if model != OpticalModel::Absorption {
            let passed = match absorbs {
                true => exp(simd, -depth[0]),
                false => one,
            };
            for (channel, sum) in light.iter_mut().enumerate() {
                let (color, change) = (row(5 + 2 * channel), row(6 + 2 * channel));
                add(sum, passed * color.mul_add(all, change * far));
            }
        }
        if model != OpticalModel::Emission {
            add(&mut depth, part);
        }

        let crossed = crosses & !limited;
        let ended = !crosses & !limited & turn.simd_ge(one);
        tau = limited.select(tau + step, until);
        let opaque = depth[0].simd_gt(splat(shared.stop_depth)).to_bitmask() & alive;
        let crossed = crossed.to_bitmask() & alive & !opaque;
        if crossed != 0 {
            next_rows(&mut inbox, shared.table, crossed, rises.to_bitmask());
        }
        let done = ended.to_bitmask() & alive;
        fresh = 0;
        if done | opaque != 0 {
            fresh = next_cells(
                shared,
                &mut lanes,
                &mut inbox,
                &mut queue,
                &mut pixels,
                &mut work,
                (done, opaque),
                (&mut alive, &mut started),
                (&light, &depth),
            );
        }
    }
    (pixels, work)
}

/// Moves lanes that crossed a knot to the row on its other side.
#[inline(always)]
fn next_rows(inbox: &mut Inbox, table: &Table, crossed: u64, rises: u64) {
    let mut bits = crossed;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        // The outermost rows reach beyond every scalar.
        inbox.index[lane] = match rises >> lane & 1 {
            1 => inbox.index[lane] + 1,
            _ => inbox.index[lane] - 1,
        };
        inbox.put_row(lane, table.row(inbox.index[lane]));
    }
}

/// Gives lanes whose cell is done the next one, and those whose ray is done the next ray.
/// Returns which have a new cell.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one step of one loop")]
fn next_cells<S: Simd>(
    shared: &Shared,
    lanes: &mut [Lane; LANES],
    inbox: &mut Inbox,
    queue: &mut Queue,
    pixels: &mut [Pixel],
    work: &mut Work,
    (done, opaque): (u64, u64),
    (alive, started): (&mut u64, &mut u64),
    (light, depth): (&[[f32x8<S>; 2]; 3], &[f32x8<S>; 2]),
) -> u64 {
    let mut fresh = 0;
    let mut bits = done | opaque;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        work.visits += 1;
        let ray = &mut lanes[lane];
        let next = match opaque >> lane & 1 {
            1 => None,
            _ => ray.walk.next(shared.tree),
        };
        if let Some(stretch) = next {
            inbox.put_cell(shared, lane, ray, &stretch);
            fresh |= 1 << lane;
            continue;
        }
        let sum = |sum: &[f32x8<S>; 2]| f64::from(sum[0][lane]) - f64::from(sum[1][lane]);
        let color = DVec3::new(sum(&light[0]), sum(&light[1]), sum(&light[2]));
        let pixel = shared.finish.pixel(color, sum(depth));
        pixels[ray.pixel as usize] = (pixel, f32::INFINITY);
        work.skipped += ray.walk.skipped;
        match queue.start(shared, pixels, work) {
            Some((ray, stretch)) => {
                inbox.put_cell(shared, lane, &ray, &stretch);
                lanes[lane] = ray;
                fresh |= 1 << lane;
                *started |= 1 << lane;
            }
            None => *alive &= !(1 << lane),
        }
    }
    fresh
}

/// Adds to a compensated sum; its second number is what the first has too much.
#[inline(always)]
fn add<S: Simd>(sum: &mut [f32x8<S>; 2], term: f32x8<S>) {
    let term = term - sum[1];
    let next = sum[0] + term;
    sum[1] = (next - sum[0]) - term;
    sum[0] = next;
}

/// The scalar in powers of τ on the way through each lane's new cell, and the extremes in (0, 1),
/// by increasing τ, 1 where there is none.
#[inline(always)]
fn power_form<S: Simd>(simd: S, inbox: &Inbox, table: &Table) -> ([f32x8<S>; 4], [f32x8<S>; 2]) {
    let load = |numbers: &[f32; LANES]| f32x8::load_array_ref(simd, numbers);
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let (half, base, unit) = (table.half, table.base, table.unit);
    let scalar = |i: usize| {
        let mapped = (load(&inbox.corners[i]) * half - base) * unit;
        mapped
            .max(f32x8::splat(simd, -HUGE))
            .min(f32x8::splat(simd, HUGE))
    };
    let s: [f32x8<S>; 8] = [0, 1, 2, 3, 4, 5, 6, 7].map(
        #[inline(always)]
        |i| scalar(i),
    );
    let place = |numbers: &[f32; LANES]| load(numbers).max(zero).min(one);
    let [x, y, z] = [
        place(&inbox.entry[0]),
        place(&inbox.entry[1]),
        place(&inbox.entry[2]),
    ];
    let [dx, dy, dz] = [
        place(&inbox.exit[0]) - x,
        place(&inbox.exit[1]) - y,
        place(&inbox.exit[2]) - z,
    ];
    // s = s₀ + kx x + ky y + kz z + kxy x y + … + kxyz x y z.
    let (kx, ky, kz) = (s[1] - s[0], s[2] - s[0], s[4] - s[0]);
    let kxy = (s[3] - s[2]) - kx;
    let kxz = (s[5] - s[4]) - kx;
    let kyz = (s[6] - s[4]) - ky;
    let kxyz = ((s[7] - s[6]) - (s[5] - s[4])) - kxy;
    // The same about the entry.
    let mixed_yz = kxyz.mul_add(x, kyz);
    let mixed_xz = kxyz.mul_add(y, kxz);
    let mixed_xy = kxyz.mul_add(z, kxy);
    let along_x = mixed_xy.mul_add(y, kxz.mul_add(z, kx));
    let along_y = mixed_xy.mul_add(x, kyz.mul_add(z, ky));
    let along_z = mixed_xz.mul_add(x, kyz.mul_add(y, kz));
    let c0 = {
        let low = along_x.mul_add(x, ky.mul_add(y, kz.mul_add(z, s[0])));
        kyz.mul_add(y * z, low)
    };
    let c1 = along_x.mul_add(dx, along_y.mul_add(dy, along_z * dz));
    let (dxy, dxz, dyz) = (dx * dy, dx * dz, dy * dz);
    let c2 = mixed_xy.mul_add(dxy, mixed_xz.mul_add(dxz, mixed_yz * dyz));
    let c3 = kxyz * (dxy * dz);

    // c₁ + 2 c₂ τ + 3 c₃ τ² = 0, without cancellation: q/(3 c₃) and c₁/q.
    let triple = c3 * 3.0;
    let discriminant = c2.mul_add(c2, -(triple * c1));
    let root = discriminant.max(zero).sqrt();
    let q = -(c2 + root.copysign(c2));
    let (r1, r2) = (q / triple, c1 / q);
    let is_inside = |r: f32x8<S>| (discriminant.simd_gt(zero) & r.simd_gt(zero)) & r.simd_lt(one);
    let r1 = is_inside(r1).select(r1, one);
    let r2 = is_inside(r2).select(r2, one);
    ([c0, c1, c2, c3], [r1.min(r2), r1.max(r2)])
}

/// Where in [`from`, `to`] the cubic, which goes there from `ends[0]` to `ends[1]` without turning,
/// takes the value of the `knot` between them; anything in lanes that are not `wanted`.
///
/// Newton's steps while they stay in a bracket, which is halved where they do not. Lanes that are
/// done stay as they are, so that none depends on others.
#[inline(always)]
fn root<S: Simd>(
    simd: S,
    [c0, c1, c2, c3]: &[f32x8<S>; 4],
    knot: f32x8<S>,
    [from, to]: [f32x8<S>; 2],
    ends: [f32x8<S>; 2],
    wanted: mask32x8<S>,
) -> f32x8<S> {
    // A place in [0, 1] has no more digits.
    let near = f32x8::splat(simd, 6e-8);
    let (mut low, mut high) = (from, to);
    let rise = ends[1] - ends[0];
    let sign = f32x8::splat(simd, 1.0).copysign(rise);
    let share = ((knot - ends[0]) / rise).max(f32x8::splat(simd, 0.0));
    let mut t = share.mul_add(to - from, from).min(to);
    let mut open = wanted;
    for _ in 0..40 {
        let value = c3.mul_add(t, *c2).mul_add(t, *c1).mul_add(t, *c0);
        let excess = (value - knot) * sign;
        let slope = (*c3 * 3.0).mul_add(t, *c2 * 2.0).mul_add(t, *c1) * sign;
        let is_before = excess.simd_lt(0.0);
        low = is_before.select(t, low);
        high = is_before.select(high, t);
        let newton = t - excess / slope;
        let stays = newton.simd_ge(low) & newton.simd_le(high);
        let next = stays.select(newton, (low + high) * 0.5);
        let moved = (next - t).abs();
        t = open.select(next, t);
        open &= moved.simd_gt(near) & (high - low).simd_gt(near);
        if !open.any_true() {
            break;
        }
    }
    t
}

/// ∫₀¹ of the product of two cubics.
#[inline(always)]
fn moment<S: Simd>(x: [f32x8<S>; 4], g: [f32x8<S>; 4]) -> f32x8<S> {
    let row = |i: usize| {
        let weight = |j: usize| 1.0 / (i + j + 1) as f32;
        let sum = (g[0] * weight(0) + g[1] * weight(1)) + (g[2] * weight(2) + g[3] * weight(3));
        x[i] * sum
    };
    (row(0) + row(1)) + (row(2) + row(3))
}

/// 1 − e^(−m) for m ≥ 0, relative to 2⁻²² where m is small: up to 1, m times the polynomial of
/// `thin_opacity` in `shaders/wgsl/common/optics.wgsl`, which is off by 2.0e-9.
#[inline(always)]
fn opacity<S: Simd>(simd: S, m: f32x8<S>) -> f32x8<S> {
    const TERMS: [f32; 7] = [
        1.291_868_7e-4,
        -1.301_107_3e-3,
        8.275_88e-3,
        -4.164_704_3e-2,
        1.666_634_6e-1,
        -4.999_998e-1,
        1.0,
    ];
    let mut sum = f32x8::splat(simd, TERMS[0]);
    for term in &TERMS[1..] {
        sum = sum.mul_add(m, f32x8::splat(simd, *term));
    }
    let is_deep = m.simd_gt(1.0);
    let thin = sum * m;
    match is_deep.any_true() {
        true => is_deep.select(1.0 - exp(simd, -m), thin),
        false => thin,
    }
}

/// e^x for x ≤ 0, to 2 units in the last place (S. Moshier, Cephes, `expf`).
#[inline(always)]
fn exp<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    // Below, 2ᵏ is no normal number.
    let x = x.max(f32x8::splat(simd, -87.0));
    let k = (x * std::f32::consts::LOG2_E).round_ties_even();
    // ln 2 in two parts, of which the first times k is exact.
    let r = k.mul_add(f32x8::splat(simd, -0.693_359_4), x);
    let r = k.mul_add(f32x8::splat(simd, 2.121_944_4e-4), r);
    const TERMS: [f32; 6] = [
        1.987_569_1e-4,
        1.398_199_9e-3,
        8.333_452e-3,
        4.166_579_6e-2,
        1.666_666_5e-1,
        5e-1,
    ];
    let mut sum = f32x8::splat(simd, TERMS[0]);
    for term in &TERMS[1..] {
        sum = sum.mul_add(r, f32x8::splat(simd, *term));
    }
    let sum = sum.mul_add(r * r, r) + 1.0;
    let bits: i32x8<S> = (k.to_int::<i32x8<S>>() + 127) << 23;
    sum * bits.bitcast::<f32x8<S>>()
}
