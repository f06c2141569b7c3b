//! The part of a renderer that does not depend on the appearance: the samples and what is known of them.

use std::sync::Arc;

use tetrascope_core::grid::coverage::fades;
use tetrascope_core::grid::{BrickSource, Interpolation, Lattice};
use tetrascope_core::{Bounds, Error, Grid, OpticalModel, Volume};
use tetrascope_f32::{Domain, Normalization};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::{DeviceGrid, Gpu, wgpu};

use crate::NAME;
use crate::boxes::Boxes;
use crate::cells::between_samples;
use crate::octree::Octree;
use crate::options::SlicingOptions;
use crate::ranges::DeviceRanges;

/// The part that does not depend on the appearance.
#[derive(Debug)]
pub(crate) struct Samples {
    pub(crate) content: Content,
    pub(crate) lattice: Lattice,
    /// Whether each sample is that of a whole cell.
    pub(crate) fills_cells: bool,
    pub(crate) domain: Domain,
    pub(crate) normalization: Normalization,
    pub(crate) boxes: Boxes,
    /// Samples around each box that its range includes.
    pub(crate) reach: usize,
}

/// Where samples are, and the ranges of boxes of them.
#[derive(Debug)]
pub(crate) enum Content {
    /// In memory or in a file.
    Source {
        source: Arc<dyn BrickSource>,
        octree: Octree,
    },
    /// On the device, and nowhere else.
    Device {
        grid: Box<DeviceGrid>,
        ranges: DeviceRanges,
    },
}

impl Samples {
    /// Those of a volume; a grid with coverage is uploaded.
    pub(crate) fn of(
        gpu: &Gpu,
        volume: &Volume,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Samples, Error> {
        match volume {
            Volume::Grid(grid) if grid.coverage().is_some() => {
                let grid = upload(gpu, grid, options)?;
                Samples::on_device(gpu, grid, reach, options)
            }
            _ => Samples::from_source(source_of(volume)?, reach, options),
        }
    }

    /// Reads all samples once, for the ranges of boxes.
    pub(crate) fn from_source(
        source: Arc<dyn BrickSource>,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Samples, Error> {
        if source.has_coverage() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "a source with coverage".into(),
                reason: "coverage is not read in parts; give it as `Volume::Grid`".into(),
            });
        }
        let fills_cells = source.lattice().interpolation == Interpolation::Nearest;
        let source = between_samples(source);
        let octree = Octree::build(&*source, reach)?;
        let [low, high] = octree.range(0, [0; 3]).map(f64::from);
        let range = (low <= high && (high - low).is_finite()).then_some((low, high));
        let lattice = source.lattice();
        let content = Content::Source { source, octree };
        Samples::new(content, lattice, fills_cells, range, reach, options)
    }

    /// Those of a grid on the device, whose ranges are yet to be found ([`Samples::find`]).
    pub(crate) fn on_device(
        gpu: &Gpu,
        grid: DeviceGrid,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Samples, Error> {
        options.check_device_grid(grid.lattice())?;
        let lattice = *grid.lattice();
        let ranges = DeviceRanges::new(gpu, &grid, &Boxes::new(lattice.cells()), reach)?;
        let range = grid.scalar_range();
        let content = Content::Device {
            grid: Box::new(grid),
            ranges,
        };
        Samples::new(content, lattice, false, range, reach, options)
    }

    /// Submits what `make` records to write the samples, and what finds the ranges of boxes in
    /// them, if they are on the device; waits for nothing.
    pub(crate) fn find(
        &self,
        gpu: &Gpu,
        make: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let Content::Device { ranges, .. } = &self.content else {
            return Ok(());
        };
        gpu.checked("slicing::ranges", 0, || {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            make(&mut encoder);
            ranges.record(&mut encoder);
            gpu.queue().submit([encoder.finish()]);
        })
    }

    /// Whether these are those of `grid` but for what its texture holds by now.
    ///
    /// # Errors
    /// A grid outside of the domain that was given.
    pub(crate) fn suits(&self, grid: &DeviceGrid, options: &SlicingOptions) -> Result<bool, Error> {
        let domain = domain(grid.lattice(), grid.scalar_range(), options)?;
        Ok(self.device_grid().is_some_and(|before| {
            let is_alike = before.texture() == grid.texture() && before.texels() == grid.texels();
            is_alike && before.lattice() == grid.lattice() && domain == self.domain
        }))
    }

    fn new(
        content: Content,
        lattice: Lattice,
        fills_cells: bool,
        scalar_range: Option<(f64, f64)>,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Samples, Error> {
        let domain = domain(&lattice, scalar_range, options)?;
        Ok(Samples {
            normalization: Normalization::of(&domain.bounds),
            domain,
            boxes: Boxes::new(lattice.cells()),
            lattice,
            fills_cells,
            content,
            reach,
        })
    }

    /// The same samples, with ranges that reach farther.
    pub(crate) fn reaching(
        &self,
        gpu: &Gpu,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Samples, Error> {
        match &self.content {
            Content::Device { grid, .. } => {
                Samples::on_device(gpu, DeviceGrid::clone(grid), reach, options)
            }
            Content::Source { source, octree } => Ok(Samples {
                content: Content::Source {
                    source: source.clone(),
                    octree: Octree::build(&**source, reach)?,
                },
                domain: self.domain,
                reach,
                boxes: octree.boxes,
                ..*self
            }),
        }
    }

    /// The box around all cells, world space.
    pub(crate) fn bounds(&self) -> Bounds {
        self.lattice.bounds()
    }

    /// Whether there may be samples without a value for `model`, whose cells are gaps.
    pub(crate) fn has_gaps(&self, model: OpticalModel) -> bool {
        match &self.content {
            Content::Source { octree, .. } => octree.gaps,
            Content::Device { grid, .. } => match grid.texels() {
                Texels::Values => false,
                Texels::Gaps => true,
                Texels::Covered => !fades(model),
            },
        }
    }

    /// Bytes of what is known of the samples on the device.
    pub(crate) fn range_bytes(&self) -> u64 {
        match &self.content {
            Content::Source { .. } => 0,
            Content::Device { ranges, .. } => ranges.buffer.size(),
        }
    }

    /// The grid, if it is on the device.
    pub(crate) fn device_grid(&self) -> Option<&DeviceGrid> {
        match &self.content {
            Content::Source { .. } => None,
            Content::Device { grid, .. } => Some(grid),
        }
    }

    /// The source that is read brick by brick, with its octree, unless it is on the device.
    pub(crate) fn source(&self) -> Option<(&Arc<dyn BrickSource>, &Octree)> {
        match &self.content {
            Content::Source { source, octree } => Some((source, octree)),
            Content::Device { .. } => None,
        }
    }
}

/// The domain of samples with this range.
fn domain(
    lattice: &Lattice,
    scalar_range: Option<(f64, f64)>,
    options: &SlicingOptions,
) -> Result<Domain, Error> {
    let own = Domain {
        bounds: lattice.bounds(),
        scalar_range,
    };
    own.within(options.domain)
}

/// The grid of `volume`, or why there is none.
pub(crate) fn source_of(volume: &Volume) -> Result<Arc<dyn BrickSource>, Error> {
    match volume {
        Volume::Grid(grid) => Ok(Arc::new(grid.clone())),
        Volume::Stream(stream) => Ok(stream.source().clone()),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes".into(),
            reason: "it slices regular grids".into(),
        }),
    }
}

/// A grid with coverage on the device, if the budget has room for it.
fn upload(gpu: &Gpu, grid: &Grid, options: &SlicingOptions) -> Result<DeviceGrid, Error> {
    // Refused before the work.
    options.check_device_grid(grid.lattice())?;
    let texel = u64::from(Texels::Covered.format().block_copy_size(None).unwrap_or(8));
    let needed = (grid.samples().len() as u64).saturating_mul(texel);
    if needed > options.memory_budget {
        return Err(Error::TooLarge {
            what: "a grid with coverage, which is not streamed,".into(),
            needed,
            limit: options.memory_budget,
            unit: "bytes",
        });
    }
    DeviceGrid::upload(gpu, grid)
}
