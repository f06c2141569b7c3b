//! Slices of a mesh, drawn as they come: no grid between the mesh and the picture (section 3.2).
//!
//! Planes that face the camera cut the mesh as far apart as [`MeshSlicesOptions::planes`] says. The
//! cross sections of cells with one plane do not overlap, so that cells need no order; planes are
//! drawn from back to front.
//!
//! 1. `view_elements.wgsl` makes the triangles of every cell as the camera sees it, once in a view.
//! 2. [`slabs`](crate::slabs) lists the cells that a slab of planes meets.
//! 3. `mesh_slice.wgsl` draws their cross sections plane by plane, and blends what each adds.
//!
//! # Departures from the paper
//! - *Slices are blended into the picture as they are drawn*. The paper draws each into a buffer
//!   of its own first, as its two passes leave scalars there that are to be colored.
//! - *Perspective* ([`Evaluation::PerFragment`], the default). The paper excludes it, as weights from
//!   textures are wrong where lengths are distorted. Here a fragment divides what is interpolated by
//!   1 / depth, so that it knows where its own ray meets both faces, and interpolates between them.
//! - *Opacities of lengths along rays*, 1 − exp(−τ), where the paper has colors of slices.
//! - *Post-shading* is a lookup in each fragment, not one of whole slices.
//! - What rasterizers round is taken back, see `mesh_slice.wgsl`.
//!
//! # Limits
//! - What lies between two planes is not seen, nor where in between a mesh ends: the error falls with
//!   the distance of planes, to a fourth with four times as many. With 256 it is some 0.003 of
//!   white, on average, where a mesh begins abruptly.
//! - The eye must be outside of the box around the mesh, in front of all of it.
//! - No isosurfaces: a surface lies between planes.

mod frame;
mod options;
mod scene;
#[cfg(test)]
mod tests;

use tetrascope_core::{
    Abilities, Appearance, Error, Frame, FrameStats, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{Domain, ImagePlane, Normalization, ScalarMap};
use tetrascope_gpu::gather::gathered_format;
use tetrascope_gpu::passes::group;
use tetrascope_gpu::transfer_function::check_knots;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Canvas, Commands, Draw, Gpu, Recorded, SumsKind, Target, draw};

use self::frame::{depths, frame};
pub(crate) use self::options::{EVALUATIONS, MOST_PLANES};
pub use self::options::{Evaluation, MeshSlicesOptions, Shading};
use self::scene::{Mesh, Programs, Style};
use crate::NAME;
use crate::slabs::{Drawn, Slabs, compute};

const LABEL: &str = "resample::mesh slices";

/// Draws a mesh slice by slice, in every optical model but isosurfaces.
///
/// Planes face the camera; what lies between two of them is not seen, so the error falls with their
/// number. The eye must be outside of the box around the mesh, in front of all of it.
#[derive(Debug)]
pub struct MeshSlices {
    canvas: Canvas,
    options: MeshSlicesOptions,
    slabs: Slabs,
    programs: Programs,
    mesh: Mesh,
    style: Style,
}

impl MeshSlices {
    /// The parts of an appearance that are drawn.
    pub const ABILITIES: Abilities = Abilities {
        isosurfaces: false,
        ..Abilities::ALL
    };

    /// Uploads the mesh in `volume` and compiles what `appearance` needs.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a grid and for isosurfaces; options out of range; a mesh that the
    /// device does not hold.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &MeshSlicesOptions,
    ) -> Result<MeshSlices, Error> {
        let mesh = mesh_of(volume)?;
        MeshSlices::ABILITIES.check(NAME, appearance, &volume.bounds())?;
        options.validate()?;
        let slabs = Slabs::new(gpu, options.slabs, options.planes)?;
        let programs = Programs::new(gpu, options, &slabs)?;
        let placed = placed(mesh, appearance, options)?;
        let mesh = Mesh::new(gpu, &programs, &slabs, mesh, placed, None)?;
        let style = Style::new(gpu, &programs, &mesh, appearance)?;
        Ok(MeshSlices {
            canvas: Canvas::new(gpu)?,
            options: *options,
            slabs,
            programs,
            mesh,
            style,
        })
    }

    fn replace(&mut self, mesh: &TetMesh, appearance: &Appearance) -> Result<(), Error> {
        let placed = placed(mesh, appearance, &self.options)?;
        let gpu = self.canvas.gpu();
        let (programs, slabs) = (&self.programs, &self.slabs);
        let mesh = Mesh::new(gpu, programs, slabs, mesh, placed, Some(&self.mesh))?;
        let style = Style::new(gpu, programs, &mesh, appearance)?;
        (self.mesh, self.style) = (mesh, style);
        Ok(())
    }

    /// How much was drawn in the last frame, once its commands have run.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn drawn(&self) -> Result<Drawn, Error> {
        self.slabs.drawn(self.canvas.gpu(), 1)
    }

    /// Whether such a frame is drawn, as far as that can be said without a device.
    ///
    /// # Errors
    /// Why not.
    pub fn supports(
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
        options: &MeshSlicesOptions,
    ) -> Result<(), Error> {
        let mesh = mesh_of(volume)?;
        MeshSlices::ABILITIES.check(NAME, appearance, &volume.bounds())?;
        check_knots(&appearance.transfer_function)?;
        options.validate()?;
        view.validate()?;
        let domain = Domain::of(mesh).within(options.domain)?;
        let plane = ImagePlane::new(view, &Normalization::of(&domain.bounds));
        options.check_plane(&plane)?;
        depths(&plane, &mesh.bounds(), &Normalization::of(&domain.bounds)).map(drop)
    }

    fn format(&self) -> TextureFormat {
        gathered_format(self.canvas.gpu(), self.style.appearance.optical_model)
    }

    fn stats(&self) -> FrameStats {
        let mut stats = FrameStats::default();
        stats.bytes_resident = self.mesh.bytes() + self.style.bytes();
        stats.order_proven = Some(true);
        if matches!(
            self.format(),
            TextureFormat::R16Float | TextureFormat::Rgba16Float
        ) {
            let note = "this device does not blend f32, so slices add up in f16";
            stats.notes.push(note.into());
        }
        stats
    }

    fn draw_slabs(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::BindGroup,
        pipeline: &wgpu::RenderPipeline,
        sums: &wgpu::TextureView,
    ) {
        let mesh = &self.mesh;
        let volume = &self.style.volume;
        self.slabs.clear(encoder);
        let elements = &self.programs.elements[usize::from(mesh.cell_data)];
        let made = [frame, volume, &mesh.made];
        compute(encoder, mesh.cell_count, elements, &made);
        for slab in (0..self.slabs.count()).rev() {
            self.slabs
                .list(encoder, &mesh.elements, mesh.cell_count, slab);
            let is_first = slab + 1 == self.slabs.count();
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(LABEL),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: sums,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: match is_first {
                            true => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                            false => wgpu::LoadOp::Load,
                        },
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, frame, &[]);
            pass.set_bind_group(1, volume, &[]);
            pass.set_bind_group(2, &mesh.drawn, &[]);
            for plane in self.slabs.slices(slab).rev() {
                pass.set_bind_group(3, self.slabs.slice(plane), &[]);
                self.slabs.draw(&mut pass, slab);
            }
        }
    }
}

/// The domain of `mesh`, and how its scalars become those of the device.
fn placed(
    mesh: &TetMesh,
    appearance: &Appearance,
    options: &MeshSlicesOptions,
) -> Result<(Domain, ScalarMap), Error> {
    let domain = Domain::of(mesh).within(options.domain)?;
    Ok((domain, ScalarMap::of(&appearance.transfer_function)))
}

/// The mesh of `volume`, or why there is none.
fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        Volume::Clusters(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes in clusters".into(),
            reason: "it needs all cells at once".into(),
        }),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it cuts the cells of a tetrahedral mesh".into(),
        }),
    }
}

impl VolumeRenderer for MeshSlices {
    /// Uploads another mesh, whatever it has in common with the one before.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let appearance = self.style.appearance.clone();
        let mesh = mesh_of(volume)?;
        MeshSlices::ABILITIES.check(NAME, &appearance, &volume.bounds())?;
        self.replace(mesh, &appearance)
    }

    /// Uploads the transfer function; scalars only if its range moved so far that f32 would run out
    /// of digits.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        MeshSlices::ABILITIES.check(NAME, appearance, &self.mesh.mesh.bounds())?;
        let gpu = self.canvas.gpu();
        if self.mesh.map.suits(&appearance.transfer_function) {
            self.style = Style::new(gpu, &self.programs, &self.mesh, appearance)?;
            return Ok(());
        }
        self.replace(&self.mesh.mesh.clone(), appearance)
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for MeshSlices {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        let (gpu, encoder) = (self.canvas.gpu(), commands.encoder());
        if self.mesh.cell_count == 0 || self.style.is_transparent {
            let mut stats = self.stats();
            stats.passes = self.canvas.put_nothing(encoder, view, target)?;
            return Ok(Recorded::new(stats));
        }
        let Mesh {
            normalization,
            domain,
            ..
        } = &self.mesh;
        let appearance = &self.style.appearance;
        let plane = ImagePlane::new(view, normalization);
        self.options.check_plane(&plane)?;
        let uniform = frame(view, &plane, &self.mesh, self.options.planes)?;
        let space = plane.camera_from_normalized();
        let map = &self.mesh.map;
        let (look, _) = look(appearance, view, &domain.bounds, normalization, map, &space);
        let depth = target.depth.as_ref();
        let (ends, has_ends) =
            self.canvas
                .ends(encoder, view, normalization, plane.anchor_depth, depth)?;
        let usage = BufferUsages::UNIFORM;
        let uniform = gpu.upload(LABEL, &[uniform], usage)?;
        let look = gpu.upload(LABEL, bytemuck::bytes_of(&look), usage)?;
        let pipeline = self.style.pipeline(gpu, has_ends)?;
        let model = appearance.optical_model;
        let kind = SumsKind {
            format: self.format(),
            usage: TextureUsages::RENDER_ATTACHMENT,
            distances: false,
        };
        let sums = self.canvas.sums(view, kind)?;
        gpu.checked(LABEL, 0, || {
            let resources = [
                uniform.as_entire_binding(),
                look.as_entire_binding(),
                wgpu::BindingResource::TextureView(&ends),
            ];
            let frame = group(gpu, LABEL, &self.programs.frame_layout, &resources);
            let color = sums.color.create_view(&Default::default());
            self.draw_slabs(encoder, &frame, &pipeline, &color);
        })?;
        self.canvas
            .put(encoder, view, normalization, (model, &sums), target)?;
        let mut stats = self.stats();
        // The triangles, a list and a draw of each slab, and the last.
        stats.passes = 2 + 2 * self.slabs.count() as u64;
        Ok(Recorded::new(stats))
    }
}
