//! What can be chosen.

pub use crate::layout::Locality;

/// How rays are cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaycastOptions {
    /// The opacity at which a ray stops, in (0, 1]: what lies behind then adds less
    /// than 1 − this of its light. 1 is exact; the paper stops at 0.95.
    pub stop_opacity: f32,
    /// In which order the mesh lies in memory.
    pub locality: Locality,
}

impl Default for RaycastOptions {
    fn default() -> RaycastOptions {
        RaycastOptions {
            stop_opacity: 1.0,
            locality: Locality::Morton,
        }
    }
}

impl RaycastOptions {
    /// The optical depth beyond which a ray stops.
    ///
    /// At 100 transmittance is 4e-44, which f32 cannot tell from 0.
    pub(crate) fn stop_depth(&self) -> f32 {
        (-(-self.stop_opacity).ln_1p()).min(100.0)
    }
}
