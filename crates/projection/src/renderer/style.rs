//! The parts of the renderer that `reload` and `restyle` replace, and how they are made.

use std::sync::OnceLock;

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_gpu::{Gpu, Integration};

use crate::centroids::Centroids;
use crate::classified::{Classification, Classified};
use crate::mesh::{Field, Geometry};
use crate::mpvo::{Mpvo, Shape, unproven};
use crate::options::{ExitSearch, Order, ProjectionOptions};
use crate::passes::cell::{CellData, CellPass, Uploaded};
use crate::passes::faces::FacePass;
use crate::passes::lists::ListPass;
use crate::passes::order::{OrderData, OrderPass};
use crate::passes::surface::{SurfaceData, SurfacePass};
use crate::passes::transform::{TransformData, TransformPass};

/// All that `reload` and `restyle` replace, at once or not at all.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    pub(super) geometry: Geometry,
    pub(super) field: Field,
    pub(super) classified: Classified,
    pub(super) transform: TransformData,
    pub(super) sorting: Sorting,
    /// Why an order by faces may be wrong whatever the view, where one is asked for.
    pub(super) unproven: Option<String>,
    pub(super) surfaces: Option<SurfaceData>,
    pub(super) cell: CellData,
    /// For lists in pixels, where `sorting` is another that was not right in some view.
    pub(super) whole_cells: OnceLock<CellData>,
}

/// How cells are ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    None,
    Centroid,
    CentroidOnCpu,
    Mpvo,
    PerPixel,
}

/// The programs that sort, compiled when first needed.
#[derive(Debug, Default)]
pub(super) struct Sorter {
    order: Option<OrderPass>,
    lists: OnceLock<ListPass>,
}

/// The data to sort with in one style.
#[derive(Debug)]
pub(super) enum Sorting {
    None,
    Centroid(OrderData),
    CentroidOnCpu(Centroids),
    Mpvo(Mpvo),
    PerPixel,
}

/// Inputs of a [`Style`].
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
    pub(super) fn style(
        &self,
        appearance: &Appearance,
        geometry: Geometry,
        field: Field,
        last: Option<&Classified>,
    ) -> Result<Style, Error> {
        let gpu = self.gpu;
        let model = appearance.optical_model;
        // Tables and surfaces want whole segments, and lists in pixels sort those.
        let unproven = doubt(self.options, model, &geometry);
        let way = Way::of(gpu, self.options, model, unproven.is_none());
        let in_lists = way == Way::PerPixel;
        let pieces = self.options.integration == Integration::Exact
            && model != OpticalModel::Isosurfaces
            && appearance.depth_cue.is_none()
            && self.face_pass.is_none()
            && !in_lists;
        let classification = Classification {
            appearance,
            integration: self.options.integration,
            last,
            pieces,
            listed: !matches!(way, Way::None | Way::Centroid),
            extrapolates: self.face_pass.is_some(),
        };
        let classified = Classified::upload(gpu, &geometry, &field, &classification)?;
        let sorting = match way {
            Way::None => Sorting::None,
            Way::Centroid => {
                let pass = self.sorter.order.as_ref().expect("prepared for the style");
                Sorting::Centroid(pass.data(gpu, &geometry, &field.scalars, &classified)?)
            }
            Way::CentroidOnCpu => {
                Sorting::CentroidOnCpu(Centroids::new(&geometry, classified.listed.cells.clone()))
            }
            Way::Mpvo => {
                let (mesh, normalization) = (&geometry.mesh, &geometry.normalization);
                let made = || Shape::new(mesh, normalization).into();
                let shape = geometry.shape.get_or_init(made).clone();
                Sorting::Mpvo(Mpvo::new(mesh, shape, &classified.listed.cells))
            }
            Way::PerPixel => Sorting::PerPixel,
        };
        let transform = self.transform_pass.data(gpu, &geometry, &field)?;
        let drawn = match &sorting {
            Sorting::Centroid(data) => data.sorted(),
            _ => &classified.culled.drawn,
        };
        let surfaces = match model {
            OpticalModel::Isosurfaces => {
                let (map, range) = (&field.map, field.range);
                let search = self.options.surfaces;
                Some(SurfaceData::new(gpu, appearance, map, range, search)?)
            }
            _ => None,
        };
        let uploaded = Uploaded {
            geometry: &geometry,
            field: &field,
            classified: &classified,
        };
        let cells = self.cell_pass;
        let program = match (self.surface_pass, &surfaces, self.face_pass) {
            (Some(pass), Some(data), _) => (pass.program(gpu, cells, uploaded, data)?, None),
            (.., Some(pass)) => {
                let (program, group) = pass.program(gpu, cells, uploaded, model)?;
                (program, Some(group))
            }
            (.., None) if way == Way::PerPixel => {
                let lists = self.sorter.lists(gpu, cells)?;
                (lists.program(gpu, cells, uploaded, model)?, None)
            }
            (.., None) => (cells.program(gpu, uploaded, model)?, None),
        };
        let cell = cells.data(gpu, uploaded, drawn, program)?;
        Ok(Style {
            appearance: appearance.clone(),
            geometry,
            field,
            classified,
            transform,
            sorting,
            unproven,
            surfaces,
            cell,
            whole_cells: OnceLock::new(),
        })
    }
}

impl Style {
    /// The data that draw whole cells into lists, made when a view first needs them. Submits nothing.
    pub(super) fn whole_cells(&self, parts: &Parts) -> Result<&CellData, Error> {
        if self.sorting.is_per_pixel() {
            return Ok(&self.cell);
        }
        if self.whole_cells.get().is_none() {
            let classified = self.classified.whole(parts.gpu)?;
            let uploaded = Uploaded {
                geometry: &self.geometry,
                field: &self.field,
                classified: &classified,
            };
            let (gpu, pass) = (parts.gpu, parts.cell_pass);
            let lists = parts.sorter.lists(gpu, pass)?;
            let model = self.appearance.optical_model;
            let program = lists.program(gpu, pass, uploaded, model)?;
            let cells = pass.data(gpu, uploaded, &classified.culled.drawn, (program, None))?;
            // Another thread may have been first.
            let _ = self.whole_cells.set(cells);
        }
        Ok(self.whole_cells.get().expect("just set"))
    }
}

/// Why an order by faces may be wrong, where one is asked for.
fn doubt(options: &ProjectionOptions, model: OpticalModel, geometry: &Geometry) -> Option<String> {
    let asked = matches!(options.order, Order::Auto | Order::Mpvo) && !model.commutes();
    // A convex mesh is looked at face by face.
    let found = || unproven(&geometry.mesh);
    asked
        .then(|| geometry.unproven.get_or_init(found).clone())
        .flatten()
}

impl Sorting {
    pub(super) fn is_per_pixel(&self) -> bool {
        matches!(self, Sorting::PerPixel)
    }
}

impl Way {
    fn of(gpu: &Gpu, options: &ProjectionOptions, model: OpticalModel, proven: bool) -> Way {
        match options.order {
            _ if model.commutes() => Way::None,
            Order::Unsorted => Way::None,
            Order::Centroid if options.sort.is_on_cpu(gpu) => Way::CentroidOnCpu,
            Order::Centroid => Way::Centroid,
            Order::Mpvo => Way::Mpvo,
            Order::PerPixel => Way::PerPixel,
            Order::Auto if options.exit_search != ExitSearch::PerFragment => Way::Mpvo,
            Order::Auto if proven => Way::Mpvo,
            Order::Auto => Way::PerPixel,
        }
    }
}

impl Sorter {
    /// Compiles what a style needs and is not there yet.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        options: &ProjectionOptions,
        cell_pass: &CellPass,
        model: OpticalModel,
        geometry: &Geometry,
    ) -> Result<(), Error> {
        let proven = doubt(options, model, geometry).is_none();
        match Way::of(gpu, options, model, proven) {
            Way::Centroid if self.order.is_none() => self.order = Some(OrderPass::new(gpu)?),
            Way::PerPixel => _ = self.lists(gpu, cell_pass)?,
            _ => {}
        }
        Ok(())
    }

    /// The passes of lists in pixels, compiled when first asked for.
    pub(super) fn lists(&self, gpu: &Gpu, cell_pass: &CellPass) -> Result<&ListPass, Error> {
        if self.lists.get().is_none() {
            // Another thread may have been first.
            let _ = self.lists.set(ListPass::new(gpu, cell_pass)?);
        }
        Ok(self.lists.get().expect("just set"))
    }

    /// The pass that sorts by centroids.
    pub(super) fn order(&self) -> Option<&OrderPass> {
        self.order.as_ref()
    }
}
