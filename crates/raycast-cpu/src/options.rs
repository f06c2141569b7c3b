//! How it draws.

use tetrascope_core::Error;
use tetrascope_f32::Domain;

/// How rays are cast.
#[derive(Clone, Debug, PartialEq)]
pub struct RaycastCpuOptions {
    /// The opacity at which a ray stops, 0.5 to 1; at 1 nothing that shows is left out.
    pub stop_opacity: f32,
    /// How far the light of one segment of a ray in a grid may be off, relative to the greatest;
    /// grids only.
    pub tolerance: f64,
    /// The box and range to which numbers of a mesh are relative: those of a whole of which it is a part, or of a series of
    /// which it is a step; `None` for its own.
    pub domain: Option<Domain>,
    /// Bytes that a mesh in clusters may take: half of them for clusters that are read, a quarter for those that are
    /// kept for the next frame, an eighth for what rays gather. A lower bound is what one cluster needs.
    pub memory: u64,
    /// Threads that draw; `None` is rayon's own pool, one a core. Pixels do not depend on it.
    pub threads: Option<usize>,
}

impl Default for RaycastCpuOptions {
    fn default() -> RaycastCpuOptions {
        RaycastCpuOptions::from_settings(&tetrascope_core::Settings::defaults(&crate::ENTRY))
    }
}

impl RaycastCpuOptions {
    /// The optical depth beyond which a ray stops.
    ///
    /// At 100 transmittance is 4e-44, which f32 cannot tell from 0.
    pub(crate) fn stop_depth(&self) -> f32 {
        (-(-self.stop_opacity).ln_1p()).min(100.0)
    }

    /// Refuses numbers out of range.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String, help: &str| {
            Err(Error::Invalid {
                what,
                help: Some(help.into()),
            })
        };
        if !(0.5..=1.0).contains(&self.stop_opacity) {
            return wrong(
                format!("a stop at the opacity {}", self.stop_opacity),
                "give 0.5 to 1",
            );
        }
        if !(1e-7..=0.1).contains(&self.tolerance) {
            return wrong(
                format!("a tolerance of {}", self.tolerance),
                "give 1e-7 to 0.1",
            );
        }
        Ok(())
    }
}
