//! How long a frame takes on the device.

use tetrascope_core::Error;
use wgpu::{BufferUsages, Features};

use crate::Gpu;
use crate::memory::{ReadBack, Source, read_back};

/// The time from the start of a frame's first pass to the end of its last one.
#[derive(Debug)]
pub struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Timer {
    /// A timer, or `None` where the device has no timestamps.
    pub fn new(gpu: &Gpu) -> Result<Option<Timer>, Error> {
        if !gpu.features().contains(Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let resolved = gpu.buffer("gpu::timer", 16, usage)?;
        let queries = gpu.checked("gpu::timer", 16, || {
            gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("gpu::timer"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            })
        })?;
        Ok(Some(Timer { queries, resolved }))
    }

    /// What the frame's first pass writes, if it is a compute pass.
    pub fn first_compute_pass(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: None,
        }
    }

    /// What a frame's one pass writes, if it is a compute pass.
    pub fn only_compute_pass(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// What the frame's first pass writes, if it is a render pass.
    pub fn first_render_pass(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: None,
        }
    }

    /// What the frame's last pass, a render pass, writes.
    pub fn last_render_pass(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: None,
            end_of_pass_write_index: Some(1),
        }
    }

    /// Records the copy of the times to where [`seconds`] reads them.
    pub fn resolve(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<ReadBack, Error> {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        read_back(gpu, encoder, Source::Buffer(&self.resolved, 16))
    }
}

/// The seconds between the two times, once their commands were submitted.
///
/// `None` if the device's clock went backward or stood still.
pub fn seconds(gpu: &Gpu, times: ReadBack) -> Result<Option<f64>, Error> {
    let times: Vec<u64> = times.read()?;
    let ticks = match times[..] {
        [start, end] => end.checked_sub(start).filter(|t| *t > 0),
        _ => None,
    };
    let nanoseconds = f64::from(gpu.queue().get_timestamp_period());
    Ok(ticks.map(|t| t as f64 * nanoseconds * 1e-9))
}
