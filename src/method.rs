//! What the options of a map ask of the Vulkan engine.

use crate::surface::{Sources, Surface};
use crate::{Error, Options, vulkan};

impl Options {
    /// How [`vulkan::Solver`] computes the map that [`crate::distance_map`] computes on a device:
    /// the wavefront for these sources, and when to stop.
    ///
    /// # Errors
    /// If an option is out of range, or the wavefront does not suit the sources.
    pub fn method(&self, surface: &Surface, sources: &Sources) -> Result<vulkan::Method, Error> {
        Ok(vulkan::Method {
            wavefront: self.wavefront(surface, sources)?,
            schedule: self.schedule,
            stop: self.stop::<f32>(surface)?,
        })
    }
}
