//! Defines the initial values at grid points, from which maps are solved.

use std::collections::BTreeMap;

use glam::DVec2;

use super::Origin;
use crate::Real;

/// An initial value at a grid point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// Row of the point.
    pub row: usize,
    /// Column of the point.
    pub col: usize,
    /// Arrival time at the point.
    pub time: f64,
    /// Curvature of the front at the point, for the curved wavefront: 1 over the distance from a point
    /// source, [`Seed::AT_SOURCE`] at the source itself, 0 beside a straight curve.
    pub curvature: f64,
    /// Row and column of the point source from which the front comes, if the source is not this point itself. The
    /// source is the anchor of the points that the front reaches next ([`crate::Wavefront::Anchored`]).
    pub from: Option<DVec2>,
    /// The straight source from which the front comes, where that is known; see
    /// [`Sources::seeds_with_origins`](super::Sources::seeds_with_origins).
    pub origin: Option<Origin>,
    /// Whether the time is as exact as the edges allow (from a map of the source alone), and no front of
    /// another source can arrive here first. Curved fronts then do not replace the seed, except for fronts of sources
    /// that are added later.
    pub exact: bool,
    /// The direction in which the front passes the point.
    pub heading: Heading,
    /// Number of the source from which the front comes, among the sources of the map.
    pub source: u32,
}

/// The direction in which the front of a seed passes its point. Steps are in rows and columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heading {
    /// The front leaves the point in all directions, as at a point source.
    Everywhere,
    /// The front goes on along this step, which comes from the nearest place of the source.
    Along(DVec2),
    /// The point lies on a curve that runs along this step, and the front leaves to both sides.
    ToBothSides(DVec2),
}

impl Heading {
    /// Returns the direction after rows and columns are multiplied by factors.
    pub(super) fn turned(self, by: DVec2) -> Self {
        match self {
            Self::Everywhere => Self::Everywhere,
            Self::Along(step) => Self::Along(step * by),
            Self::ToBothSides(step) => Self::ToBothSides(step * by),
        }
    }
}

/// Error of a curved update in units in the last place of the arrival time: the rounding of a height over a base, and
/// of a sum.
const SURELY_FIRST: f64 = 8.0;

impl Seed {
    /// Curvature of a front at its point source. It stands for infinity.
    pub const AT_SOURCE: f64 = crate::constants::SOURCE_CURVATURE;

    /// Returns the seed of a point source at a grid point.
    pub fn at_source(row: usize, col: usize, time: f64) -> Self {
        Self {
            row,
            col,
            time,
            curvature: Self::AT_SOURCE,
            from: None,
            origin: None,
            exact: false,
            heading: Heading::Everywhere,
            source: 0,
        }
    }

    /// Returns the time at which a curved front starts here. Beside a curve this is earlier than the seed's time by
    /// some units in the last place.
    ///
    /// A front that leaves the curve passes this point at the same time up to rounding, with a curvature that
    /// includes that of the surface. Without the shift, rounding would decide which of the two fronts
    /// stays, and two maps of a rough surface would differ by some per cent. There is no shift at the ends of a curve,
    /// where the front from beside the end is flatter and should stay.
    #[doc(hidden)]
    pub fn start_of_curved<R: Real>(&self) -> R {
        let is_beside =
            !self.exact && self.from.is_none() && (self.curvature * self.time).abs() < 0.5;
        let rounding = self.time.abs() * SURELY_FIRST * R::epsilon().wide();
        R::of(if is_beside { self.time - rounding } else { self.time })
    }

    /// Returns whether the arrival time of a map is later than this seed by more than rounding. In that case
    /// a preliminary front replaced the seed and was withdrawn later. Solvers then start from the seed again.
    #[doc(hidden)]
    pub fn is_lost<R: Real>(&self, time: R) -> bool {
        let start = R::of(self.time);
        time - start > start.abs() * (R::of(8.0) * R::epsilon())
    }

    /// Returns the earliest seed of each point, in row-major order.
    #[doc(hidden)]
    pub fn earliest(seeds: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut earliest = BTreeMap::new();
        for seed in seeds {
            let first = earliest.entry((seed.row, seed.col)).or_insert(seed);
            if seed.time < first.time {
                *first = seed;
            }
        }
        earliest.into_values().collect()
    }

    /// Returns row and column as a place.
    #[doc(hidden)]
    pub fn place(&self) -> DVec2 {
        DVec2::new(self.row as f64, self.col as f64)
    }
}

/// The origins of the fronts of a map, which decide whether updates must be causal. A causal update does not
/// depend on neighbours that arrive later.
///
/// Without causal updates, fronts of several sources that meet would settle in more than one way, or never.
/// A single front that meets itself, because a slowness or a steep surface bends it, needs causal updates too.
/// Otherwise a single point source does not need causal updates; without them it is more accurate in stretched cells.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origins {
    /// Whether the front of one origin may meet itself.
    meets_itself: bool,
    first: Option<DVec2>,
    causal: bool,
}

impl Origins {
    /// Creates an empty set. `meets_itself` tells whether a front may meet itself on the surface
    /// ([`super::EdgeLengths::front_meets_itself`]).
    #[doc(hidden)]
    pub fn none(meets_itself: bool) -> Self {
        Self { meets_itself, first: None, causal: false }
    }

    /// Forgets all origins, before another map.
    #[doc(hidden)]
    pub fn forget(&mut self) {
        *self = Self::none(self.meets_itself);
    }

    /// Adds the origin of a seed. Each seed of a curve is its own origin.
    #[doc(hidden)]
    pub fn add(&mut self, seed: &Seed) {
        let origin = seed.from.unwrap_or(seed.place());
        self.causal |= *self.first.get_or_insert(origin) != origin;
    }

    #[doc(hidden)]
    pub fn are_causal(&self) -> bool {
        self.causal || self.meets_itself
    }

    /// Returns whether there are several origins, or one that is not a point.
    #[doc(hidden)]
    pub fn are_several(&self) -> bool {
        self.causal
    }
}
