//! Texture memories become alike, once all cells are done (section 5.3, step 3).

use super::config::{MachineConfig, Merge};
use super::report::MachineReport;

/// Bytes that say where a texel is, on the bus.
const ADDRESS_BYTES: u64 = 4;

impl MachineReport {
    /// The same with texture memories made alike as `config` says, which is the machine that was
    /// simulated but for [`MachineConfig::merge`]: nothing else depends on that.
    pub fn merged(mut self, config: &MachineConfig) -> MachineReport {
        let bus = u64::from(config.triangle_bus_bytes_per_cycle);
        let host = u64::from(config.host_bytes_per_cycle);
        let (bytes, host_bytes, writes) = match config.merge {
            Merge::Broadcast => {
                // A texel goes with its address, and each other fragment generator writes it.
                let bytes = match config.fragment_generators {
                    1 => 0,
                    _ => self.texels * (self.texel_bytes + ADDRESS_BYTES),
                };
                (bytes, 0, self.texels - self.owned_texels.min)
            }
            // The host reads a texture in parts, and sends the whole of it to all.
            Merge::Readback => {
                let voxels = self.texture_bytes / self.texel_bytes;
                (self.texture_bytes, 2 * self.texture_bytes, voxels)
            }
        };
        self.buses.merge = bytes;
        self.buses.merge_host = host_bytes;
        let transfer = bytes.div_ceil(bus).max(host_bytes.div_ceil(host));
        self.merge_cycles = transfer.max(writes);
        self
    }
}
