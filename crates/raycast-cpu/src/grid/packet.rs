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

/// In place of the number of a row of the table.
const NO_ROW: u32 = u32::MAX;

/// Mapped scalars beyond this are as good as infinite, and products of a few still fit f32.
const HUGE: f32 = 1e30;

/// Data that all packets of a frame share.
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

/// The work that was done for a square.
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

/// All of a square but the arithmetic: its rays, their cells, and its pixels.
///
/// None of it depends on the vectors' instructions, so that it is compiled once.
struct Desk<'a> {
    shared: &'a Shared<'a>,
    square: Square,
    lanes: [Lane; LANES],
    inbox: Inbox,
    pixels: Vec<Pixel>,
    work: Work,
    /// The next pixel that no lane has taken.
    next: u32,
    /// Lanes with a ray, with a new cell, and with a new ray.
    alive: u64,
    fresh: u64,
    started: u64,
}

/// Light and depth of all lanes, each with its compensation.
type Sums = [[[f32; LANES]; 2]; 4];

impl<'a> Desk<'a> {
    /// With a ray in each lane, as far as there are rays that meet anything.
    #[inline(never)]
    fn new(shared: &'a Shared<'a>, square: Square) -> Desk<'a> {
        let empty = (shared.finish.pixel(DVec3::ZERO, 0.0), f32::INFINITY);
        let mut desk = Desk {
            shared,
            square,
            lanes: [Lane::default(); LANES],
            inbox: Inbox::default(),
            pixels: vec![empty; (square.size[0] * square.size[1]) as usize],
            work: Work::default(),
            next: 0,
            alive: 0,
            fresh: 0,
            started: 0,
        };
        desk.inbox.index = [NO_ROW; LANES];
        for lane in 0..LANES {
            desk.start(lane);
        }
        desk
    }

    /// Starts the next ray that meets anything in a lane.
    fn start(&mut self, lane: usize) {
        let [width, height] = self.square.size;
        let [x, y] = self.square.first;
        let tree = self.shared.tree;
        while self.next < width * height {
            let pixel = self.next;
            self.next += 1;
            let ray = self.shared.rays.ray(x + pixel % width, y + pixel / width);
            let Some(walk) = Walk::new(ray.line, tree, ray.kept) else {
                continue;
            };
            let own = &mut self.lanes[lane];
            *own = Lane {
                walk,
                line: ray.line,
                cue: ray.cue,
                pixel,
            };
            if let Some(stretch) = own.walk.next(tree) {
                self.inbox.put_cell(self.shared, lane, own, &stretch);
                self.alive |= 1 << lane;
                self.fresh |= 1 << lane;
                self.started |= 1 << lane;
                return;
            }
            self.work.skipped += own.walk.skipped;
        }
        self.alive &= !(1 << lane);
    }

    /// Finds the rows in which new cells begin, where the mapped scalar is that of `scalars`;
    /// in `flat` lanes it is constant.
    #[inline(never)]
    fn find_rows(&mut self, flat: u64, scalars: &[f32; LANES]) {
        let table = self.shared.table;
        for lane in ones(self.fresh) {
            if flat >> lane & 1 == 1
                && let Some(row) = table.step(self.inbox.corners[0][lane])
            {
                self.inbox.put_row(lane, row);
                self.inbox.index[lane] = NO_ROW;
                continue;
            }
            let index = table.find(scalars[lane]);
            if self.inbox.index[lane] != index {
                self.inbox.index[lane] = index;
                self.inbox.put_row(lane, table.row(index));
            }
        }
    }

    /// Moves lanes that crossed a knot to the row on its other side.
    #[inline(never)]
    fn next_rows(&mut self, crossed: u64, rises: u64) {
        let table = self.shared.table;
        for lane in ones(crossed) {
            // The outermost rows reach beyond every scalar.
            let index = match rises >> lane & 1 {
                1 => self.inbox.index[lane] + 1,
                _ => self.inbox.index[lane] - 1,
            };
            self.inbox.index[lane] = index;
            self.inbox.put_row(lane, table.row(index));
        }
    }

    /// Gives lanes whose cell is done the next one, and those whose ray is done, or `opaque`, the
    /// next ray.
    #[inline(never)]
    fn next_cells(&mut self, done: u64, opaque: u64, sums: &Sums) {
        for lane in ones(done | opaque) {
            self.work.visits += 1;
            let ray = &mut self.lanes[lane];
            if opaque >> lane & 1 == 0
                && let Some(stretch) = ray.walk.next(self.shared.tree)
            {
                self.inbox.put_cell(self.shared, lane, ray, &stretch);
                self.fresh |= 1 << lane;
                continue;
            }
            let [r, g, b, depth] = sums
                .each_ref()
                .map(|[sum, excess]| f64::from(sum[lane]) - f64::from(excess[lane]));
            let pixel = self.shared.finish.pixel(DVec3::new(r, g, b), depth);
            self.pixels[ray.pixel as usize] = (pixel, f32::INFINITY);
            self.work.skipped += ray.walk.skipped;
            self.start(lane);
        }
    }
}

/// The places of the ones among `bits`.
fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            lane
        })
    })
}

/// Draws a square of pixels, row by row.
#[inline(always)]
pub(crate) fn draw<S: Simd>(simd: S, shared: &Shared, square: Square) -> (Vec<Pixel>, Work) {
    let mut desk = Desk::new(shared, square);
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let model = shared.finish.model;
    let absorbs = model == OpticalModel::EmissionAbsorption;
    let is_cued = shared.rays.is_cued();
    // Whether it matters where in a part light comes from.
    let weighs = is_cued || shared.table.is_colored;
    let rule = shared.table.rule;
    let deepest = f32x8::splat(simd, rule.deepest);
    let stop_depth = f32x8::splat(simd, shared.stop_depth);

    // The cubic in powers of τ, the share of the way through the cell.
    let mut cubic = [zero; 4];
    let mut extremes = [one; 2];
    let mut tau = one;
    let mut length = zero;
    // Light and depth with their compensations.
    let mut sums = [[zero; 2]; 4];
    while desk.alive != 0 {
        if desk.fresh != 0 {
            let is_fresh = mask32x8::from_bitmask(simd, desk.fresh);
            if desk.started != 0 {
                let is_started = mask32x8::from_bitmask(simd, desk.started);
                for sum in sums.iter_mut().flatten() {
                    *sum = is_started.select(zero, *sum);
                }
            }
            let (new, turns) = power_form(simd, &desk.inbox, shared.table);
            for i in 0..4 {
                cubic[i] = is_fresh.select(new[i], cubic[i]);
            }
            for i in 0..2 {
                extremes[i] = is_fresh.select(turns[i], extremes[i]);
            }
            tau = is_fresh.select(zero, tau);
            length = is_fresh.select(load(simd, &desk.inbox.length), length);
            let flat = (new[1].simd_eq(zero) & new[2].simd_eq(zero)) & new[3].simd_eq(zero);
            desk.find_rows(flat.to_bitmask(), &cubic[0].to_array());
            (desk.fresh, desk.started) = (0, 0);
        }
        let rows = &desk.inbox.rows;

        // To the next extreme or to the end of the cell.
        let before_first = tau.simd_lt(extremes[0]);
        let before_second = tau.simd_lt(extremes[1]);
        let turn = before_first.select(extremes[0], before_second.select(extremes[1], one));
        let [_, c1, c2, c3] = cubic;
        let (front, back) = (at(&cubic, tau), at(&cubic, turn));
        // To the knot, if one is before that.
        let (low, high) = (load(simd, &rows[0]), load(simd, &rows[1]));
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
        let inverse = load(simd, &rows[2]);
        let x0 = ((front - low) * inverse).max(zero).min(one);
        let slope = (c3 * 3.0).mul_add(tau, c2 * 2.0).mul_add(tau, c1);
        let bend = (c3 * 3.0).mul_add(tau, c2);
        let (x1, x2, x3) = (slope * inverse, bend * inverse, c3 * inverse);

        let mut limited = mask32x8::splat(simd, false);
        if model == OpticalModel::MaximumIntensity {
            let end = at(&[x0, x1, x2, x3], step).max(zero).min(one);
            for (channel, sum) in sums[..3].iter_mut().enumerate() {
                let color = load(simd, &rows[5 + 2 * channel]);
                let change = load(simd, &rows[6 + 2 * channel]);
                let most = change.mul_add(x0, color).max(change.mul_add(end, color));
                sum[0] = sum[0].max(most);
            }
        } else {
            // To the depth for which the rule serves.
            let (e0, de) = (load(simd, &rows[3]), load(simd, &rows[4]));
            if absorbs && weighs {
                let near = de.mul_add(x0, e0);
                for _ in 0..40 {
                    let x = at(&[x0, x1, x2, x3], step);
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
            let x = [x0, x1 * step, x2 * step2, x3 * (step2 * step)];
            let scale = de * span;
            let g0 = scale.mul_add(x0, e0 * span);
            let g = [g0, scale * x[1], scale * x[2], scale * x[3]];
            let before = [g0, g[1] * 0.5, g[2] * (1.0 / 3.0), g[3] * 0.25];
            let depth = ((before[0] + before[1]) + (before[2] + before[3])).max(zero);
            let (mut all, mut far) = (depth, zero);
            if model == OpticalModel::Emission && !is_cued {
                // ∫ x g, of degree 6.
                far = moment(simd, x, g).max(zero).min(depth);
            } else if model != OpticalModel::Absorption {
                let opacity = if absorbs { opacity(simd, depth) } else { depth };
                all = opacity;
                if weighs {
                    let (cue, fall) = match is_cued {
                        true => {
                            let near = load(simd, &desk.inbox.cue[0]);
                            let fall = load(simd, &desk.inbox.cue[1]);
                            (fall.mul_add(tau, near), fall * step)
                        }
                        false => (one, zero),
                    };
                    let mut cued = zero;
                    for &[u, weight] in rule.nodes {
                        let place = f32x8::splat(simd, u);
                        let mut light = at(&g, place) * weight;
                        if absorbs {
                            light *= exp(simd, -(at(&before, place) * u));
                        }
                        if is_cued {
                            light *= fall * u + cue;
                            cued += light;
                        }
                        far = light.mul_add(at(&x, place), far);
                    }
                    if is_cued {
                        all = cued.max(zero).min(opacity);
                    }
                    far = far.max(zero).min(all);
                }
            }
            if model != OpticalModel::Absorption {
                let passed = match absorbs {
                    true => exp(simd, -sums[3][0]),
                    false => one,
                };
                for (channel, sum) in sums[..3].iter_mut().enumerate() {
                    let color = load(simd, &rows[5 + 2 * channel]);
                    let change = load(simd, &rows[6 + 2 * channel]);
                    add(sum, passed * color.mul_add(all, change * far));
                }
            }
            if model != OpticalModel::Emission {
                add(&mut sums[3], depth);
            }
        }

        tau = limited.select(tau + step, until);
        let opaque = sums[3][0].simd_gt(stop_depth).to_bitmask() & desk.alive;
        let crossed = (crosses & !limited).to_bitmask() & desk.alive & !opaque;
        if crossed != 0 {
            desk.next_rows(crossed, rises.to_bitmask());
        }
        let ended = turn.simd_ge(one) & !crosses & !limited;
        let done = ended.to_bitmask() & desk.alive;
        if done | opaque != 0 {
            let mut numbers: Sums = Default::default();
            for (array, sum) in numbers.iter_mut().flatten().zip(sums.iter().flatten()) {
                sum.store_slice(array);
            }
            desk.next_cells(done, opaque, &numbers);
        }
    }
    (desk.pixels, desk.work)
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
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let mut s = [zero; 8];
    for (scalar, samples) in s.iter_mut().zip(&inbox.corners) {
        let mapped = (load(simd, samples) * table.half - table.base) * table.unit;
        let mapped = mapped.max(f32x8::splat(simd, -HUGE));
        *scalar = mapped.min(f32x8::splat(simd, HUGE));
    }
    let (mut entry, mut exit) = ([zero; 3], [zero; 3]);
    for axis in 0..3 {
        entry[axis] = load(simd, &inbox.entry[axis]).max(zero).min(one);
        exit[axis] = load(simd, &inbox.exit[axis]).max(zero).min(one);
    }
    let [x, y, z] = entry;
    let (dx, dy, dz) = (exit[0] - x, exit[1] - y, exit[2] - z);
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
    let turns = discriminant.simd_gt(zero);
    let is_first = turns & r1.simd_gt(zero) & r1.simd_lt(one);
    let is_second = turns & r2.simd_gt(zero) & r2.simd_lt(one);
    let (r1, r2) = (is_first.select(r1, one), is_second.select(r2, one));
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
    cubic: &[f32x8<S>; 4],
    knot: f32x8<S>,
    [from, to]: [f32x8<S>; 2],
    ends: [f32x8<S>; 2],
    wanted: mask32x8<S>,
) -> f32x8<S> {
    let [_, c1, c2, c3] = *cubic;
    // A place in [0, 1] has no more digits.
    let near = f32x8::splat(simd, 6e-8);
    let (mut low, mut high) = (from, to);
    let rise = ends[1] - ends[0];
    let sign = f32x8::splat(simd, 1.0).copysign(rise);
    let share = ((knot - ends[0]) / rise).max(f32x8::splat(simd, 0.0));
    let mut t = share.mul_add(to - from, from).min(to);
    let mut open = wanted;
    for _ in 0..40 {
        let excess = (at(cubic, t) - knot) * sign;
        let slope = (c3 * 3.0).mul_add(t, c2 * 2.0).mul_add(t, c1) * sign;
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
fn moment<S: Simd>(simd: S, x: [f32x8<S>; 4], g: [f32x8<S>; 4]) -> f32x8<S> {
    let mut sum = f32x8::splat(simd, 0.0);
    for (i, x) in x.into_iter().enumerate() {
        let mut row = g[0] * (1.0 / (i + 1) as f32);
        for (j, g) in g.into_iter().enumerate().skip(1) {
            row += g * (1.0 / (i + j + 1) as f32);
        }
        sum += x * row;
    }
    sum
}

#[inline(always)]
fn load<S: Simd>(simd: S, numbers: &[f32; LANES]) -> f32x8<S> {
    f32x8::load_array_ref(simd, numbers)
}

/// A cubic in powers, at `t`.
#[inline(always)]
fn at<S: Simd>([c0, c1, c2, c3]: &[f32x8<S>; 4], t: f32x8<S>) -> f32x8<S> {
    c3.mul_add(t, *c2).mul_add(t, *c1).mul_add(t, *c0)
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
