//! Data kept per lane, where vectors are taken apart: rays that wait, and the lane's ray, path and
//! interval.

use tetrascope_core::glam::DVec3;

use super::Scene;
use super::crossings::{Crossing, Crossings, TAKEN};
use super::packed::Vertex;
use super::rays::BlockRays;
use super::seams;
use super::style::{HIGH, Interval, LOW, STEP_HIGH, VALUES, find, sample};
use crate::simd::{MOST_LANES, PerLane};

/// A lane without a ray.
pub(super) const NO_RAY: u32 = u32::MAX;

/// The results of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cast {
    /// The ray's place in its block.
    pub(super) ray: u32,
    pub(super) light: [f32; 3],
    pub(super) transmittance: f64,
    /// z of the isosurface that it met.
    pub(super) surface: Option<f64>,
    /// z of the path's ends, where each is put away by itself.
    pub(super) ends: [f32; 2],
}

/// Counts of a block's rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(super) visits: u64,
    pub(super) paths: u64,
    pub(super) unpaired: u64,
    pub(super) lost: u64,
}

/// How a lane's path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// At this boundary face.
    Left(u32),
    /// Nothing behind shows, or the ray ends.
    Stopped,
    /// It came through more cells than there are: it goes round in a circle, which should never happen.
    Never,
}

/// The isosurface that a lane's ray has met.
#[derive(Clone, Copy, Debug)]
struct Surface {
    z: f64,
    color: DVec3,
}

/// All lanes of a packet.
#[derive(Debug)]
pub(super) struct Lanes {
    /// How many there are.
    pub(super) count: usize,
    // The ray.
    pub(super) ray: PerLane<u32>,
    begin: PerLane<usize>,
    at: PerLane<usize>,
    end: PerLane<usize>,
    surface: PerLane<Option<Surface>>,
    /// Through, slope, depth, begin, end and cue, as in [`BlockRays`].
    pub(super) line: [PerLane<f32>; 9],
    pub(super) light: [PerLane<f32>; 3],
    /// The light of earlier steps, and the part that roundings took from it.
    pub(super) light_before: [PerLane<f32>; 3],
    pub(super) light_lost: [PerLane<f32>; 3],
    pub(super) transmittance: PerLane<f32>,
    pub(super) lost: PerLane<f32>,
    /// z where the path begins, and how far it has come.
    near: PerLane<f32>,
    pub(super) seen: PerLane<f32>,
    /// The step before which it begins.
    begun: PerLane<u64>,
    /// z and scalar where the path begins, of a part of a mesh.
    pub(super) entered: [PerLane<f32>; 2],
    // The path: the face by which it comes in.
    pub(super) face: [PerLane<Vertex>; 3],
    pub(super) ids: [PerLane<i32>; 3],
    pub(super) cell: PerLane<i32>,
    // The step.
    pub(super) rank: PerLane<i32>,
    /// The exclusive or of the ids of the face that is crossed.
    pub(super) crossed: PerLane<i32>,
    /// The cell's fourth vertex.
    pub(super) fourth: PerLane<Vertex>,
    pub(super) fourth_id: PerLane<i32>,
    /// The cell's own scalar, of cell data.
    pub(super) scalar: PerLane<f32>,
    // The interval of the transfer function.
    pub(super) interval: [PerLane<f32>; VALUES],
    index: PerLane<usize>,
    /// The isosurfaces' values next to the scalar: at most it, and above it.
    pub(super) band: [PerLane<f32>; 2],
    // Rays that wait.
    next_ray: usize,
    /// Rays that are done.
    pub(super) done: Vec<Cast>,
    pub(super) counts: Counts,
}

impl Lanes {
    pub(super) fn new() -> Lanes {
        const ZEROS: PerLane<f32> = [0.0; MOST_LANES];
        const NONE: PerLane<Vertex> = [[f32::NAN; 4]; MOST_LANES];
        Lanes {
            count: 0,
            ray: [NO_RAY; MOST_LANES],
            begin: [0; MOST_LANES],
            at: [0; MOST_LANES],
            end: [0; MOST_LANES],
            surface: [None; MOST_LANES],
            line: [ZEROS; 9],
            light: [ZEROS; 3],
            light_before: [ZEROS; 3],
            light_lost: [ZEROS; 3],
            transmittance: ZEROS,
            lost: ZEROS,
            near: ZEROS,
            seen: ZEROS,
            begun: [0; MOST_LANES],
            entered: [ZEROS; 2],
            face: [NONE; 3],
            ids: [[0; MOST_LANES]; 3],
            cell: [0; MOST_LANES],
            rank: [0; MOST_LANES],
            crossed: [0; MOST_LANES],
            fourth: NONE,
            fourth_id: [0; MOST_LANES],
            scalar: ZEROS,
            interval: [ZEROS; VALUES],
            index: [0; MOST_LANES],
            band: [ZEROS; 2],
            next_ray: 0,
            done: Vec::new(),
            counts: Counts::default(),
        }
    }

    /// Before the first ray of a block.
    pub(super) fn start(&mut self, count: usize) {
        self.count = count;
        self.ray = [NO_RAY; MOST_LANES];
        // No interval.
        self.interval = [[0.0; MOST_LANES]; VALUES];
        self.next_ray = 0;
        self.done.clear();
        self.counts = Counts::default();
    }

    /// Whether no lane has a ray.
    pub(super) fn are_idle(&self) -> bool {
        self.ray[..self.count].iter().all(|ray| *ray == NO_RAY)
    }

    /// The lanes whose path has passed more cells than there are.
    pub(super) fn endless(&self, step: u64, cell_count: usize) -> u64 {
        let is_endless = |lane: &usize| step - self.begun[*lane] > cell_count as u64;
        (0..self.count)
            .filter(is_endless)
            .fold(0, |bits, lane| bits | 1 << lane)
    }

    /// Takes a lane whose path ended before this step to its ray's next path, or to the next ray.
    #[cold]
    #[inline(never)]
    pub(super) fn go_on(
        &mut self,
        lane: usize,
        end: End,
        step: u64,
        scene: &Scene,
        rays: &BlockRays,
        crossings: &mut Crossings,
    ) {
        let mut is_over = false;
        self.begun[lane] = step;
        if self.ray[lane] != NO_RAY {
            self.counts.paths += 1;
            match end {
                End::Left(face) => {
                    let rest = &mut crossings.sorted()[self.at[lane]..self.end[lane]];
                    match rest.iter_mut().find(|crossing| crossing.face == face) {
                        Some(crossing) => crossing.face = TAKEN,
                        None => self.counts.lost += 1,
                    }
                }
                End::Stopped => is_over = true,
                End::Never => {
                    self.counts.lost += 1;
                    is_over = true;
                }
            }
            if scene.by_path {
                self.put_path_away(lane, scene.shows_layers());
            }
        }
        loop {
            if self.ray[lane] == NO_RAY && !self.take_ray(lane, rays, crossings) {
                self.face
                    .iter_mut()
                    .for_each(|face| face[lane] = [f32::NAN; 4]);
                self.line.iter_mut().for_each(|line| line[lane] = f32::NAN);
                self.cell[lane] = scene.mesh.cell_count as i32;
                return;
            }
            let place = self.at[lane];
            if is_over || place == self.end[lane] {
                if !scene.by_path {
                    self.put_away(lane);
                }
                self.ray[lane] = NO_RAY;
                is_over = false;
                continue;
            }
            self.at[lane] += 1;
            let crossing = crossings.sorted()[place];
            if crossing.face == TAKEN {
                continue;
            }
            // Later crossings are behind it.
            if crossing.z >= self.line[6][lane] {
                is_over = true;
                continue;
            }
            self.enter(lane, crossing, scene);
            return;
        }
    }

    /// Takes the next ray that crosses anything.
    fn take_ray(&mut self, lane: usize, rays: &BlockRays, crossings: &Crossings) -> bool {
        while self.next_ray < rays.depth.len() {
            let ray = self.next_ray;
            self.next_ray += 1;
            let range = crossings.range(ray);
            if range.is_empty() {
                continue;
            }
            self.counts.unpaired += range.len() as u64 % 2;
            self.ray[lane] = ray as u32;
            (self.begin[lane], self.at[lane], self.end[lane]) =
                (range.start, range.start, range.end);
            let values = [
                &rays.through[0],
                &rays.through[1],
                &rays.slope[0],
                &rays.slope[1],
                &rays.depth,
                &rays.begin,
                &rays.end,
                &rays.cue[0],
                &rays.cue[1],
            ];
            for (line, values) in self.line.iter_mut().zip(values) {
                line[lane] = values[ray];
            }
            self.forget(lane);
            return true;
        }
        false
    }

    /// Forgets what a lane has gathered.
    fn forget(&mut self, lane: usize) {
        for light in [
            &mut self.light,
            &mut self.light_before,
            &mut self.light_lost,
        ] {
            light.iter_mut().for_each(|light| light[lane] = 0.0);
        }
        self.transmittance[lane] = 1.0;
        self.lost[lane] = 0.0;
        self.surface[lane] = None;
    }

    /// Ends a lane's path, if some of it is between the ray's ends, or where thin layers are seen too.
    fn put_path_away(&mut self, lane: usize, shows_layers: bool) {
        let near = self.near[lane].max(self.line[5][lane]);
        let far = self.seen[lane].min(self.line[6][lane]);
        if near < far || shows_layers {
            self.put_away(lane);
            if let Some(cast) = self.done.last_mut() {
                cast.ends = [near, far];
            }
        }
        self.forget(lane);
    }

    /// Puts what a lane has gathered to what is done.
    fn put_away(&mut self, lane: usize) {
        let surface = self.surface[lane];
        let gathered = [0, 1, 2].map(|i| {
            let parts = [&self.light_before, &self.light_lost, &self.light];
            parts
                .iter()
                .map(|part| f64::from(part[i][lane]))
                .sum::<f64>() as f32
        });
        self.done.push(Cast {
            ray: self.ray[lane],
            light: surface.map_or(gathered, |s| s.color.as_vec3().to_array()),
            transmittance: f64::from(self.transmittance[lane]) + f64::from(self.lost[lane]),
            surface: surface.map(|s| s.z),
            ends: [0.0; 2],
        });
    }

    /// Begins a path.
    fn enter(&mut self, lane: usize, crossing: Crossing, scene: &Scene) {
        let [a, b, c, cell] = scene.mesh.places.boundary[crossing.face as usize];
        // So that edges pass on the same side of all rays.
        let corners = if crossing.is_positive {
            [a, b, c]
        } else {
            [a, c, b]
        };
        for (i, corner) in corners.into_iter().enumerate() {
            self.face[i][lane] = scene.vertices[corner as usize];
            self.ids[i][lane] = corner as i32;
        }
        self.cell[lane] = cell as i32;
        self.near[lane] = crossing.z;
        if scene.by_path {
            let [z, scalar] = self.at_seam(lane, crossing.face, scene);
            self.near[lane] = z;
            (self.entered[0][lane], self.entered[1][lane]) = (z, scalar);
        }
        self.crossed[lane] = (a ^ b ^ c) as i32;
        // Its lane's first path: wherever it begins, the interval is found.
        if self.interval[HIGH][lane] <= self.interval[LOW][lane] {
            self.set_interval(lane, 0, scene);
        }
        self.band.iter_mut().for_each(|band| band[lane] = f32::NAN);
    }

    /// z and scalar where a lane's ray crosses a boundary face, as another part computes them, too.
    pub(super) fn at_seam(&self, lane: usize, face: u32, scene: &Scene) -> [f32; 2] {
        let [a, b, c, _] = scene.mesh.places.boundary[face as usize];
        let corners = [a, b, c].map(|id| scene.vertices[id as usize]);
        let line = |values: [usize; 2]| values.map(|i| self.line[i][lane]);
        seams::crossing(line([0, 1]), line([2, 3]), corners)
    }

    /// Loads the interval with this index.
    fn set_interval(&mut self, lane: usize, index: usize, scene: &Scene) {
        self.index[lane] = index;
        let interval = &scene.style.intervals[index];
        for (values, value) in self.interval.iter_mut().zip(interval) {
            values[lane] = *value;
        }
    }

    /// Moves lanes to the next interval up or down.
    #[cold]
    #[inline(never)]
    pub(super) fn next_intervals(&mut self, up: u64, down: u64, scene: &Scene) {
        for lane in lanes_of(up | down) {
            let index = self.index[lane];
            let index = if up >> lane & 1 == 1 {
                index + 1
            } else {
                index - 1
            };
            self.set_interval(lane, index, scene);
        }
    }

    /// Moves lanes to the intervals in which their pieces begin.
    #[cold]
    #[inline(never)]
    pub(super) fn find_intervals(
        &mut self,
        lanes: u64,
        [front, back]: [&PerLane<f32>; 2],
        scene: &Scene,
    ) {
        for lane in lanes_of(lanes) {
            let rising = front[lane] <= back[lane];
            self.set_interval(
                lane,
                find(&scene.style.intervals, front[lane], rising),
                scene,
            );
        }
    }

    /// Lets lanes whose scalar is constant and on a step read the mean of both sides.
    #[cold]
    #[inline(never)]
    pub(super) fn halve_steps(&mut self, lanes: u64, scalar: &PerLane<f32>, scene: &Scene) {
        for lane in lanes_of(lanes) {
            let here = self.index[lane];
            let there = if scalar[lane] == self.interval[STEP_HIGH][lane] {
                here + 1
            } else {
                here - 1
            };
            let of = |index: usize| -> &Interval { &scene.style.intervals[index] };
            let (one, other) = (
                sample(of(here), scalar[lane]),
                sample(of(there), scalar[lane]),
            );
            for i in 0..4 {
                self.interval[i][lane] = 0.5 * (one[i] + other[i]);
                self.interval[4 + i][lane] = 0.0;
            }
        }
    }

    /// Ends what [`Lanes::halve_steps`] did.
    #[cold]
    #[inline(never)]
    pub(super) fn restore_intervals(&mut self, lanes: u64, scene: &Scene) {
        for lane in lanes_of(lanes) {
            self.set_interval(lane, self.index[lane], scene);
        }
    }

    /// Meets the first isosurface that lanes' pieces cross, or finds the values next to their
    /// scalars anew; returns which lanes met one. A piece is front, back, and z of both.
    #[cold]
    #[inline(never)]
    pub(super) fn meet_surfaces(
        &mut self,
        lanes: u64,
        [front, back, near, far]: &[PerLane<f32>; 4],
        [a, b, c, d, cells]: &[PerLane<i32>; 5],
        scene: &Scene,
    ) -> u64 {
        let surfaces = &scene.style.surfaces;
        let mut met = 0;
        for lane in lanes_of(lanes) {
            let (from, to) = (front[lane], back[lane]);
            let above = surfaces.partition_point(|(value, _)| *value <= from);
            let below = above.checked_sub(1);
            let value = |i: Option<usize>, none: f32| {
                let surface = i.and_then(|i| surfaces.get(i));
                surface.map_or(none, |(value, _)| *value)
            };
            self.band[0][lane] = value(below, f32::NEG_INFINITY);
            self.band[1][lane] = value(Some(above), f32::INFINITY);
            let first = if to >= self.band[1][lane] {
                above
            } else if to < self.band[0][lane] {
                above - 1
            } else {
                continue;
            };
            let (value, number) = surfaces[first];
            let share = (f64::from(value) - f64::from(from)) / (f64::from(to) - f64::from(from));
            let z = f64::from(near[lane]) + share * (f64::from(far[lane]) - f64::from(near[lane]));
            let ids = [a, b, c, d].map(|ids| ids[lane] as u32);
            let ray = self.ray[lane] as usize;
            let cue = f64::from(self.line[7][lane]) + z * f64::from(self.line[8][lane]);
            let color = scene.shade(number, cells[lane] as u32, ids, ray) * cue.clamp(0.0, 1.0);
            self.surface[lane] = Some(Surface { z, color });
            self.transmittance[lane] = 0.0;
            self.lost[lane] = 0.0;
            met |= 1 << lane;
        }
        met
    }
}

/// The lanes in a mask.
pub(super) fn lanes_of(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        let left = mask != 0;
        mask &= mask.wrapping_sub(1);
        left.then_some(lane)
    })
}
