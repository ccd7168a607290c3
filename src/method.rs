//! Translates the options of a map into a method of the Vulkan engine.

use crate::surface::{Sources, Surface};
use crate::{Error, Options, vulkan};

impl Options {
    /// Returns the method with which [`vulkan::HeadlessSolver`] computes the same map as
    /// [`crate::distance_map`] on a device: the wavefront for these sources, the schedule and the stop
    /// criterion.
    ///
    /// # Errors
    /// If an option is out of range, or the wavefront does not suit the sources.
    pub fn method(&self, surface: &Surface, sources: &Sources) -> Result<vulkan::Method, Error> {
        Ok(vulkan::Method::new(
            self.resolve_wavefront(surface, sources)?,
            self.stop(surface, crate::DEFAULT_TOLERANCE)?,
        )
        .with_schedule(self.schedule))
    }
}
