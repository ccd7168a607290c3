//! Contours and paths drawn in the frame that finds them, from inputs that the host's own passes write.

use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    Access, ContourFrame, Frame, LevelInput, PathFrame, PathsInfo, PointKind, PointMemory, Points,
    Reader, SourceBuffer, SourceInput, StartInput, SurfaceInfo,
};
use geosweep::{Spacing, Wavefront};

use crate::embed::stage::{RASTER, Stage};
use crate::host::{Canvas, Host, layers_version};

const CHART: Chart = Chart { rows: 65, cols: 65 };
const SIDE: u32 = 256;

/// Writes heights, a source and starts.
const WRITE: &str = "
    @group(0) @binding(0) var<storage, read_write> heights: array<f32>;
    @group(0) @binding(1) var<storage, read_write> sources: array<vec4<f32>>;
    @group(0) @binding(2) var<storage, read_write> starts: array<vec2<f32>>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x < 4225u) { heights[id.x] = 3.0; }
        if (id.x == 0u) {
            sources[0] = vec4<f32>(32.0, 32.0, 0.0, 1e18);
            starts[0] = vec2<f32>(2.0, 6.0);
            starts[1] = vec2<f32>(60.5, 50.25);
        }
    }";

/// Draws lines by x and y.
const DRAW: &str = "
    @group(0) @binding(0) var<storage, read> side: array<f32>;
    @vertex
    fn vertex(@location(0) position: vec3<f32>, @location(1) time: f32,
              @location(2) place: vec2<f32>) -> @builtin(position) vec4<f32> {
        let same = abs(position.z - 3.0) < 1e-5 && all(abs(place.yx - position.xy) < vec2(1e-4));
        let depth = select(2.0, 0.5, same && time >= 0.0);
        return vec4<f32>(2.0 * position.xy / side[0] - 1.0, depth, 1.0);
    }
    @fragment
    fn fragment() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }";

/// The results of a frame with all passes that is drawn twice: the places of the pixels of contours and of paths, in
/// grid steps, and the messages of the validation layers.
struct Drawn {
    contours: Vec<[f64; 2]>,
    paths: Vec<[f64; 2]>,
    messages: Vec<String>,
}

fn lit(picture: &[u8]) -> Vec<[f64; 2]> {
    let lit = (0..SIDE * SIDE).filter(|&pixel| picture[4 * pixel as usize] > 128);
    let place = |x: u32| (f64::from(x) + 0.5) * 64.0 / f64::from(SIDE);
    lit.map(|pixel| [place(pixel / SIDE), place(pixel % SIDE)]).collect()
}

fn draw(reader: Access) -> Drawn {
    let mut host = Host::with_synchronization_validation();
    let device = host.device.clone();
    let heights = host.buffer(4 * CHART.points() as u64, false);
    let (sources, starts) = (host.buffer(16, false), host.buffer(16, false));
    let side = host.buffer_of(&[64.0]);
    let write = host.pass(WRITE, &[heights.handle, sources.handle, starts.handle], None);
    let size = vk::Extent2D { width: SIDE, height: SIDE };
    let canvases: [Canvas; 2] = std::array::from_fn(|_| {
        host.canvas(size, vk::Format::R8G8B8A8_UNORM, vk::Format::D32_SFLOAT)
    });
    let topologies = [vk::PrimitiveTopology::LINE_LIST, vk::PrimitiveTopology::LINE_STRIP];
    let [list, strip] =
        [0, 1].map(|k| host.curve_pass(DRAW, &[side.handle], &canvases[k], topologies[k]));
    let pictures: [_; 2] =
        std::array::from_fn(|_| host.buffer(4 * u64::from(SIDE) * u64::from(SIDE), true));

    let memory = PointMemory::Buffer { buffer: heights.handle, offset: 0, stride: 4 };
    let kind = PointKind::Heights(Spacing::square(1.0));
    let source_buffers = [SourceBuffer { buffer: sources.handle, offset: 0, count: 1 }];
    let inputs = [Points { memory, kind, slowness: None }];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&source_buffers);
    let mut stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 6);
    let (solver, surface) = (&stage.solver, &stage.surface);
    let allocator = stage.host.allocator.as_mut().unwrap();
    let mut contours = solver.contours(&device, allocator, surface, 4000).unwrap();
    let info = PathsInfo::new(2, 200);
    let mut paths = solver.paths(&device, allocator, surface, info).unwrap();

    let host = &stage.host;
    let record = |commands| {
        let recording = solver.record(&device, commands, surface);
        for _ in 0..2 {
            // After this barrier, the recordings no longer read the three inputs. They have read them in compute
            // passes, and in the copy of the starts.
            host.barrier(
                commands,
                Access::COMPUTE_READ.and(Access::TRANSFER_READ),
                Access::COMPUTE_WRITE,
            );
            host.dispatch(commands, &write, CHART.points().div_ceil(64) as u32);
            let frame = Frame::new(&plan, SourceInput::Buffer(0), Reader::FRAGMENT)
                .with_before(Access::COMPUTE_WRITE)
                .with_points(0)
                .with_unreached(-1.0);
            recording.frame(&frame).unwrap();
            let levels = LevelInput::List(&[10.0, 30.0]);
            let frame = ContourFrame::new(levels, reader);
            let found = recording.contours(&contours, &frame).unwrap();
            host.draw_curves(commands, &list, &canvases[0], found);
            let frame = PathFrame::new(
                StartInput::Buffer { buffer: starts.handle, offset: 0, count: 2 },
                SourceInput::Buffer(0),
                reader,
            )
            .with_before(Access::COMPUTE_WRITE);
            let found = recording.paths(&paths, &frame).unwrap();
            host.draw_curves(commands, &strip, &canvases[1], found);
        }
        for (canvas, picture) in canvases.iter().zip(&pictures) {
            host.copy_canvas(commands, canvas, picture);
        }
    };
    // A GPU may draw with a count that is not written yet, and hang. The layers report the hazard while it is
    // recorded.
    if reader == Access::DRAW || host.is_processor() {
        host.run(record)
    } else {
        host.discard(record)
    }
    let [lit_contours, lit_paths] = [0, 1].map(|k| lit(pictures[k].bytes()));
    contours.destroy(&device, stage.host.allocator());
    paths.destroy(&device, stage.host.allocator());
    for pass in [write, list, strip] {
        stage.host.destroy_pass(pass);
    }
    canvases.into_iter().for_each(|canvas| stage.host.free_canvas(canvas));
    let messages = stage.take_down(pictures.into_iter().chain([heights, sources, starts, side]));
    Drawn { contours: lit_contours, paths: lit_paths, messages }
}

/// Lines are a pixel wide, which is a quarter of a grid step.
#[test]
fn curves_are_drawn_where_they_are_without_a_message() {
    let drawn = draw(Access::DRAW);
    assert_eq!(drawn.messages, Vec::<String>::new());
    let away = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let centre = [32.0, 32.0];
    for &pixel in &drawn.contours {
        let radius = away(pixel, centre);
        assert!((radius - 10.0).abs().min((radius - 30.0).abs()) < 0.4, "{pixel:?}");
    }
    // Both circles have a pixel for each quarter of a step along the axis along which they advance more, and some
    // more pixels where pieces meet.
    let around = 8.0 * f64::sqrt(0.5) * (10.0 + 30.0) * 4.0;
    let count = drawn.contours.len() as f64;
    assert!((0.95..1.3).contains(&(count / around)), "{count} {around}");
    // naga turns pictures upside down, so that rows may count in either direction.
    let ends = [[2.0, 6.0], [60.5, 50.25]];
    let ends = ends.map(|end: [f64; 2]| [end, [64.0 - end[0], end[1]]]);
    let off = |pixel: [f64; 2], end: [f64; 2]| {
        let (along, to) = ([end[0] - 32.0, end[1] - 32.0], [pixel[0] - 32.0, pixel[1] - 32.0]);
        let length = along[0].hypot(along[1]);
        let share = (along[0] * to[0] + along[1] * to[1]) / (length * length);
        let inside = share.clamp(0.0, 1.0);
        away(pixel, [0, 1].map(|k| 32.0 + inside * along[k]))
    };
    let flip = drawn.paths.iter().any(|&pixel| ends.iter().all(|end| off(pixel, end[0]) > 0.4));
    for &pixel in &drawn.paths {
        let nearest = ends.iter().map(|end| off(pixel, end[usize::from(flip)]));
        assert!(nearest.fold(f64::INFINITY, f64::min) < 0.4, "{pixel:?}");
    }
    // Paths of 30 and 28.5 rows, and some more pixels where pieces meet.
    assert!((230..330).contains(&drawn.paths.len()), "{}", drawn.paths.len());
}

/// A hazard must be reported, or a clean log would prove nothing. Each draw is tested separately, since newer
/// layers report only one hazard of a draw.
#[test]
fn a_reader_of_curves_that_is_not_named_is_reported() {
    let vertices = vk::AccessFlags::VERTEX_ATTRIBUTE_READ;
    let indirect = vk::AccessFlags::INDIRECT_COMMAND_READ;
    let stages = vk::PipelineStageFlags::VERTEX_INPUT | vk::PipelineStageFlags::DRAW_INDIRECT;
    // Layers 1.3.239 check the vertices of an indirect draw. Layers 1.4.309 do not, since they do not know the
    // number of vertices. Layers 1.3.275 (Ubuntu 24.04), whose version lies between, report neither hazard.
    let version = layers_version();
    let tells_of_vertices = version < vk::make_api_version(0, 1, 3, 240);
    let tells_of_indirect = tells_of_vertices || version >= vk::make_api_version(0, 1, 4, 0);
    let cases =
        [("indirect", vertices, tells_of_indirect), ("vertex", indirect, tells_of_vertices)];
    for (what, named, is_told) in cases {
        let messages = draw(Access::new(stages, named)).messages;
        let is_hazard = |message: &String| {
            let by = [format!("for {what}"), format!("reads {what}")];
            message.contains("READ_AFTER_WRITE") && by.iter().any(|by| message.contains(by))
        };
        assert!(messages.iter().all(is_hazard), "{what}: {messages:?}");
        assert!(!is_told || !messages.is_empty(), "{what}: nothing is reported");
    }
}
