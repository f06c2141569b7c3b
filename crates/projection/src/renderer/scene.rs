//! What `reload` and `restyle` replace, and how it is made.

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_gpu::gather::ResolvePass;
use tetrascope_gpu::preintegration::Table;
use tetrascope_gpu::{Gpu, Integration};

use super::READ_BACK_FORMAT;
use crate::centroids::Centroids;
use crate::mpvo::Mpvo;
use crate::options::{Order, ProjectionOptions};
use crate::passes::cell::{CellData, CellPass, Into, Uploaded};
use crate::passes::faces::FacePass;
use crate::passes::lists::ListPass;
use crate::passes::order::{OrderData, OrderPass};
use crate::passes::surface::{SurfaceData, SurfacePass};
use crate::passes::transform::{TransformData, TransformPass};
use crate::volume::{Field, Geometry, Look, Looked};

/// All that `reload` and `restyle` replace, at once or not at all.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) appearance: Appearance,
    pub(super) geometry: Geometry,
    pub(super) field: Field,
    pub(super) look: Look,
    pub(super) transform: TransformData,
    pub(super) sorting: Sorting,
    pub(super) surfaces: Option<SurfaceData>,
    pub(super) cell: CellData,
    /// Into the caller's format, and into the one that `render` reads back.
    pub(super) resolve: [ResolvePass; 2],
}

/// What sorts, compiled when a model first needs it.
#[derive(Debug)]
pub(super) enum Sorter {
    None,
    Centroid(OrderPass),
    CentroidOnCpu,
    Mpvo,
    PerPixel(ListPass),
}

/// What it sorts with in one scene.
#[derive(Debug)]
pub(super) enum Sorting {
    None,
    Centroid(OrderData),
    CentroidOnCpu(Centroids),
    Mpvo(Mpvo),
    PerPixel,
}

/// What a [`Scene`] is made with.
pub(super) struct Parts<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) options: &'a ProjectionOptions,
    pub(super) transform_pass: &'a TransformPass,
    pub(super) cell_pass: &'a CellPass,
    pub(super) sorter: &'a Sorter,
    pub(super) surface_pass: Option<&'a SurfacePass>,
    pub(super) face_pass: Option<&'a FacePass>,
}

impl Parts<'_> {
    pub(super) fn scene(
        &self,
        appearance: &Appearance,
        geometry: Geometry,
        field: Field,
        table: Option<&Table>,
    ) -> Result<Scene, Error> {
        let gpu = self.gpu;
        let model = appearance.optical_model;
        // Tables and surfaces want whole segments, and lists in pixels sort those.
        let in_lists = matches!(self.sorter, Sorter::PerPixel(_)) && !model.commutes();
        let pieces = self.options.integration == Integration::Exact
            && model != OpticalModel::Isosurfaces
            && appearance.depth_cue.is_none()
            && self.face_pass.is_none()
            && !in_lists;
        let on_cpu = matches!(
            self.sorter,
            Sorter::CentroidOnCpu | Sorter::Mpvo | Sorter::PerPixel(_)
        );
        let looked = Looked {
            appearance,
            integration: self.options.integration,
            table,
            pieces,
            listed: on_cpu && !model.commutes(),
        };
        let look = Look::upload(gpu, &geometry, &field, &looked)?;
        let sorting = match self.sorter {
            _ if model.commutes() => Sorting::None,
            Sorter::None => Sorting::None,
            Sorter::Centroid(pass) => {
                Sorting::Centroid(pass.data(gpu, &geometry, &field.scalars, &look)?)
            }
            Sorter::CentroidOnCpu => {
                Sorting::CentroidOnCpu(Centroids::new(&geometry, look.listed.cells.clone()))
            }
            Sorter::Mpvo => {
                let normalization = &geometry.normalization;
                Sorting::Mpvo(Mpvo::new(&geometry.mesh, normalization, &look.listed.cells))
            }
            Sorter::PerPixel(_) => Sorting::PerPixel,
        };
        let transform = self.transform_pass.data(gpu, &geometry, &field)?;
        let drawn = match &sorting {
            Sorting::Centroid(data) => data.sorted(),
            _ => &look.culled.drawn,
        };
        let surfaces = match model {
            OpticalModel::Isosurfaces => {
                let (map, range) = (&field.map, field.range);
                let search = self.options.surfaces;
                Some(SurfaceData::new(gpu, appearance, map, range, search)?)
            }
            _ => None,
        };
        let into = match (&sorting, self.sorter) {
            (Sorting::PerPixel, Sorter::PerPixel(pass)) => Into::Lists(pass),
            _ => Into::Sum,
        };
        let into = match (self.surface_pass, &surfaces) {
            (Some(pass), Some(data)) => Into::Nearest(pass, data),
            _ => self.face_pass.map_or(into, Into::Faces),
        };
        let uploaded = Uploaded {
            geometry: &geometry,
            field: &field,
            look: &look,
        };
        let cell = self.cell_pass.data(gpu, uploaded, drawn, model, into)?;
        let format = self.options.target_format;
        let resolve = ResolvePass::new(gpu, model, format)?;
        let resolve_read_back = if format == READ_BACK_FORMAT {
            resolve.clone()
        } else {
            ResolvePass::new(gpu, model, READ_BACK_FORMAT)?
        };
        Ok(Scene {
            appearance: appearance.clone(),
            geometry,
            field,
            look,
            transform,
            sorting,
            surfaces,
            cell,
            resolve: [resolve, resolve_read_back],
        })
    }
}

impl Sorter {
    /// Compiles what `model` needs and is not there yet.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        options: &ProjectionOptions,
        cell_pass: &CellPass,
        model: OpticalModel,
    ) -> Result<(), Error> {
        if matches!(self, Sorter::None) && !model.commutes() {
            *self = match options.order {
                Order::Unsorted => Sorter::None,
                Order::Centroid if options.sort.is_on_cpu(gpu) => Sorter::CentroidOnCpu,
                Order::Centroid => Sorter::Centroid(OrderPass::new(gpu)?),
                Order::Mpvo => Sorter::Mpvo,
                Order::PerPixel => Sorter::PerPixel(ListPass::new(gpu, cell_pass)?),
            };
        }
        Ok(())
    }
}
