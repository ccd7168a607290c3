//! Maps in wgpu's frames equal the headless ones, and the validation layers report nothing about them. If
//! wgpu's pipelines read the map too early on purpose, the layers report this.

use std::fs;
use std::sync::Mutex;

use geosweep_wgpu::geosweep::accuracy::Errors;
use geosweep_wgpu::geosweep::glam::DVec3;
use geosweep_wgpu::geosweep::surface::{Chart, Gluing};
use geosweep_wgpu::geosweep::vulkan::embed::Reader;
use geosweep_wgpu::geosweep::vulkan::{HeadlessSolver, Method};
use geosweep_wgpu::geosweep::{DeviceChoice, Sources, Stop, Surface, Wavefront};
use geosweep_wgpu::{DistanceMap, LevelInput, MapDevice, MapFrame, MapInfo, PointSource};
use log::{Level, LevelFilter, Log, Metadata, Record};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

#[path = "../examples/cloth/cloth.rs"]
mod cloth;
#[path = "../examples/cloth/readback.rs"]
mod readback;
#[path = "../examples/cloth/renderer.rs"]
mod renderer;

use cloth::{CHART, STRIDE};
use renderer::{Renderer, open, source};

mod snippet {
    // docs/wgpu.md contains this module.
    include!("snippet.rs");
}

/// Messages of the layers, which reach a program through the crate `log`.
struct Messages(Mutex<Vec<String>>);

/// Message of older layers about shaders that name WGSL as their source language, as wgpu's do.
const IS_IN_WGSL: &str = "Invalid source language operand: 10";

static MESSAGES: Messages = Messages(Mutex::new(Vec::new()));

impl Log for Messages {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        let message = record.args().to_string();
        // Messages of loaders, of drivers and of the layers' own set-up are not findings.
        let is_finding = self.enabled(record.metadata())
            && message.starts_with("VALIDATION [")
            && ![IS_IN_WGSL, "VALIDATION-SETTINGS"].iter().any(|known| message.contains(known));
        if is_finding {
            eprintln!("{message}");
            self.0.lock().unwrap().push(message);
        }
    }

    fn flush(&self) {}
}

fn messages() -> Vec<String> {
    std::mem::take(&mut MESSAGES.0.lock().unwrap())
}

fn device() -> (wgpu::Device, wgpu::Queue) {
    let name = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
    let flags = wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG;
    open(flags, &name).expect("ci/setup installs lavapipe")
}

fn renderer() -> Renderer {
    let (device, queue) = device();
    Renderer::new(device, queue).unwrap()
}

/// Shaders that write one texel for each texel of the map.
const SAMPLE: &str = "
    @group(0) @binding(0) var distances: texture_2d<f32>;

    @vertex
    fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
        return vec4<f32>(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u), 0.0, 1.0);
    }

    @fragment
    fn fragment(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
        return vec4<f32>(CHANNEL(textureLoad(distances, vec2<i32>(place.xy), 0)), 0.0, 0.0, 1.0);
    }

    fn first(texel: vec4<f32>) -> f32 { return texel.r; }
    fn size(texel: vec4<f32>) -> f32 { return length(texel.rg); }";

/// Returns a number of each texel that a pipeline of wgpu samples: the first, or the length of the first two.
fn sampled(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    texture: &wgpu::Texture,
    channel: &str,
) -> Vec<f32> {
    let format = wgpu::TextureFormat::R32Float;
    let shader = SAMPLE.replace("CHANNEL", channel);
    let pipeline = cloth::render_pipeline(device, &shader, format, None);
    let copy = cloth::target(device, format, [texture.width(), texture.height()]);
    let view = texture.create_view(&Default::default());
    let layout = pipeline.get_bind_group_layout(0);
    let resource = wgpu::BindingResource::TextureView(&view);
    let group = cloth::bind_group(device, &layout, [resource]);
    let mut encoder = device.create_command_encoder(&Default::default());
    let view = copy.create_view(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(cloth::attachment(&view, wgpu::Color::BLACK))],
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    queue.submit([encoder.finish()]);
    floats(&readback::texels(device, queue, &copy).unwrap())
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|four| f32::from_ne_bytes(four.try_into().unwrap())).collect()
}

/// Returns the map of the current vertices from the headless engine.
fn headless(Renderer { device, queue, cloth, .. }: &Renderer, frame: u32) -> Vec<f64> {
    let vertices = floats(&readback::bytes(device, queue, &cloth.vertices).unwrap());
    let position = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    let positions = vertices.chunks(STRIDE as usize / 4).map(position).collect();
    let surface = Surface::from_positions(CHART.rows, CHART.cols, positions).unwrap();
    let from = source(frame);
    let seeds = Sources::point(from.row.into(), from.col.into()).seeds(&surface).unwrap();
    let name = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
    let mut solver = HeadlessSolver::new(&DeviceChoice::Name(name)).unwrap();
    let mut on_device = solver.upload(&surface).unwrap();
    let stop = Stop::within(1e-6).or_after(1000);
    let method = Method::new(Wavefront::Curved, stop);
    let solution = solver.solve(&mut on_device, &seeds, method).unwrap();
    solution.distances.into_iter().map(f64::from).collect()
}

/// The program does not wait between frames. After the first and the last of them, the map is the headless one.
fn frames_hold_the_headless_map() {
    let renderer = renderer();
    for last in [0, 5] {
        for number in last.min(1)..=last {
            renderer.frame(number).unwrap();
        }
        let map = sampled((&renderer.device, &renderer.queue), renderer.map.texture(), "first");
        let outcome = renderer.map.outcome().unwrap();
        assert!(outcome.converged && outcome.passed_over == 0, "{outcome:?}");
        let found = Errors::of(&map, &headless(&renderer, last));
        assert_eq!(found.reached_by_one, 0);
        // Rounding, as docs/embedding.md states for all recorded maps.
        assert!(found.max_of_largest < 1e-5, "frame {last}: {}", found.max_of_largest);
    }
    let picture = readback::texels(&renderer.device, &renderer.queue, &renderer.picture).unwrap();
    let mut colours: Vec<_> = picture.chunks(4).collect();
    colours.sort_unstable();
    colours.dedup();
    assert!(colours.len() > 200, "a picture of {} colours", colours.len());
    drop(renderer);
    assert_eq!(messages(), Vec::<String>::new());
}

/// A map is dropped while a frame is in flight, before its image is released and before the device is dropped.
/// Another map is dropped after the device.
fn a_map_goes_at_any_time() {
    let Renderer { device, queue, cloth, map, picture, .. } = {
        let renderer = renderer();
        renderer.frame(1).unwrap();
        renderer
    };
    let kept = map.texture().clone();
    drop(map);
    // The image exists for those who still hold it.
    let on = MapDevice::new(&device).unwrap();
    let info = MapInfo::new(&cloth.vertices, STRIDE, CHART);
    let second = DistanceMap::new(&on, &queue, &info).unwrap();
    drop(on);
    let colours = cloth.colours(&device, &kept);
    let mut drawing = device.create_command_encoder(&Default::default());
    cloth.draw(&mut drawing, &colours, &picture.create_view(&Default::default()));
    queue.submit([drawing.finish()]);
    drop((kept, colours, cloth, picture, queue, device));
    // The second map alone now keeps the device alive.
    drop(second);
    assert_eq!(messages(), Vec::<String>::new());
}

/// The guide contains the code that compiles here.
fn the_guide_shows_the_snippet() {
    let guide = include_str!("../../../docs/wgpu.md");
    let block = format!("```rust\n{}```", include_str!("snippet.rs"));
    assert!(guide.contains(&block), "copy tests/snippet.rs into docs/wgpu.md");
    let _ = (snippet::load, snippet::frame);
}

/// A recording that does not name wgpu's shaders as readers is reported, so that the silence of the layers in the
/// other tests means something.
fn a_reader_that_is_not_waited_for_is_reported() {
    let renderer = renderer();
    let reader = Reader::OTHER_QUEUE;
    let sources = [source(1)];
    let record = |commands: &mut _| {
        Ok(renderer.map.record_for(reader, commands, &MapFrame::new(&sources))?)
    };
    renderer.frame_with(1, record).unwrap();
    drop(renderer);
    let said = messages();
    assert!(
        said.iter().any(|message| message.contains("SYNC-HAZARD-READ-AFTER-WRITE")),
        "{said:?}"
    );
}

/// Refused sources record nothing.
fn a_source_off_the_grid_is_an_error() {
    let renderer = renderer();
    let mut encoder = renderer.device.create_command_encoder(&Default::default());
    let off = [PointSource::at(0.0, 1000.0)];
    let error = renderer.map.record(&mut encoder, &MapFrame::new(&off)).unwrap_err().to_string();
    assert!(error.contains("1000"), "{error}");
    assert!(renderer.map.outcome().is_err(), "no map has run");
    drop((encoder, renderer));
    assert_eq!(messages(), Vec::<String>::new());
}

/// A tube of a length of 40 around an axis, with radius 5. Its last column repeats the first one.
const TUBE: Chart = Chart { rows: 41, cols: 65 };

fn tube(device: &wgpu::Device) -> wgpu::Buffer {
    let vertex = |index: usize| {
        let (row, col) = (index / TUBE.cols, index % TUBE.cols % (TUBE.cols - 1));
        let angle = std::f32::consts::TAU * col as f32 / (TUBE.cols - 1) as f32;
        [5.0 * angle.cos(), 5.0 * angle.sin(), row as f32, 0.0]
    };
    let vertices: Vec<_> = (0..TUBE.points()).flat_map(vertex).collect();
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some("tube"),
        contents: bytemuck::cast_slice(&vertices),
        usage: wgpu::BufferUsages::STORAGE,
    })
}

/// Returns the distance on the tube from the source in the middle of row 20 at column 4.
fn on_tube(row: usize, col: usize) -> f32 {
    let around = (col as f32 - 4.0).rem_euclid(64.0);
    let arc = 5.0 * std::f32::consts::TAU / 64.0 * around.min(64.0 - around);
    arc.hypot(row as f32 - 20.0)
}

/// All outputs of a glued map, within a radius, beside a map of another surface in the same recording. Their values are
/// those of a tube, which can be unrolled.
fn outputs_of_several_maps_are_those_of_their_surfaces() {
    let (device, queue) = device();
    let (vertices, cloth) = (tube(&device), cloth::Cloth::new(&device));
    let (on, gluing) = (MapDevice::new(&device).unwrap(), Gluing::columns());
    let info = MapInfo::new(&vertices, 16, TUBE).with_gluing(&gluing);
    let info = info.with_contours(20_000).with_regions().with_directions();
    let map = DistanceMap::new(&on, &queue, &info).unwrap();
    let flat = MapInfo::new(&cloth.vertices, STRIDE, CHART).with_log_map();
    let other = DistanceMap::new(&on, &queue, &flat).unwrap();
    let mut moving = device.create_command_encoder(&Default::default());
    cloth.move_to(&queue, &mut moving, 0.0);
    for radius in [12.0_f32, 6.5] {
        let sources = [PointSource::at(20.0, 4.0)];
        let frame = MapFrame::new(&sources)
            .within(radius)
            .with_levels(LevelInput::Spacing { step: 2.0, count: 10 });
        let mut mapping = device.create_command_encoder(&Default::default());
        let of_cloth = [source(0)];
        on.record(&mut mapping, &[(&other, MapFrame::new(&of_cloth)), (&map, frame)]).unwrap();
        let moved =
            std::mem::replace(&mut moving, device.create_command_encoder(&Default::default()));
        queue.submit([moved.finish(), mapping.finish()]);

        let read = |texture: &wgpu::Texture, channel| sampled((&device, &queue), texture, channel);
        let distances = read(map.texture(), "first");
        let ways = read(map.directions().unwrap(), "size");
        let labels = readback::bytes(&device, &queue, map.regions().unwrap()).unwrap();
        let mut reached = 0;
        for (index, &distance) in distances.iter().enumerate() {
            let (row, col) = (index / TUBE.cols, index % TUBE.cols);
            let truth = on_tube(row, col);
            // Arcs through 64 points of a circle are exact to the fourth order in a tenth.
            let exact_to = 2e-3 * radius;
            if (truth - radius).abs() < exact_to {
                continue;
            }
            let label = u32::from_ne_bytes(labels[4 * index..][..4].try_into().unwrap());
            let at = format!("row {row}, column {col}, radius {radius}");
            if truth > radius {
                assert_eq!((distance, label), (-1.0, u32::MAX), "{at}");
                continue;
            }
            reached += 1;
            assert_eq!(label, 0, "{at}");
            assert!((distance - truth).abs() < exact_to, "{at}: {distance} {truth}");
            // Directions have half precision.
            assert!(truth == 0.0 || (ways[index] - 1.0).abs() < 2e-3, "{at}: {}", ways[index]);
        }
        // The area of a disc of 6.5 in cells of 1 by 0.49 is 270.
        assert!(reached > 250, "{reached} points");
        let (contours, offset) = map.contours().unwrap();
        let contours = readback::bytes(&device, &queue, contours).unwrap();
        let count = u32::from_ne_bytes(contours[..4].try_into().unwrap()) as usize;
        let vertices = floats(&contours[offset as usize..][..24 * count]);
        assert!(count > 100, "{count} vertices");
        for vertex in vertices.chunks(6) {
            let step = vertex[3] / 2.0;
            assert!((step - step.round()).abs() < 1e-4 && vertex[3] <= radius, "{vertex:?}");
        }
        assert!(map.outcome().unwrap().converged);
        // A place of the log map is as far from the origin as its point from the source.
        let distances = read(other.texture(), "first");
        for (log, distance) in read(other.log_map().unwrap(), "size").iter().zip(distances) {
            assert!((0.0..200.0).contains(&distance), "{distance}");
            assert!((log - distance).abs() <= 1e-3 * distance, "{log} {distance}");
        }
    }
    drop((map, other));
    assert_eq!(messages(), Vec::<String>::new());
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    // Older layers compare submissions with one another only on request. Newer ones check the accesses of shaders
    // only on request.
    let settings = "khronos_validation.enables = \
         VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT,\
         VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT\n\
         khronos_validation.validate_sync = true\n\
         khronos_validation.syncval_submit_time_validation = true\n\
         khronos_validation.syncval_shader_accesses_heuristic = true\n";
    fs::write(folder.path().join("vk_layer_settings.txt"), settings).unwrap();
    // SAFETY: there is no other thread yet.
    unsafe { std::env::set_var("VK_LAYER_SETTINGS_PATH", folder.path()) };
    log::set_logger(&MESSAGES).unwrap();
    log::set_max_level(LevelFilter::Warn);
    let cases: [(&str, fn()); 6] = [
        ("the_guide_shows_the_snippet", the_guide_shows_the_snippet),
        ("frames_hold_the_headless_map", frames_hold_the_headless_map),
        (
            "outputs_of_several_maps_are_those_of_their_surfaces",
            outputs_of_several_maps_are_those_of_their_surfaces,
        ),
        ("a_map_goes_at_any_time", a_map_goes_at_any_time),
        (
            "a_reader_that_is_not_waited_for_is_reported",
            a_reader_that_is_not_waited_for_is_reported,
        ),
        ("a_source_off_the_grid_is_an_error", a_source_off_the_grid_is_an_error),
    ];
    for (name, case) in cases {
        case();
        println!("test {name} ... ok");
    }
}
