//! Defines how a map is solved on a device.

use super::schedule::Schedule;
use crate::Stop;
use crate::update::Wavefront;

/// Parameters of solving a map on a device.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Method {
    /// Front assumed inside a triangle. [`Wavefront::Anchored`] requires a floor plan
    /// ([`crate::Surface::is_floor_plan`]) of at most 33 million points, and at most 4096 sources inside
    /// cells. If these conditions are not met, the map is solved with [`Wavefront::Curved`] instead.
    pub wavefront: Wavefront,
    /// Order of updates. `None` selects [`Schedule::best_on`] the device.
    pub schedule: Option<Schedule>,
    /// Stopping criterion. It counts the iterations of the schedule.
    pub stop: Stop,
    /// Largest arrival time of the map. Points that fronts reach later are unreached, and their distance is +infinity.
    /// The work is about proportional to the area within the radius. With +infinity there is no limit. Frames have a
    /// limit of their own: [`crate::vulkan::embed::Frame::limit`].
    pub radius: f64,
}

impl Method {
    /// Returns the method that solves with `wavefront` until `stop`, in the best order for the device.
    pub fn new(wavefront: Wavefront, stop: Stop) -> Self {
        Self { wavefront, schedule: None, stop, radius: f64::INFINITY }
    }

    /// Sets [`Method::wavefront`].
    pub fn with_wavefront(self, wavefront: Wavefront) -> Self {
        Self { wavefront, ..self }
    }

    /// Sets [`Method::schedule`].
    pub fn with_schedule(self, schedule: impl Into<Option<Schedule>>) -> Self {
        Self { schedule: schedule.into(), ..self }
    }

    /// Sets [`Method::stop`].
    pub fn with_stop(self, stop: Stop) -> Self {
        Self { stop, ..self }
    }

    /// Sets [`Method::radius`].
    pub fn with_radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }
}
