//! Outputs and frames of them that make no sense are errors before anything is recorded.

use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::VulkanError;
use geosweep::vulkan::embed::{
    Access, ContourFrame, DirectionFrame, HostImage, LevelInput, PathFrame, PathsInfo, Reader,
    RegionFrame, SourceInput, StartInput,
};

use geosweep::Wavefront;

use super::Scene;
use super::contours::new_contours;
use super::paths::new_paths;
use crate::common::closed::flat;
use crate::embed::stage::{Kept, sources_at};
use crate::host::Host;

/// Returns the scene under test, on a host that reports objects that are left behind, and another scene.
fn scenes() -> [Scene; 2] {
    let (surface, sources) = (flat(9, 13), sources_at(&[[1.0, 2.0]]));
    [Scene::new(Host::new(), &surface, &sources), Scene::new(Kept::watched(), &surface, &sources)]
}

/// Asserts that a call, or a frame on a scene, is refused.
macro_rules! refused {
    ($scene:expr, $record:ident($output:expr, $frame:expr)) => {
        $scene.stage.attempt(|recording| recording.$record($output, $frame).unwrap_err())
    };
}

#[test]
fn contours_and_paths_that_make_no_sense_are_errors() {
    let [mut scene, other] = scenes();
    let mut contours = new_contours(&mut scene, 100);
    let frame = ContourFrame::new(LevelInput::List(&[1.0]), Access::DRAW);
    let of_other = refused!(other, contours(&contours, &frame));
    assert!(matches!(of_other, VulkanError::OtherSurface));
    let absent = refused!(scene, contours(&contours, &frame.with_points(1)));
    assert!(matches!(absent, VulkanError::NoSuch { .. }));
    let levels = frame.with_levels(LevelInput::List(&[2.0, 1.0]));
    let error = refused!(scene, contours(&contours, &levels)).to_string();
    assert!(error.contains("2 comes before 1"), "{error}");

    let mut paths = new_paths(&mut scene, PathsInfo::new(2, 30));
    let places = sources_at(&[[1.0, 2.0]]);
    let starts = StartInput::Inline(&[[0.0; 2]; 2]);
    let frame = PathFrame::new(starts, SourceInput::Inline(&places), Access::DRAW);
    assert!(matches!(refused!(other, paths(&paths, &frame)), VulkanError::OtherSurface));
    for absent in [frame.with_points(1), frame.with_sources(SourceInput::Buffer(0))] {
        assert!(matches!(refused!(scene, paths(&paths, &absent)), VulkanError::NoSuch { .. }));
    }
    let given = scene.stage.host.buffer_of(&[0.0; 8]);
    let buffer = |buffer, offset| StartInput::Buffer { buffer, offset, count: 1 };
    for (starts, reason) in [
        (StartInput::Inline(&[[0.0; 2]; 3]), "3 starts"),
        (buffer(vk::Buffer::null(), 0), "null handle"),
        (buffer(given.handle, 2), "offset 2"),
    ] {
        let error = refused!(scene, paths(&paths, &frame.with_starts(starts))).to_string();
        assert!(error.contains(reason), "{error}");
    }

    let device = scene.stage.host.device.clone();
    let stage = &mut scene.stage;
    for (room, reason) in [(1, "too few"), (u32::MAX, "bytes")] {
        let made = stage.solver.contours(&device, stage.host.allocator(), &stage.surface, room);
        let error = made.unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    for (count, vertices, reason) in [
        (0, 9, "from 1 to"),
        (70_000, 9, "from 1 to"),
        (9, 1, "too few"),
        (60_000, 60_000, "bytes"),
    ] {
        let info = PathsInfo::new(count, vertices);
        let made = stage.solver.paths(&device, stage.host.allocator(), &stage.surface, info);
        let error = made.unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    contours.destroy(&device, stage.host.allocator());
    stage.host.free(given);
    scene.end_with(|device, allocator| paths.destroy(device, allocator));
    other.end();
}

#[test]
fn directions_and_regions_that_make_no_sense_are_errors() {
    let [mut scene, other] = scenes();
    let mut directions = scene.new_directions();
    let sources = sources_at(&[[1.0, 2.0]]);
    let outside = sources_at(&[[9.0, 2.0]]);
    let [inline, outside] = [&sources, &outside].map(|list| SourceInput::Inline(list));
    let frame = DirectionFrame::new(inline, Reader::COPY);
    assert!(matches!(refused!(other, directions(&directions, &frame)), VulkanError::OtherSurface));
    let absent = frame.with_sources(SourceInput::Buffer(0));
    let absent = refused!(scene, directions(&directions, &absent));
    assert!(matches!(absent, VulkanError::NoSuch { .. }));
    let error = refused!(scene, directions(&directions, &frame.with_sources(outside)));
    assert!(matches!(error, VulkanError::Source(_)));
    let null = HostImage { image: vk::Image::null(), view: vk::ImageView::null() };
    directions.set_image(null).unwrap_err();

    let device = scene.stage.host.device.clone();
    let stage = &mut scene.stage;
    let made = stage.solver.directions_into(&device, stage.host.allocator(), &stage.surface, null);
    let error = made.unwrap_err().to_string();
    assert!(error.contains("null handle"), "{error}");
    directions.destroy(&device, stage.host.allocator());
    assert!(matches!(refused!(scene, directions(&directions, &frame)), VulkanError::Destroyed));

    let stage = &mut scene.stage;
    let (allocator, curved) = (stage.host.allocator(), Wavefront::Curved);
    let regions = stage.solver.regions(&device, allocator, &stage.surface, curved);
    let mut regions = regions.unwrap();
    let frame = RegionFrame::new(inline, Access::NONE);
    assert!(matches!(refused!(other, regions(&regions, &frame)), VulkanError::OtherSurface));
    let many = vec![sources[0]; 1025];
    let attempt = |sources| refused!(scene, regions(&regions, &frame.with_sources(sources)));
    assert!(matches!(attempt(SourceInput::Buffer(1)), VulkanError::NoSuch { .. }));
    let many = attempt(SourceInput::Inline(&many));
    assert!(matches!(many, VulkanError::TooManySources { .. }));
    assert!(matches!(attempt(outside), VulkanError::Source(_)));
    let huge = Chart { rows: 1 << 14, cols: 1 << 14 };
    scene.stage.solver.bytes_for_regions(&device, huge).unwrap_err();
    scene.end_with(|device, allocator| regions.destroy(device, allocator));
    other.end();
}
