//! Frames whose maps end at a radius or at targets, which change from frame to frame.

use geosweep::Wavefront;
use geosweep::surface::Chart;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{Frame, MapLimit, Reader, SourceInput, SurfaceInfo, TargetPoint};

use crate::common::parts::{assert_is_part, farthest};
use crate::embed::stage::{Kept, Stage, source};

const CHART: Chart = Chart { rows: 150, cols: 190 };

/// Runs a frame until its map has converged. Returns the distances and the visits.
fn limited(
    stage: &Stage,
    plan: &geosweep::vulkan::embed::Plan,
    limit: MapLimit,
) -> (Vec<f32>, u32) {
    let sources = source(60.0, 80.0);
    let frame = Frame::new(plan, SourceInput::Inline(&sources), Reader::COPY).with_limit(limit);
    stage.run(|recording| recording.frame(&frame));
    stage.finish(plan);
    (stage.read(), stage.surface.outcome(0).unwrap().visits)
}

#[test]
fn a_radius_and_targets_change_from_frame_to_frame() {
    let passes = Schedule::ALL.map(|schedule| (schedule, Wavefront::Curved));
    let stage = Stage::of_waves(Kept::watched(), &passes, SurfaceInfo::new(CHART), 0.4);
    for (schedule, wavefront) in passes {
        let plan = stage.plan(schedule, wavefront, 16);
        let sources = source(60.0, 80.0);
        let whole = stage.map(0, SourceInput::Inline(&sources), &plan);
        let all = stage.surface.outcome(0).unwrap().visits;
        let mut before = 0;
        for share in [0.1, 0.3, 0.7] {
            let radius = share * farthest(&whole) as f32;
            let (near, visits) = limited(&stage, &plan, MapLimit::at(radius));
            assert_is_part(&near, &whole, radius.into(), &format!("{schedule}, {share}"));
            assert!(before < visits && visits < all, "{schedule}: {visits} of {all}");
            before = visits;
        }
        let targets = [(20, 30), (140, 150), (70, 95)].map(|(row, col)| TargetPoint::at(row, col));
        for needed in [1, 2, 3] {
            let limit = MapLimit::to(&targets).with_needed(needed);
            let (near, visits) = limited(&stage, &plan, limit);
            let mut times = targets.map(|at| whole[CHART.index(at.row as usize, at.col as usize)]);
            times.sort_by(f32::total_cmp);
            let end = f64::from(times[needed as usize - 1]);
            assert_is_part(&near, &whole, end, &format!("{schedule}, {needed} targets"));
            // Only the schedule of tiles visits less if a map ends at targets.
            assert!(visits < all || schedule != Schedule::Tiles, "{schedule}: {visits} of {all}");
        }
        let (again, _) = limited(&stage, &plan, MapLimit::NONE);
        assert!(again == whole, "{schedule}");
    }
    stage.end([]);
}

#[test]
fn a_limit_that_cannot_be_is_refused() {
    let passes = [(Schedule::Tiles, Wavefront::Curved)];
    let stage = Stage::of_waves(Kept::watched(), &passes, SurfaceInfo::new(CHART), 0.4);
    let plan = stage.plan(Schedule::Tiles, Wavefront::Curved, 16);
    let sources = source(60.0, 80.0);
    stage.map(0, SourceInput::Inline(&sources), &plan);
    let off = [TargetPoint::at(150, 3)];
    for (limit, part) in [
        (MapLimit::at(-1.0), "the radius -1 is not positive"),
        (MapLimit::to(&off), "the target (150, 3) is outside the 150 x 190 points"),
    ] {
        let sources = SourceInput::Inline(&sources);
        let frame = Frame::new(&plan, sources, Reader::COPY).with_limit(limit);
        stage.run(|recording| {
            let error = recording.frame(&frame).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
            let error = recording.limited(limit).solve(sources, &plan).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
            recording.frame(&Frame::new(&plan, sources, Reader::COPY))
        });
    }
    stage.end([]);
}
