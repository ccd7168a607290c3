//! Maps in wgpu's frames equal the headless ones, and the validation layers report nothing about them. If
//! wgpu's pipelines read the map too early on purpose, the layers report this.

use std::fs;
use std::sync::Mutex;

use geosweep::accuracy::Errors;
use geosweep::glam::DVec3;
use geosweep::vulkan::embed::{Access, Reader};
use geosweep::vulkan::{HeadlessSolver, Method};
use geosweep::{DeviceChoice, Sources, Stop, Surface, Wavefront};
use log::{Level, LevelFilter, Log, Metadata, Record};
use wgpu_example::cloth::{self, CHART, STRIDE};
use wgpu_example::distance_map::{DistanceMap, MapDevice, READER};
use wgpu_example::{Renderer, open, readback, source};

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

fn renderer() -> Renderer {
    let name = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
    let flags = wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG;
    let (device, queue) = open(flags, &name).expect("ci/setup installs lavapipe");
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
        return vec4<f32>(textureLoad(distances, vec2<i32>(place.xy), 0).r, 0.0, 0.0, 1.0);
    }";

/// Returns the distances that a pipeline of wgpu samples.
fn sampled(Renderer { device, queue, map, .. }: &Renderer) -> Vec<f32> {
    let format = wgpu::TextureFormat::R32Float;
    let pipeline = cloth::render_pipeline(device, SAMPLE, format, None);
    let copy = cloth::target(device, format, [CHART.cols as u32, CHART.rows as u32]);
    let view = map.texture().create_view(&Default::default());
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
        let map = sampled(&renderer);
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
    let second = DistanceMap::new(&on, &queue, &cloth.vertices, STRIDE, CHART).unwrap();
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
    let reader = Reader { access: Access::NONE, ..READER };
    let record = |commands: &mut _| renderer.map.record_for(reader, commands, &[source(1)]);
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
    let off = geosweep::vulkan::embed::PointSource::at(0.0, 1000.0);
    let error = renderer.map.record(&mut encoder, &[off]).unwrap_err().to_string();
    assert!(error.contains("1000"), "{error}");
    assert!(renderer.map.outcome().is_err(), "no map has run");
    drop((encoder, renderer));
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
    let cases: [(&str, fn()); 5] = [
        ("the_guide_shows_the_snippet", the_guide_shows_the_snippet),
        ("frames_hold_the_headless_map", frames_hold_the_headless_map),
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
