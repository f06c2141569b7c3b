//! How long a frame takes on the device.

use std::time::Duration;

use tetrascope_core::Error;
use wgpu::{BufferUsages, Features};

use crate::Gpu;
use crate::memory::{ReadBack, Source, read_back};

/// The time from the start of a frame's commands to their end.
#[derive(Debug)]
pub struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Timer {
    /// A timer, or `None` where the device has no timestamps, or none to rely on: see
    /// [`seconds`].
    pub fn new(gpu: &Gpu) -> Result<Option<Timer>, Error> {
        if gpu.is_software() || !gpu.features().contains(Features::TIMESTAMP_QUERY) {
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

    /// Records when the frame begins.
    pub fn begin(&self, encoder: &mut wgpu::CommandEncoder) {
        self.write(encoder, Some(0), None);
    }

    /// Records when the frame ends.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        self.write(encoder, None, Some(1));
    }

    /// In an empty pass: WebGPU has no timestamps but those of passes.
    fn write(&self, encoder: &mut wgpu::CommandEncoder, begin: Option<u32>, end: Option<u32>) {
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gpu::timer"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: begin,
                end_of_pass_write_index: end,
            }),
        });
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

/// The seconds that a frame took on the device, whose commands were submitted and done
/// within `wall` of the wall clock.
///
/// A software adapter computes on the CPU, so its time is that of the wall clock. It may
/// have timestamps, but llvmpipe (Mesa 22.3) takes that of a compute pass's beginning when
/// its work is done, once anything was drawn on the device. Elsewhere it is the time between
/// the timer's two, if they were read; `None` if that clock went backward, stood still, or
/// counted more than has passed.
pub fn seconds(gpu: &Gpu, times: Option<ReadBack>, wall: Duration) -> Result<Option<f64>, Error> {
    if gpu.is_software() {
        return Ok(Some(wall.as_secs_f64()));
    }
    let times: Vec<u64> = times.map(ReadBack::read).transpose()?.unwrap_or_default();
    let nanoseconds = f64::from(gpu.queue().get_timestamp_period());
    Ok(between(&times, nanoseconds).filter(|seconds| *seconds <= wall.as_secs_f64()))
}

/// The seconds between two times in ticks of so many nanoseconds.
fn between(times: &[u64], nanoseconds: f64) -> Option<f64> {
    let ticks = match *times {
        [start, end] => end.checked_sub(start).filter(|t| *t > 0),
        _ => None,
    };
    ticks.map(|t| t as f64 * nanoseconds / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn a_clock_that_stands_still_says_nothing() {
        assert_eq!(between(&[7, 9], 1000.0), Some(2e-6));
        assert_eq!(between(&[9, 7], 1000.0), None);
        assert_eq!(between(&[7, 7], 1000.0), None);
        assert_eq!(between(&[], 1000.0), None);
    }

    /// Whatever a device's clock says of this, it is no longer than the wall clock says, and on
    /// software it is as long.
    #[test]
    fn no_time_contradicts_the_wall_clock() {
        let Some(gpu) = testing::gpu("no_time_contradicts_the_wall_clock") else {
            return;
        };
        let timer = Timer::new(&gpu).expect("made");
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        if let Some(timer) = &timer {
            timer.begin(&mut encoder);
            timer.end(&mut encoder);
        }
        let times = timer.as_ref().map(|t| t.resolve(&gpu, &mut encoder));
        let times = times.transpose().expect("recorded");
        gpu.finish(encoder).expect("done");
        let wall = Duration::from_nanos(1);
        let said = seconds(&gpu, times, wall).expect("read");
        assert_eq!(said.is_some(), gpu.is_software());
        assert!(said.is_none_or(|seconds| seconds == wall.as_secs_f64()));
    }
}
