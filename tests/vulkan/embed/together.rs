//! Frames of several surfaces that are recorded together: each has the same map as if recorded alone.

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, FrameSurface, PointSource, Points, Reader, SourceBuffer, SourceInput,
    SurfaceFrame, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule, VulkanError};

use crate::embed::stage::{Kept, STOP, Stage, source, vertices};
use crate::host::{Host, HostBuffer};

/// A surface with its plan and the inputs of its frames.
struct Part {
    surface: FrameSurface,
    plan: embed::Plan,
    /// Points, sources, and a copy of the distances.
    buffers: [HostBuffer; 3],
    sources: Vec<PointSource>,
    from_buffer: bool,
    points_at: u64,
    reader: Reader,
}

impl Part {
    fn frame(&self, slot: usize, measures: bool) -> Frame<'_> {
        Frame::new(
            &self.plan,
            match self.from_buffer {
                true => SourceInput::Buffer(0),
                false => SourceInput::Inline(&self.sources),
            },
            self.reader,
        )
        .with_points(measures.then_some(0))
        .with_slot(slot)
        .with_unreached(-1.0)
    }

    /// Copies the image of a slot, and reads the copy.
    fn read(&self, host: &Host, slot: usize) -> Vec<f32> {
        let image = self.surface.result(slot, self.reader.layout).unwrap();
        host.run(|commands| host.copy_image(commands, image, &self.buffers[2]));
        self.buffers[2].floats()[..self.surface.chart().points()].to_vec()
    }
}

/// The surfaces have two schedules and two wavefronts, three sizes (one measured in several bands), crowds and
/// single sources, inline and in a buffer, and several readers.
#[test]
fn maps_recorded_together_are_those_recorded_alone() {
    let host = Kept::watched_but_for_shaders();
    let device = host.device.clone();
    let (raster, tiles) = (Schedule::Raster, Schedule::Tiles);
    let (planar, curved) = (Wavefront::Planar, Wavefront::Curved);
    let passes = [(raster, planar), (raster, curved), (tiles, curved)];
    let tiny = SurfaceInfo::new(Chart { rows: 2, cols: 2 });
    let mut stage = Stage::new(host, &passes, &tiny);
    let crowd: Vec<_> =
        (0..300).map(|i| PointSource::at((i % 37) as f32, 0.25 * i as f32 % 40.0)).collect();
    let single = source(7.25, 20.5).to_vec();
    let general = Reader { layout: vk::ImageLayout::GENERAL, ..Reader::COPY };
    let mut parts: Vec<Part> = [
        (40, 50, raster, curved, &single, false, 0, Reader::COPY),
        (40, 50, raster, curved, &crowd, false, 32 * 40 * 50, general),
        (700, 500, raster, planar, &crowd, true, 0, Reader::COPY),
        (61, 43, tiles, curved, &single, true, 0, Reader::COPY),
    ]
    .into_iter()
    .map(|(rows, cols, schedule, wavefront, sources, from_buffer, points_at, reader)| {
        let chart = Chart { rows, cols };
        let all = [vertices(chart, 0.4), vertices(chart, 1.7)].concat();
        let points = stage.host.buffer_of(&all);
        let entries = stage.host.buffer_of(bytemuck::cast_slice(sources));
        let inputs = [Points::positions(points.handle, 32)];
        let count = sources.len() as u32;
        let buffers = [SourceBuffer { buffer: entries.handle, offset: 0, count }];
        let info =
            SurfaceInfo::new(chart).with_slots(2).with_points(&inputs).with_sources(&buffers);
        let surface = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
        stage.host.run(|commands| stage.solver.record(&device, commands, &surface).prepare());
        let method = Method::new(wavefront, STOP).with_schedule(schedule);
        let plan = stage.solver.plan(chart, method, 12).unwrap();
        let to = stage.host.buffer(4 * chart.points() as u64, true);
        let sources = sources.clone();
        let buffers = [points, entries, to];
        Part { surface, plan, buffers, sources, from_buffer, points_at, reader }
    })
    .collect();
    for measures in [true, false] {
        let alone: Vec<_> = parts
            .iter()
            .map(|part| {
                stage.host.run(|commands| {
                    let recording = stage.solver.record(&device, commands, &part.surface);
                    let frame = part.frame(0, measures);
                    recording.points_at(part.points_at).frame(&frame).unwrap();
                });
                (part.read(&stage.host, 0), part.surface.outcome(0).unwrap())
            })
            .collect();
        let frames: Vec<_> = parts
            .iter()
            .map(|part| {
                SurfaceFrame::new(&part.surface, part.frame(1, measures))
                    .with_points_at(part.points_at)
            })
            .collect();
        stage.host.run(|commands| {
            // The frames run twice, since a frame may follow another in one command buffer.
            stage.solver.record_frames(&device, commands, &frames).unwrap();
            stage.solver.record_frames(&device, commands, &frames).unwrap();
        });
        for (number, (part, (map, outcome))) in parts.iter().zip(&alone).enumerate() {
            assert!(part.read(&stage.host, 1) == *map, "surface {number}");
            assert_eq!(part.surface.outcome(1).unwrap(), *outcome, "surface {number}");
        }
    }
    for part in &mut parts {
        part.surface.destroy(&device, stage.host.allocator());
    }
    stage.end(parts.into_iter().flat_map(|part| part.buffers));
}

#[test]
fn a_frame_among_several_that_cannot_be_recorded_is_named() {
    let mut host = Kept::unwatched();
    let device = host.device.clone();
    let chart = Chart { rows: 9, cols: 12 };
    let points = host.buffer_of(&vertices(chart, 0.4));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(chart).with_points(&inputs);
    let mut stage = Stage::new(host, &[(Schedule::Raster, Wavefront::Planar)], &info);
    let mut other = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 4);
    let place = source(3.0, 4.0);
    let frame = Frame::new(&plan, SourceInput::Inline(&place), Reader::COPY)
        .with_points(0)
        .with_unreached(-1.0);
    let first = SurfaceFrame::new(&stage.surface, frame);
    let second = first.with_surface(&other);
    // Panics in place of each command, so that none can be recorded.
    extern "system" fn recorded() -> vk::Result {
        panic!("a frame that was refused has recorded something")
    }
    let strict = stage
        .host
        .device_with(|name| name.to_bytes().starts_with(b"vkCmd").then_some(recorded as _));
    let refused = |frames: &[SurfaceFrame]| {
        let none = vk::CommandBuffer::null();
        let error = stage.solver.record_frames(&strict, none, frames).unwrap_err();
        let VulkanError::OfFrame { number, source } = error else { panic!("{error}") };
        (number, *source)
    };
    assert!(matches!(refused(&[first, second]), (1, VulkanError::NotPrepared)));
    assert!(matches!(refused(&[second, first]), (0, VulkanError::NotPrepared)));
    assert!(matches!(refused(&[first, first]), (1, VulkanError::TwiceTogether)));
    let beyond = first.with_points_at(1 << 20);
    assert!(matches!(refused(&[beyond]), (0, VulkanError::HostBuffer { .. })));
    let no_slot = first.with_frame(frame.with_slot(1));
    assert!(matches!(refused(&[no_slot]), (0, VulkanError::NoSuch { .. })));
    stage.solver.record_frames(&strict, vk::CommandBuffer::null(), &[]).unwrap();
    assert!(!stage.surface.is_in_flight());
    other.destroy(&device, stage.host.allocator());
    stage.end([points]);
}
