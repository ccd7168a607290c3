//! Enumerations. What C passes is read as a number: any may come.

use super::status::Failure;
use crate::surface::EdgeRule;
use crate::update::Wavefront;
use crate::vulkan::Schedule;

/// The shape of the front that is assumed inside a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepWavefront {
    /// Straight: first-order accurate, the cheapest.
    Planar = 0,
    /// Circular around a virtual point source: exact on the plane, for point sources.
    PointSource = 1,
    /// Carries its curvature beside the distance: second-order on curved surfaces and around holes.
    Curved = 2,
    /// Knows the corner or source that it comes from on a straight line: exact over planes with holes that
    /// are known to be such. Surfaces on a device are not: there it is curved.
    Anchored = 3,
}

/// The order of updates. All lead to the same map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepSchedule {
    /// The best on the device for the grid, as far as it is known, of those that the solver was made
    /// for. For plans only.
    Best = 0,
    /// Four scans over the whole grid, one after another; an iteration is all four.
    Raster = 1,
    /// All points at once: for tiny grids.
    AllPoints = 2,
    /// Scans inside tiles, where something has changed; an iteration is a round of tiles.
    Tiles = 3,
}

/// How the edges between grid points are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepEdgeRule {
    /// Along a cubic through the neighbouring points, where the surface is smooth.
    Arc = 0,
    /// The straight line: the surface is a polyhedron.
    Chord = 1,
}

/// A `GeosweepWavefront`, or so the program says.
pub(super) type WavefrontNumber = i32;
/// A `GeosweepSchedule`, or so the program says.
pub(super) type ScheduleNumber = i32;
/// A `GeosweepEdgeRule`, or so the program says.
pub(super) type EdgeRuleNumber = i32;

pub(super) fn wavefront(number: WavefrontNumber, name: &str) -> Result<Wavefront, Failure> {
    let choices = Wavefront::EVERY.map(|choice| (wavefront_number(choice), choice));
    choose(number, name, "GeosweepWavefront", &choices)
}

/// The number that stands for a wavefront in C.
pub(super) fn wavefront_number(wavefront: Wavefront) -> WavefrontNumber {
    match wavefront {
        Wavefront::Planar => GeosweepWavefront::Planar as i32,
        Wavefront::PointSource => GeosweepWavefront::PointSource as i32,
        Wavefront::Curved => GeosweepWavefront::Curved as i32,
        Wavefront::Anchored => GeosweepWavefront::Anchored as i32,
    }
}

/// `None` is the best one.
pub(super) fn schedule(number: ScheduleNumber, name: &str) -> Result<Option<Schedule>, Failure> {
    use GeosweepSchedule as S;
    let choices = [
        (S::Best as i32, None),
        (S::Raster as i32, Some(Schedule::Raster)),
        (S::AllPoints as i32, Some(Schedule::AllPoints)),
        (S::Tiles as i32, Some(Schedule::Tiles)),
    ];
    choose(number, name, "GeosweepSchedule", &choices)
}

/// The number that stands for a schedule in C.
pub(super) fn schedule_number(schedule: Schedule) -> ScheduleNumber {
    match schedule {
        Schedule::Raster => GeosweepSchedule::Raster as i32,
        Schedule::AllPoints => GeosweepSchedule::AllPoints as i32,
        Schedule::Tiles => GeosweepSchedule::Tiles as i32,
    }
}

pub(super) fn edge_rule(number: EdgeRuleNumber, name: &str) -> Result<EdgeRule, Failure> {
    use GeosweepEdgeRule as R;
    let choices = [(R::Arc as i32, EdgeRule::Arc), (R::Chord as i32, EdgeRule::Chord)];
    choose(number, name, "GeosweepEdgeRule", &choices)
}

/// The choice with a number.
pub(super) fn choose<T: Copy>(
    number: i32,
    name: &str,
    of: &str,
    choices: &[(i32, T)],
) -> Result<T, Failure> {
    let choice = choices.iter().find(|choice| choice.0 == number).map(|choice| choice.1);
    choice.ok_or_else(|| Failure::argument(name, format!("is {number}, which is no {of}")))
}
