//! A block of pixels: its rays, their crossings, their walk, its pixels.

use fearless_simd::Level;
use tetrascope_core::OpticalModel;
use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;

use super::crossings::{Bins, Crossings};
use super::integral::{
    ABSORPTION, EMISSION, EMISSION_ABSORPTION, ISOSURFACES, MAXIMUM_INTENSITY, number,
};
use super::lanes::{Cast, Counts, Lanes};
use super::rays::{BlockRays, Class, STRIDE};
use super::walk::walk;
use super::{FrameScene, Scene};
use crate::segments::PathSegment;
use crate::simd::widest;

/// Memory that one block leaves to the next.
#[derive(Debug)]
pub(super) struct Workspace {
    rays: BlockRays,
    crossings: Crossings,
    lanes: Box<Lanes>,
}

impl Default for Workspace {
    fn default() -> Workspace {
        Workspace {
            rays: BlockRays::default(),
            crossings: Crossings::default(),
            lanes: Box::new(Lanes::new()),
        }
    }
}

/// A block's part of the frame.
#[derive(Debug)]
pub(crate) struct Block {
    /// From the first to before the last.
    pub(crate) columns: [usize; 2],
    pub(crate) rows: [usize; 2],
    /// Pixels that a ray through the mesh has changed: the place in the block, row by row, the
    /// pixel, and how far the surface is.
    pub(super) pixels: Vec<(u32, [f32; 4], f32)>,
    /// Segments of paths by themselves: the place in the block, and the segment.
    pub(crate) segments: Vec<(u32, PathSegment)>,
    pub(crate) counts: Counts,
}

impl Block {
    /// Hands items, which begin with their place in the block, to `put` with their place in the image.
    pub(super) fn put<T: Placed>(
        &self,
        items: &[T],
        image_width: usize,
        mut put: impl FnMut(usize, &T),
    ) {
        let width = self.columns[1] - self.columns[0];
        for item in items {
            let place = item.place() as usize;
            let (column, row) = (place % width, place / width);
            let at = (self.rows[0] + row) * image_width + self.columns[0] + column;
            put(at, item);
        }
    }

    /// Casts the rays of a block.
    pub(super) fn cast(
        frame: &FrameScene,
        bins: &Bins,
        index: usize,
        level: Level,
        workspace: &mut Workspace,
    ) -> Block {
        let (x, y) = (
            index % bins.across * bins.side,
            index / bins.across * bins.side,
        );
        let columns = [x, (x + bins.side).min(frame.size[0])];
        let rows = [y, (y + bins.side).min(frame.size[1])];
        let mut block = Block {
            columns,
            rows,
            pixels: Vec::new(),
            segments: Vec::new(),
            counts: Counts::default(),
        };
        let faces = bins.of(index);
        if faces.is_empty() {
            return block;
        }
        let classes = frame.camera.classes(columns, rows);
        let Workspace {
            rays,
            crossings,
            lanes,
        } = workspace;
        for class in (0..Class::COUNT).map(Class) {
            if classes >> class.0 & 1 == 0 {
                continue;
            }
            let scene = Scene {
                mesh: frame.mesh,
                style: frame.style,
                camera: frame.camera,
                vertices: frame.vertices(class),
                class,
                has_cue: frame.camera.has_cue(),
                columns,
                rows,
                lights: &frame.lights,
                by_path: frame.by_path,
            };
            frame.camera.set(class, columns, rows, rays);
            let boundary = &frame.mesh.places.boundary;
            let places = [columns, rows];
            widest!(level, simd => {
                crossings.find(simd, boundary, scene.vertices, faces, rays, places)
            });
            crossings.sort((rows[1] - rows[0]) * STRIDE);
            match number(frame.style.appearance.optical_model) {
                EMISSION_ABSORPTION => widest!(level, simd => {
                    walk::<_, EMISSION_ABSORPTION>(simd, &scene, rays, crossings, lanes)
                }),
                EMISSION => widest!(level, simd => {
                    walk::<_, EMISSION>(simd, &scene, rays, crossings, lanes)
                }),
                ABSORPTION => widest!(level, simd => {
                    walk::<_, ABSORPTION>(simd, &scene, rays, crossings, lanes)
                }),
                MAXIMUM_INTENSITY => widest!(level, simd => {
                    walk::<_, MAXIMUM_INTENSITY>(simd, &scene, rays, crossings, lanes)
                }),
                _ => widest!(level, simd => {
                    walk::<_, ISOSURFACES>(simd, &scene, rays, crossings, lanes)
                }),
            }
            block.counts += lanes.counts;
            let place = |cast: &Cast| {
                let ray = cast.ray as usize;
                (ray / STRIDE * (columns[1] - columns[0]) + ray % STRIDE) as u32
            };
            if frame.by_path {
                let segments = lanes.done.iter();
                let segments = segments.map(|cast| (place(cast), scene.segment(cast)));
                block.segments.extend(segments);
                continue;
            }
            block.pixels.extend(lanes.done.iter().map(|cast| {
                let (pixel, depth) = scene.pixel(cast, frame.background);
                (place(cast), pixel, depth)
            }));
        }
        block
    }
}

impl Scene<'_> {
    /// A ray's pixel, and how far its surface is, world units.
    fn pixel(&self, cast: &Cast, background: [f64; 4]) -> ([f32; 4], f32) {
        let model = self.style.appearance.optical_model;
        let light = DVec3::from(cast.light.map(f64::from));
        let (light, depth) = match model {
            OpticalModel::Absorption => (DVec3::ZERO, light.x),
            OpticalModel::EmissionAbsorption | OpticalModel::Isosurfaces => {
                (light, -cast.transmittance.ln())
            }
            _ => (light, 0.0),
        };
        let distance = cast.surface.map_or(f64::INFINITY, |z| {
            let [column, row] = self.place(cast.ray as usize);
            self.camera.distance(self.class, column, row, z)
        });
        let pixel = over(model, light, depth, background).map(|value| value as f32);
        (pixel, distance as f32)
    }

    /// A path by itself.
    fn segment(&self, cast: &Cast) -> PathSegment {
        let [column, row] = self.place(cast.ray as usize);
        // In f64, so that other z are at other distances, in the same order.
        let distance = |z: f64| self.camera.distance(self.class, column, row, z);
        let [near, far] = cast.ends.map(|z| distance(z.into()));
        let (light, transmittance) = match self.style.appearance.optical_model {
            OpticalModel::Absorption => ([0.0; 3], (-f64::from(cast.light[0])).exp()),
            _ => (cast.light, cast.transmittance),
        };
        // A surface is where it is met.
        let near = cast.surface.map_or(near, distance);
        PathSegment {
            near,
            far,
            light,
            transmittance,
        }
    }

    /// Column and row of a ray.
    pub(super) fn place(&self, ray: usize) -> [usize; 2] {
        [self.columns[0] + ray % STRIDE, self.rows[0] + ray / STRIDE]
    }
}

/// Something that has a place in a block.
pub(super) trait Placed {
    fn place(&self) -> u32;
}

impl Placed for (u32, [f32; 4], f32) {
    fn place(&self) -> u32 {
        self.0
    }
}

impl Placed for (u32, PathSegment) {
    fn place(&self) -> u32 {
        self.0
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Counts) {
        self.visits += more.visits;
        self.paths += more.paths;
        self.unpaired += more.unpaired;
        self.lost += more.lost;
    }
}
