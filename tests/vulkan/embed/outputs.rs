//! Images of the host to which distances are written. Other images of the host use the same memory at other
//! times.

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, Contours, CurveRecord, Frame, HostImage, LevelInput, PathFrame,
    Paths, PathsInfo, Points, Reader, RegionFrame, Regions, SourceInput, StartInput, SurfaceFrame,
    SurfaceInfo,
};
use geosweep::vulkan::{Schedule, VulkanError};

use crate::embed::stage::{Kept, RASTER, Stage, source, vertices};
use crate::host::{Host, HostBuffer};

const CHART: Chart = Chart { rows: 23, cols: 36 };

/// Images that alias the same memory, one after another.
struct Aliases {
    images: Vec<HostImage>,
    memory: vk::DeviceMemory,
}

impl Aliases {
    fn new(host: &Host, count: usize) -> Self {
        let device = &host.device;
        let extent = vk::Extent3D { width: CHART.cols as u32, height: CHART.rows as u32, depth: 1 };
        let usage = vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let info = vk::ImageCreateInfo::default()
            .flags(vk::ImageCreateFlags::ALIAS)
            .image_type(vk::ImageType::TYPE_2D)
            .format(vk::Format::R32_SFLOAT)
            .extent(extent)
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let images: Vec<_> =
            (0..count).map(|_| unsafe { device.create_image(&info, None) }.unwrap()).collect();
        let needed = unsafe { device.get_image_memory_requirements(images[0]) };
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needed.size)
            .memory_type_index(needed.memory_type_bits.trailing_zeros());
        let memory = unsafe { device.allocate_memory(&info, None) }.unwrap();
        let view = |image| {
            unsafe { device.bind_image_memory(image, memory, 0) }.unwrap();
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(vk::Format::R32_SFLOAT)
                .subresource_range(LEVEL);
            HostImage { image, view: unsafe { device.create_image_view(&info, None) }.unwrap() }
        };
        Self { images: images.into_iter().map(view).collect(), memory }
    }

    /// Makes another image take the memory: gives it a layout and clears it by a copy.
    fn take_over(&self, host: &Host, commands: vk::CommandBuffer, number: usize) {
        let barrier = vk::ImageMemoryBarrier::default()
            .image(self.images[number].image)
            .subresource_range(LEVEL)
            .src_access_mask(vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::SHADER_WRITE)
            .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        let stages = vk::PipelineStageFlags::TRANSFER | vk::PipelineStageFlags::COMPUTE_SHADER;
        let value = vk::ClearColorValue { float32: [1e9; 4] };
        unsafe {
            host.device.cmd_pipeline_barrier(
                commands,
                stages,
                vk::PipelineStageFlags::TRANSFER,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &[barrier],
            );
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            let image = self.images[number].image;
            host.device.cmd_clear_color_image(commands, image, layout, &value, &[LEVEL]);
        }
    }

    fn destroy(self, host: &Host) {
        for HostImage { image, view } in self.images {
            unsafe {
                host.device.destroy_image_view(view, None);
                host.device.destroy_image(image, None);
            }
        }
        unsafe { host.device.free_memory(self.memory, None) };
    }
}

const LEVEL: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// The vertices of two characters lie in a ring buffer, and two frames are in flight. The distances of one character
/// are written to an image of the host, whose memory belongs to another image for the rest of the frame. From frame 10
/// on, the image itself changes every second frame.
#[test]
fn two_characters_with_rings_and_an_aliased_image_have_their_maps() {
    const FRAMES: usize = 50;
    const SLOTS: usize = 2;
    let mut host = Kept::watched_but_for_shaders();
    let device = host.device.clone();
    let phases = [0.2, 1.1, 2.5];
    let part = 32 * CHART.points() as u64;
    let ring = host.buffer_of(&phases.map(|phase| vertices(CHART, phase)).concat());
    let inputs = [Points::positions(ring.handle, 32)];
    let alone = SurfaceInfo::new(CHART).with_slots(SLOTS).with_points(&inputs);
    let mut stage = Stage::new(host, &RASTER[2..], &alone);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    let places = [source(7.25, 20.5), source(19.0, 3.0)];
    let frame = |who: usize, slot| {
        Frame::new(&plan, SourceInput::Inline(&places[who]), Reader::COPY)
            .with_points(0)
            .with_slot(slot)
    };
    // The expected maps come from a surface with its own images, frame by frame.
    let mut expected: [Vec<Vec<f32>>; 2] = [Vec::new(), Vec::new()];
    for (who, maps) in expected.iter_mut().enumerate() {
        for at in [0, part, 2 * part] {
            stage.run(|recording| recording.points_at(at).frame(&frame(who, 0)));
            stage.finish(&plan);
            maps.push(stage.read());
        }
    }

    let aliases = Aliases::new(&stage.host, 4);
    let given = [aliases.images[0], aliases.images[1]];
    let info = alone.with_results(&given);
    assert!(
        stage.solver.bytes_for(&device, &info).unwrap()
            < stage.solver.bytes_for(&device, &alone).unwrap()
    );
    let mut second = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
    stage.host.run(|commands| stage.solver.record(&device, commands, &second).prepare());
    let bytes = 4 * CHART.points() as u64;
    let to = [(); SLOTS].map(|()| [(); 2].map(|()| stage.host.buffer(bytes, true)));
    let mut in_flight: [Option<(vk::Fence, usize)>; SLOTS] = [None; SLOTS];
    let check = |stage: &Stage, second: &embed::FrameSurface, slot: usize, fence, turn: usize| {
        unsafe {
            device.wait_for_fences(&[fence], true, u64::MAX).unwrap();
            device.destroy_fence(fence, None);
        }
        for (who, to) in to[slot].iter().enumerate() {
            let map = &to.floats()[..CHART.points()];
            assert!(map == expected[who][(turn + who) % 3], "frame {turn}, character {who}");
        }
        for surface in [&stage.surface, second] {
            let outcome = surface.outcome(slot).unwrap();
            assert!(outcome.converged && outcome.edges_without_length == 0, "{outcome:?}");
        }
    };
    for turn in 0..FRAMES {
        let slot = turn % SLOTS;
        if let Some((fence, before)) = in_flight[slot].take() {
            check(&stage, &second, slot, fence, before);
        }
        if turn >= 10 {
            // The render graph assigns another image.
            let image = aliases.images[(turn / 2) % 3];
            second.set_result(&device, slot, image).unwrap();
        }
        let commands = stage.host.commands();
        stage.host.begin(commands);
        aliases.take_over(&stage.host, commands, 3);
        let frames = [(&stage.surface, 0), (&second, 1)].map(|(surface, who)| {
            SurfaceFrame::new(surface, frame(who, slot).with_before(Access::TRANSFER_WRITE))
                .with_points_at(part * ((turn + who) % 3) as u64)
        });
        stage.solver.record_frames(&device, commands, &frames).unwrap();
        for (SurfaceFrame { surface, .. }, to) in frames.iter().zip(&to[slot]) {
            let image = surface.result(slot, Reader::COPY.layout).unwrap();
            stage.host.copy_image(commands, image, to);
        }
        stage.host.end(commands);
        let fence = unsafe { device.create_fence(&Default::default(), None) }.unwrap();
        stage.host.submit(commands, fence);
        in_flight[slot] = Some((fence, turn));
    }
    for (slot, waits) in in_flight.into_iter().enumerate() {
        let (fence, turn) = waits.unwrap();
        check(&stage, &second, slot, fence, turn);
    }

    let refused = stage.surface.set_result(&device, 0, given[0]).unwrap_err();
    assert!(matches!(refused, VulkanError::OwnResults), "{refused}");
    let refused = second.set_result(&device, 2, given[0]).unwrap_err();
    assert!(matches!(refused, VulkanError::NoSuch { number: 2, count: 2, .. }), "{refused}");
    let null = HostImage { view: vk::ImageView::null(), ..given[0] };
    let refused = second.set_result(&device, 0, null).unwrap_err();
    assert!(refused.to_string().contains("the view is the null handle"), "{refused}");
    let images = [null, null];
    let none = alone.with_results(&images);
    let refused = stage.solver.surface(&device, stage.host.allocator(), &none).unwrap_err();
    assert!(refused.to_string().contains("the view is the null handle"), "{refused}");
    let few = alone.with_results(&given[..1]);
    let refused = stage.solver.surface(&device, stage.host.allocator(), &few).unwrap_err();
    assert!(refused.to_string().contains("1 results are given for 2 slots"), "{refused}");
    // These recordings are not submitted, so each keeps one of the slot's descriptor sets in use.
    for image in [given[0], given[1], given[0]] {
        second.set_result(&device, 0, image).unwrap();
        let commands = stage.host.commands();
        stage.host.begin(commands);
        stage.solver.record(&device, commands, &second).frame(&frame(1, 0)).unwrap();
        stage.host.end(commands);
    }
    let refused = second.set_result(&device, 0, given[1]).unwrap_err();
    let in_flight = VulkanError::InputInFlight { what: "distances", number: 0 };
    assert_eq!(refused.to_string(), in_flight.to_string());

    second.destroy(&device, stage.host.allocator());
    aliases.destroy(&stage.host);
    stage.end(to.into_iter().flatten().chain([ring]));
}

/// Curves and labels in buffers of the host equal those in the library's own buffers. Once another buffer is set, they
/// are written to that buffer.
#[test]
fn curves_and_labels_go_to_buffers_of_the_hosts() {
    let mut host = Kept::watched_but_for_shaders();
    let device = host.device.clone();
    let points = host.buffer_of(&vertices(CHART, 0.4));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    let mut stage = Stage::new(host, &RASTER[2..], &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    let room = PathsInfo::new(2, 200);
    let bytes =
        [Contours::buffer_bytes(3000), Paths::buffer_bytes(room), Regions::buffer_bytes(CHART)];
    let [first, second] = [(); 2].map(|()| bytes.map(|bytes| stage.host.buffer(bytes, false)));
    let to = [(); 3].map(|()| bytes.map(|bytes| stage.host.buffer(bytes, true)));
    let curved = Wavefront::Curved;
    let (solver, surface) = (&stage.solver, &stage.surface);
    let memory = stage.host.allocator();
    let own = (
        solver.contours(&device, memory, surface, 3000).unwrap(),
        solver.paths(&device, memory, surface, room).unwrap(),
        solver.regions(&device, memory, surface, curved).unwrap(),
    );
    let [of_contours, of_paths, of_regions] = first.each_ref().map(|buffer| buffer.handle);
    let hosts = (
        solver.contours_into(&device, memory, surface, 3000, of_contours).unwrap(),
        solver.paths_into(&device, memory, surface, room, of_paths).unwrap(),
        solver.regions_into(&device, memory, surface, curved, of_regions).unwrap(),
    );
    assert!(hosts.1.bytes() == 0 && hosts.2.bytes() == 0 && hosts.0.bytes() < own.0.bytes());
    let small = stage.host.buffer(64, false);
    let memory = stage.host.allocator();
    let (solver, surface) = (&stage.solver, &stage.surface);
    for refused in [
        solver.contours_into(&device, memory, surface, 3000, small.handle).map(drop),
        solver.paths_into(&device, memory, surface, room, small.handle).map(drop),
        solver.regions_into(&device, memory, surface, curved, small.handle).map(drop),
        solver.regions_into(&device, memory, surface, curved, vk::Buffer::null()).map(drop),
    ] {
        let error = refused.unwrap_err().to_string();
        let words = ["but has", "null handle", "spans"];
        assert!(words.iter().any(|words| error.contains(words)), "{error}");
    }
    let place = source(7.25, 20.5);
    let sources = SourceInput::Inline(&place);
    let draw = |stage: &Stage, of: &(Contours, Paths, Regions), to: &[HostBuffer; 3]| {
        stage.host.run(|commands| {
            let recording = stage.solver.record(&device, commands, &stage.surface);
            recording
                .frame(
                    &Frame::new(&plan, sources, Reader::COPY).with_points(0).with_unreached(-1.0),
                )
                .unwrap();
            let (reader, before) = (Access::TRANSFER_READ, Access::NONE);
            let levels = LevelInput::Spacing { step: 3.0, count: 20 };
            let lines = ContourFrame::new(levels, reader);
            let lines = recording.contours(&of.0, &lines).unwrap();
            let starts = StartInput::Inline(&[[1.0, 2.0], [20.0, 30.5]]);
            let ways = PathFrame::new(starts, sources, reader).with_before(before);
            let ways = recording.paths(&of.1, &ways).unwrap();
            let labels = RegionFrame::new(sources, reader).with_before(before);
            let labels = recording.regions(&of.2, &labels).unwrap();
            let found = [
                (lines.buffer, u64::from(CurveRecord::BYTES)),
                (ways.buffer, 2 * u64::from(CurveRecord::BYTES)),
                (labels.buffer, labels.bytes),
            ];
            for ((from, size), to) in found.into_iter().zip(to) {
                stage.host.copy_buffer(commands, from, to, size);
            }
            found.map(|(buffer, size)| (buffer, size as usize))
        })
    };
    let expected = draw(&stage, &own, &to[0]);
    let mut hosts = hosts;
    for (turn, given) in [&first, &second].into_iter().enumerate() {
        if turn == 1 {
            let [contours, paths, regions] = given.each_ref().map(|buffer| buffer.handle);
            let (solver, surface) = (&stage.solver, &stage.surface);
            hosts.0.set_buffer(&device, solver, surface, contours).unwrap();
            hosts.1.set_buffer(&device, solver, surface, paths).unwrap();
            hosts.2.set_buffer(&device, solver, surface, regions).unwrap();
            hosts.2.set_buffer(&device, solver, surface, small.handle).unwrap_err();
        }
        let found = draw(&stage, &hosts, &to[1 + turn]);
        for (kind, (buffer, size)) in found.into_iter().enumerate() {
            assert_eq!((buffer, size), (given[kind].handle, expected[kind].1));
            let same = to[0][kind].bytes()[..size] == to[1 + turn][kind].bytes()[..size];
            assert!(same && size > 0, "{kind} of turn {turn}");
        }
    }
    let record: &CurveRecord = bytemuck::from_bytes(&to[0][0].bytes()[..36]);
    assert!(record.vertex_count > 100, "{record:?}");
    let (mut contours, mut paths, mut regions) = own;
    let (solver, surface) = (&stage.solver, &stage.surface);
    contours.set_buffer(&device, solver, surface, first[0].handle).unwrap_err();
    regions.set_buffer(&device, solver, surface, first[2].handle).unwrap_err();
    let memory = stage.host.allocator();
    for (contours, paths, regions) in
        [(&mut contours, &mut paths, &mut regions), (&mut hosts.0, &mut hosts.1, &mut hosts.2)]
    {
        contours.destroy(&device, memory);
        paths.destroy(&device, memory);
        regions.destroy(&device, memory);
    }
    let buffers = to.into_iter().flatten().chain(first).chain(second).chain([points, small]);
    stage.end(buffers);
}
