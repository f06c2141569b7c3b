//! How many fragments a frame has, where the device counts them.

use tetrascope_core::Error;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::memory::{ReadBack, Source, read_back};
use tetrascope_gpu::wgpu::{
    self, BufferUsages, Features, PipelineStatisticsTypes, QUERY_SET_MAX_QUERIES, QueryType,
};

/// Invocations of the fragment program, one query a draw.
#[derive(Debug)]
pub(crate) struct FragmentCounter {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    draws: u32,
}

impl FragmentCounter {
    /// A counter for this many draws, or `None` where the device does not count so many.
    pub(crate) fn new(gpu: &Gpu, draws: usize) -> Result<Option<FragmentCounter>, Error> {
        let counts = gpu.features().contains(Features::PIPELINE_STATISTICS_QUERY);
        let draws = u32::try_from(draws).unwrap_or(u32::MAX);
        if !counts || draws == 0 || draws > QUERY_SET_MAX_QUERIES {
            return Ok(None);
        }
        let label = "slicing::count";
        let bytes = 8 * u64::from(draws);
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let resolved = gpu.buffer(label, bytes, usage)?;
        let fragments = PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS;
        let queries = gpu.checked(label, bytes, || {
            gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(label),
                ty: QueryType::PipelineStatistics(fragments),
                count: draws,
            })
        })?;
        Ok(Some(FragmentCounter {
            queries,
            resolved,
            draws,
        }))
    }

    /// Counts what `draw`, number `index` of the frame, records into `pass`.
    pub(crate) fn count<'a>(
        &self,
        pass: &mut wgpu::RenderPass<'a>,
        index: u32,
        draw: impl FnOnce(&mut wgpu::RenderPass<'a>),
    ) {
        pass.begin_pipeline_statistics_query(&self.queries, index);
        draw(pass);
        pass.end_pipeline_statistics_query();
    }

    /// Records the copy of the counts to where [`total`] reads them.
    pub(crate) fn resolve(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<ReadBack, Error> {
        encoder.resolve_query_set(&self.queries, 0..self.draws, &self.resolved, 0);
        let bytes = 8 * u64::from(self.draws);
        read_back(gpu, encoder, Source::Buffer(&self.resolved, bytes))
    }
}

/// The sum over all draws, once their commands were submitted.
pub(crate) fn total(counts: ReadBack) -> Result<u64, Error> {
    Ok(counts.read::<u64>()?.into_iter().sum())
}
