//! Enumerations. C passes them as plain integers, so any value may arrive.

use super::status::Failure;
use geosweep::Wavefront;
use geosweep::surface::EdgeRule;
use geosweep::vulkan::Schedule;

/// Shape of the wavefront that is assumed inside a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepWavefront {
    /// Straight front: first-order accurate and the cheapest.
    Planar = 0,
    /// Circular front around a virtual point source: exact on the plane, for point sources.
    Circular = 1,
    /// Front that carries its curvature along with the distance: second-order accurate on curved surfaces and
    /// around holes.
    Curved = 2,
    /// Front that stores the corner or source from which it comes in a straight line: exact over planes with
    /// holes. This requires a surface that is known to be such a plane. Surfaces on a device are not known to
    /// be planes, so they get curved fronts.
    Anchored = 3,
    /// Front that carries its curvature, its direction and its source, for maps on the CPU
    /// (`geosweep_cpu_map`): where fronts of several sources meet, or a front meets itself, each goes on alone. Solvers
    /// on a device use curved fronts in its place.
    Rays = 4,
}

/// Order of updates. All schedules lead to the same map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepSchedule {
    /// The best known schedule for the grid on this device, among those that the solver was created for.
    /// Plans alone accept this value.
    Best = 0,
    /// Four scans over the whole grid, in turn or in pairs. An iteration is all four scans.
    Raster = 1,
    /// Scans inside the tiles in which something has changed. An iteration is a round of tiles.
    Tiles = 3,
}

/// Rule by which the edges between grid points are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepEdgeRule {
    /// Length of a cubic through the neighbouring points, where the surface is smooth.
    Arc = 0,
    /// Length of the straight line: the surface is a polyhedron.
    Chord = 1,
}

/// Sides of the grid that coincide. Each of two coinciding sides holds the points of their seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepGluing {
    /// None: the surface is open.
    None = 0,
    /// The last column is the first one, as on a tube.
    Columns = 1,
    /// The last row is the first one.
    Rows = 2,
    /// Columns and rows, as on a torus.
    Both = 3,
    /// The last column is the first one in reverse order, as on a Moebius strip.
    FlippedColumns = 4,
    /// The last row is the first one in reverse order.
    FlippedRows = 5,
    /// Rows are latitudes and columns longitudes: the last column is the first one, and the first and the last row
    /// are one point each.
    Globe = 6,
    /// Each side of a square is folded in its middle. The middle of the grid is one pole of a sphere, and its
    /// corners are the other.
    Octahedral = 7,
    /// The pairs of points that `GeosweepSurfaceInfo::runs` names.
    Runs = 8,
}

/// Number of a `GeosweepWavefront`, not checked yet.
pub(super) type WavefrontNumber = i32;
/// Number of a `GeosweepSchedule`, not checked yet.
pub(super) type ScheduleNumber = i32;
/// Number of a `GeosweepEdgeRule`, not checked yet.
pub(super) type EdgeRuleNumber = i32;
/// Number of a `GeosweepGluing`, not checked yet.
pub(super) type GluingNumber = i32;

/// Choice of the library that has a number in C.
pub(super) trait Choice: Copy + PartialEq + 'static {
    /// Name of the enumeration in the header.
    const NAME: &'static str;
    /// All choices with their numbers.
    const ALL: &'static [(i32, Self)];
}

/// Implements [`Choice`] for enumerations whose names in C are the same.
macro_rules! choices {
    ($($choice:ident = $of:ident: $($name:ident),*;)*) => {$(
        impl $crate::choices::Choice for $choice {
            const NAME: &'static str = stringify!($of);
            const ALL: &'static [(i32, Self)] = &[$(($of::$name as i32, Self::$name)),*];
        }
    )*};
}
pub(super) use choices;

choices! {
    Wavefront = GeosweepWavefront: Planar, Circular, Curved, Anchored, Rays;
    EdgeRule = GeosweepEdgeRule: Arc, Chord;
    GeosweepGluing = GeosweepGluing:
        None, Columns, Rows, Both, FlippedColumns, FlippedRows, Globe, Octahedral, Runs;
}

/// The best schedule is `None`.
impl Choice for Option<Schedule> {
    const NAME: &'static str = "GeosweepSchedule";
    const ALL: &'static [(i32, Self)] = &[
        (GeosweepSchedule::Best as i32, None),
        (GeosweepSchedule::Raster as i32, Some(Schedule::Raster)),
        (GeosweepSchedule::Tiles as i32, Some(Schedule::Tiles)),
    ];
}

/// Returns the choice with this number.
pub(super) fn choose<T: Choice>(number: i32, name: &str) -> Result<T, Failure> {
    let choice = T::ALL.iter().find(|choice| choice.0 == number).map(|choice| choice.1);
    choice.ok_or_else(|| Failure::argument(name, format!("is {number}, which is no {}", T::NAME)))
}

/// Returns the number of a choice in C.
pub(super) fn number<T: Choice>(choice: T) -> i32 {
    let of = T::ALL.iter().find(|of| of.1 == choice);
    of.expect("each choice has a number").0
}
