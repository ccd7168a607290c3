//! Origins: the straight sources that the fronts of a map come from.

use glam::DVec2;

/// A source that is a point or a straight segment of the chart: all fronts around it, those around its ends
/// included, come from the same place at the same time.
///
/// Over an even grid the arrival time of its front is the start plus the distance to the segment. Where fronts of
/// several origins meet, the curved update needs this: two fronts that arrive together, equally curved, are
/// those of one circle only if they have one origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// Rows and columns of both ends, which are equal for a point.
    pub ends: [DVec2; 2],
    /// Arrival time at the source.
    pub start: f64,
}

impl Origin {
    /// A point source at a row and column, from some time on.
    pub fn point(at: DVec2, start: f64) -> Self {
        Self { ends: [at; 2], start }
    }

    /// Whether it is a point.
    pub(crate) fn is_point(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// The same by so much earlier.
    pub(crate) fn started_earlier(self, by: f64) -> Self {
        Self { start: self.start - by, ..self }
    }

    /// Its numbers as a key that tells origins apart.
    pub(crate) fn key(&self) -> [u64; 5] {
        let [a, b] = self.ends;
        [a.x, a.y, b.x, b.y, self.start].map(f64::to_bits)
    }
}
