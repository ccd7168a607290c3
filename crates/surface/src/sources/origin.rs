//! Defines origins: the straight sources from which the fronts of a map come.

use glam::DVec2;

/// A source that is a point or a straight segment of the chart. All fronts around it, including the circular
/// ones around its ends, have this source as their origin and start at the same time.
///
/// Over an even grid the arrival time of its front is the start plus the distance to the segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// Rows and columns of both ends. They are equal for a point.
    pub ends: [DVec2; 2],
    /// Arrival time at the source.
    pub start: f64,
}

impl Origin {
    /// Returns a point source at a row and column that starts at the time `start`.
    pub fn point(at: DVec2, start: f64) -> Self {
        Self { ends: [at; 2], start }
    }

    /// Returns whether the source is a point.
    #[doc(hidden)]
    pub fn is_point(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// Returns this origin with a start that is earlier by `by`.
    #[doc(hidden)]
    pub fn started_earlier(self, by: f64) -> Self {
        Self { start: self.start - by, ..self }
    }

    /// Returns this origin with rows and columns that are larger by `by`.
    #[doc(hidden)]
    pub fn moved(self, by: DVec2) -> Self {
        Self { ends: self.ends.map(|end| end + by), ..self }
    }

    /// Returns a key that distinguishes origins.
    #[doc(hidden)]
    pub fn key(&self) -> [u64; 5] {
        let [a, b] = self.ends;
        [a.x, a.y, b.x, b.y, self.start].map(f64::to_bits)
    }
}
