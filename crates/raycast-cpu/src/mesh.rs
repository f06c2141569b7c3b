//! Tetrahedral meshes: exact ray casting from cell to cell.
//!
//! 1. `packed` puts cells and vertices where rays read them, along a Morton curve.
//! 2. `style` is the transfer function as lanes read it.
//! 3. `rays` shears the rays of a block of pixels, `crossings` finds where they cross the boundary.
//! 4. `walk` takes a ray in each lane from cell to cell; `sides` decides about faces, `integral`
//!    adds what a piece shows, and `lanes` hands rays to lanes. `seams` is where parts of a mesh meet.
//! 5. `block` is a block's part of the frame, and here are the frames.

#[cfg(test)]
mod aimed;
mod block;
mod crossings;
mod integral;
mod lanes;
mod packed;
mod rays;
mod seams;
mod sides;
mod style;
mod walk;

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use fearless_simd::Level;
use rayon::prelude::*;
use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;
use tetrascope_core::{
    Appearance, DirectionalLight, Error, Frame, FrameStats, OpticalModel, Stop, TetMesh, View,
};
use tetrascope_f32::{Domain, Rays, ScalarMap};

use crate::counters::{CELL_VISITS, LOST_RAYS, PATHS, UNPAIRED_FACES};
use crate::options::RaycastCpuOptions;
use crate::segments::PathSegments;
use block::Workspace;
use crossings::Bins;
use packed::{Kind, Packed, Vertex};
use rays::{Camera, Class, MOST_SIDE};
use style::Style;

pub(crate) use block::Block;
pub(crate) use lanes::Counts;
pub(crate) use style::least_transmittance;

/// A packed mesh in a look.
#[derive(Debug)]
pub(crate) struct Caster {
    mesh: Packed,
    style: Style,
    options: RaycastCpuOptions,
    level: Level,
}

impl Caster {
    pub(crate) fn new(
        mesh: &TetMesh,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Result<Caster, Error> {
        let domain = Domain::of(mesh).within(options.domain)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        Caster::with_map(mesh, appearance, options, map)
    }

    /// The same with scalars mapped by `map`, as all parts of a mesh have to be.
    pub(crate) fn with_map(
        mesh: &TetMesh,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
        map: ScalarMap,
    ) -> Result<Caster, Error> {
        let domain = Domain::of(mesh).within(options.domain)?;
        let mesh = Packed::new(mesh, domain, map);
        Ok(Caster {
            style: Style::new(&mesh, appearance, options),
            mesh,
            options: options.clone(),
            level: Level::new(),
        })
    }

    /// Another mesh in the same look; the packed geometry is kept where it is the same.
    pub(crate) fn reloaded(&self, source: &TetMesh) -> Result<Caster, Error> {
        let appearance = &self.style.appearance;
        let domain = Domain::of(source).within(self.options.domain)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        let mesh = match source.shares_geometry(&self.mesh.source) {
            true => self.mesh.with_scalars(source, domain, map),
            false => Packed::new(source, domain, map),
        };
        Ok(Caster {
            style: Style::new(&mesh, appearance, &self.options),
            mesh,
            options: self.options.clone(),
            level: self.level,
        })
    }

    /// The same part in another look, to which its map of scalars is suited.
    pub(crate) fn restyled(&self, appearance: &Appearance) -> Caster {
        Caster {
            mesh: self.mesh.clone(),
            style: Style::new(&self.mesh, appearance, &self.options),
            options: self.options.clone(),
            level: self.level,
        }
    }

    /// Draws with other instructions than the best there are.
    #[cfg(test)]
    pub(crate) fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    pub(crate) fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let range = self.mesh.domain.scalar_range;
        if !self.mesh.scalar_map.suits_appearance(appearance, range) {
            let map = ScalarMap::of_appearance(appearance, range);
            let source = self.mesh.source.clone();
            self.mesh = self.mesh.with_scalars(&source, self.mesh.domain, map);
        }
        self.style = Style::new(&self.mesh, appearance, &self.options);
        Ok(())
    }

    /// Draws a valid view; each ray ends where `ends` says, world units, one per pixel.
    pub(crate) fn draw(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        stop: &Stop,
    ) -> Result<Frame, Error> {
        let Caster { mesh, style, .. } = self;
        let appearance = &style.appearance;
        let background = view.premultiplied_background();
        let size = [view.width as usize, view.height as usize];
        let nothing = over(appearance.optical_model, DVec3::ZERO, 0.0, background);
        let mut pixels = vec![nothing.map(|value| value as f32); size[0] * size[1]];
        let mut depths = vec![f32::INFINITY; size[0] * size[1]];
        let mut stats = FrameStats::default();
        stats.bytes_resident = mesh.bytes();
        stats.bytes_per_cell = Some(mesh.bytes() as f64 / mesh.cell_count.max(1) as f64);
        let mut counts = Counts::default();
        for block in self.blocks(view, ends, false, whole(view), stop)? {
            block.put(&block.pixels, size[0], |at, (_, pixel, depth)| {
                pixels[at] = *pixel;
                depths[at] = *depth;
            });
            counts += block.counts;
        }
        counts.tell(&mut stats);
        Ok(Frame {
            depths: Some(depths),
            ..Frame::new((view.width, view.height), pixels, stats)
        })
    }

    /// The paths of a valid view, each by itself.
    pub(crate) fn segments(&self, view: &View, stop: &Stop) -> Result<PathSegments, Error> {
        let mut segments = Vec::new();
        for block in self.paths(view, None, whole(view), stop)? {
            block.put(&block.segments, view.width as usize, |at, (_, segment)| {
                segments.push((at as u32, *segment));
            });
        }
        let model = self.style.appearance.optical_model;
        Ok(PathSegments::new(view, model, segments))
    }

    /// The paths of all rays in some rows of blocks of [`side`] pixels, block by block, row by row; nothing
    /// where nothing shows. Each ray ends where `ends` says, as in [`Caster::draw`].
    pub(crate) fn paths(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        rows: Range<usize>,
        stop: &Stop,
    ) -> Result<Vec<Block>, Error> {
        self.blocks(view, ends, true, rows, stop)
    }

    /// Casts all rays, or all their paths by themselves, in some rows of blocks.
    fn blocks(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        by_path: bool,
        rows: Range<usize>,
        stop: &Stop,
    ) -> Result<Vec<Block>, Error> {
        let Caster { mesh, style, .. } = self;
        if style.is_transparent {
            return Ok(Vec::new());
        }
        let appearance = &style.appearance;
        let normalization = mesh.places.normalization;
        let rays = Rays::new(view, &normalization);
        let bins = Bins::new(mesh, view, &rays, side(view)).ok_or_else(too_many_faces)?;
        let bounds = mesh.domain.bounds;
        let camera = Camera::new(view, rays, normalization, appearance, &bounds, ends);
        let frame = FrameScene {
            mesh,
            style,
            camera: &camera,
            turned: Default::default(),
            lights: appearance.lighting.resolved(rays.forward),
            background: view.premultiplied_background(),
            size: [view.width as usize, view.height as usize],
            by_path,
        };
        let cast = |workspace: &mut Workspace, index| {
            stop.check()?;
            Ok(Block::cast(&frame, &bins, index, self.level, workspace))
        };
        let blocks = rows.start * bins.across..rows.end * bins.across;
        let blocks = blocks.into_par_iter();
        blocks.map_init(Workspace::default, cast).collect()
    }
}

/// Pixels along each side of a block. Of the image alone: pixels do not depend on threads.
pub(crate) fn side(view: &View) -> usize {
    if view.width.max(view.height) > 256 {
        MOST_SIDE
    } else {
        MOST_SIDE / 2
    }
}

/// All rows of blocks.
fn whole(view: &View) -> Range<usize> {
    0..(view.height as usize).div_ceil(side(view))
}

fn too_many_faces() -> Error {
    Error::TooLarge {
        what: "the boundary faces of all blocks".into(),
        needed: u64::from(u32::MAX) + 1,
        limit: u64::from(u32::MAX),
        unit: "pairs of block and face",
    }
}

impl Counts {
    /// Tells a frame's statistics.
    pub(crate) fn tell(&self, stats: &mut FrameStats) {
        stats.count(CELL_VISITS, self.visits);
        stats.count(PATHS, self.paths);
        stats.count(UNPAIRED_FACES, self.unpaired);
        stats.count(LOST_RAYS, self.lost);
        if self.lost > 0 {
            stats.notes.push(format!(
                "{} rays came out of the mesh where they do not cross it",
                self.lost
            ));
        }
    }
}

/// All that the blocks of one frame share.
struct FrameScene<'a> {
    mesh: &'a Packed,
    style: &'a Style,
    camera: &'a Camera<'a>,
    /// Vertices as the rays of each class that occurs have them.
    turned: [OnceLock<Arc<[Vertex]>>; Class::COUNT],
    lights: Vec<DirectionalLight>,
    background: [f64; 4],
    size: [usize; 2],
    by_path: bool,
}

impl FrameScene<'_> {
    fn vertices(&self, class: Class) -> &[Vertex] {
        let turn = || {
            self.mesh
                .vertices
                .iter()
                .map(|v| class.vertex(*v))
                .collect()
        };
        self.turned[class.0].get_or_init(turn)
    }
}

/// Data that the rays of one class in a block are cast through.
struct Scene<'a> {
    mesh: &'a Packed,
    style: &'a Style,
    camera: &'a Camera<'a>,
    vertices: &'a [Vertex],
    class: Class,
    has_cue: bool,
    columns: [usize; 2],
    rows: [usize; 2],
    lights: &'a [DirectionalLight],
    by_path: bool,
}

impl Scene<'_> {
    /// Whether cells without thickness are seen, too: their greatest value and their surfaces.
    fn shows_layers(&self) -> bool {
        let model = self.style.appearance.optical_model;
        matches!(
            model,
            OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces
        )
    }

    /// The color that an isosurface sends to the eye from a cell with vertices `ids`, before the cue.
    fn shade(&self, surface: usize, cell: u32, ids: [u32; 4], ray: usize) -> DVec3 {
        let mesh = self.mesh;
        // As the mesh has them: f32 would tilt facets.
        let scalars = match mesh.kind {
            Kind::Corners => {
                let rank = |id| ids.iter().filter(|other| **other < id).count();
                ids.map(|id| mesh.corners[cell as usize][rank(id)].into())
            }
            Kind::Vertices => ids.map(|id| mesh.places.scalar(&mesh.source, id)),
            Kind::Cells => [0.0; 4],
        };
        let point = |i: usize| mesh.places.point(&mesh.source, ids[i]);
        let edge = |i| point(i) - point(0);
        let rise = |i: usize| scalars[i] - scalars[0];
        let [p, q, r] = [edge(1), edge(2), edge(3)];
        let gradient = rise(1) * q.cross(r) + rise(2) * r.cross(p) + rise(3) * p.cross(q);
        // Its sign is that of the cell's volume.
        let gradient = gradient * p.cross(q).dot(r).signum();
        let [column, row] = self.place(ray);
        let appearance = &self.style.appearance;
        let color = appearance.isosurfaces[surface].color;
        let direction = self.camera.direction(column, row);
        appearance
            .lighting
            .shade(self.lights, color, gradient, direction)
    }
}
