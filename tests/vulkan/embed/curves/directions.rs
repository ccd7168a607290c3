//! Directions in the host's frames.

use geosweep::Surface;
use geosweep::geometry::BackDirections;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::embed::{
    self, Access, DirectionFrame, PointSource, Reader, ResultImage, SourceInput,
};

use super::Scene;
use crate::common::closed::flat;
use crate::common::rough;
use crate::embed::stage::{Kept, on_cpu, sources_at as at};

/// Directions in columns and rows, and the bytes of the image.
pub struct Field {
    pub ways: Vec<[f32; 2]>,
    bytes: Vec<u8>,
}

impl Scene {
    /// Returns the bytes of an image that a recording leaves for a copy.
    pub fn copy_of(
        &mut self,
        texel: u64,
        record: impl FnOnce(embed::Recording) -> ResultImage,
    ) -> Vec<u8> {
        let host = &mut self.stage.host;
        let device = host.device.clone();
        let copy = host.buffer(texel * self.stage.surface.chart().points() as u64, true);
        let (solver, surface) = (&self.stage.solver, &self.stage.surface);
        host.run(|commands| {
            let recording = solver.record(&device, commands, surface);
            recording.begin(Access::NONE);
            let image = record(recording);
            host.copy_image(commands, image, &copy);
        });
        let bytes = copy.bytes()[..texel as usize * surface.chart().points()].to_vec();
        host.free(copy);
        bytes
    }

    pub fn directions(&mut self, directions: &embed::Directions, sources: SourceInput) -> Field {
        let frame = DirectionFrame::new(sources, Reader::COPY);
        let bytes = self.copy_of(4, |recording| {
            let image = recording.directions(directions, &frame).unwrap();
            assert_eq!(image, directions.image(Reader::COPY.layout));
            image
        });
        let half = |bytes: &[u8]| from_half(u16::from_ne_bytes([bytes[0], bytes[1]]));
        let ways = bytes.chunks_exact(4).map(|of| [half(&of[..2]), half(&of[2..])]).collect();
        Field { ways, bytes }
    }

    pub fn new_directions(&mut self) -> embed::Directions {
        let stage = &mut self.stage;
        let device = stage.host.device.clone();
        let allocator = stage.host.allocator();
        let new = stage.solver.directions(&device, allocator, &stage.surface).unwrap();
        let stated = stage.solver.bytes_for_directions(&device, stage.surface.chart());
        assert_eq!(stated.unwrap(), new.bytes());
        new
    }
}

fn from_half(bits: u16) -> f32 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023) / 1024.0);
    sign * match exponent {
        0 => fraction * 2f32.powi(-14),
        _ => (1.0 + fraction) * 2f32.powi(exponent - 15),
    }
}

/// Compares directions with those of the CPU on the same map. Returns the mean angle in the grid, and how
/// many directions in 10 000 are off by more than a tenth of a radian and by more than 90 degrees.
fn compare(name: &str, surface: &Surface, sources: &[PointSource]) -> [f64; 3] {
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), surface, sources);
    let mut directions = scene.new_directions();
    let field = scene.directions(&directions, SourceInput::Inline(sources));
    // A second recording gives the same directions.
    let again = scene.directions(&directions, SourceInput::Inline(sources));
    assert_eq!(again.bytes, field.bytes, "{name}");
    let edges = EdgeLengths::new(surface).unwrap();
    let exact =
        BackDirections::new(surface, &edges, &on_cpu(sources), &scene.map.distances).unwrap();
    let (mut sum, mut count, mut largest) = (0.0, 0usize, 0.0f64);
    let (mut off, mut wrong) = (0usize, 0usize);
    for (index, (way, exact)) in field.ways.iter().zip(exact.in_chart()).enumerate() {
        let [col, row] = way.map(f64::from);
        let [exact_row, exact_col] = exact.map(f64::from);
        if !(exact_row != 0.0 || exact_col != 0.0) || exact_row.is_nan() {
            assert_eq!([row, col], [0.0; 2], "{name} at {:?}", surface.chart().position(index));
            continue;
        }
        let length = row.hypot(col);
        assert!((length - 1.0).abs() < 1e-3, "{name}: {way:?} at {index}");
        let cosine = (row * exact_row + col * exact_col) / length;
        let angle = (row * exact_col - col * exact_row).atan2(row * exact_row + col * exact_col);
        sum += angle.abs();
        count += 1;
        largest = largest.max(angle.abs());
        off += usize::from(angle.abs() > 0.1);
        wrong += usize::from(cosine < 0.0);
    }
    let mean = sum / count as f64;
    println!("{name}: mean {mean:.1e}, largest {largest:.1e}, {off} and {wrong} off of {count}");
    scene.end_with(|device, allocator| directions.destroy(device, allocator));
    let share = |number: usize| 1e4 * number as f64 / count as f64;
    [mean, share(off), share(wrong)]
}

/// The bound is 1e-3 rad, of which rounding to half precision is up to 5e-4.
#[test]
fn directions_are_those_of_the_cpu() {
    let flat = flat(65, 81);
    let mut later = at(&[[10.5, 12.25], [40.0, 50.75]]);
    later[0].time = 10.0;
    let cases = [
        ("plane", flat.clone(), at(&[[20.0, 30.0]])),
        ("plane, between points", flat.clone(), at(&[[20.25, 30.75]])),
        ("plane, three sources", flat.clone(), at(&[[10.0, 12.5], [50.0, 20.0], [52.0, 21.0]])),
        ("plane, one later", flat, later),
        ("sphere", Builtin::Sphere.surface(65, 65).unwrap(), at(&[[20.0, 30.0]])),
        (
            "sheared",
            Builtin::ShearedPlane { degrees: 50.0 }.surface(65, 49).unwrap(),
            at(&[[20.0, 30.5]]),
        ),
        ("maze", Builtin::Maze.surface(101, 101).unwrap(), at(&[[0.0, 0.0]])),
    ];
    for (name, surface, sources) in &cases {
        let [mean, off, wrong] = compare(name, surface, sources);
        assert!(mean < 1e-3 && off < 20.0 && wrong == 0.0, "{name}: {mean} {off} {wrong}");
    }
}

/// Even where the grid does not resolve the surface, few directions differ from those of the CPU.
#[test]
fn directions_on_rough_surfaces_are_those_of_the_cpu() {
    for one_hole_in in [0, 11] {
        let surface = rough(61, 83, one_hole_in);
        let [mean, off, wrong] = compare("rough", &surface, &at(&[[30.0, 41.0]]));
        assert!(mean < 2e-2 && off < 400.0 && wrong < 20.0, "{mean} {off} {wrong}");
    }
}

/// A render graph may provide another image in each frame.
#[test]
fn directions_go_to_the_image_of_the_host() {
    let flat = flat(33, 41);
    let sources = at(&[[7.0, 9.5]]);
    let mut scene = Scene::new(Kept::watched(), &flat, &sources);
    let mut own = scene.new_directions();
    let expected = scene.directions(&own, SourceInput::Inline(&sources));
    let device = scene.stage.host.device.clone();
    // Two more directions lend their images.
    let lenders = [scene.new_directions(), scene.new_directions()];
    let [first, second] = lenders.each_ref().map(|of| {
        let image = of.image(Reader::COPY.layout);
        embed::HostImage { image: image.image, view: image.view }
    });
    let stage = &mut scene.stage;
    let made = stage.solver.directions_into(&device, stage.host.allocator(), &stage.surface, first);
    let mut hosts = made.unwrap();
    assert!(hosts.bytes() < own.bytes());
    for image in [first, second] {
        hosts.set_image(image).unwrap();
        assert_eq!(hosts.image(Reader::COPY.layout).image, image.image);
        assert_eq!(scene.directions(&hosts, SourceInput::Inline(&sources)).bytes, expected.bytes);
    }
    hosts.destroy(&device, scene.stage.host.allocator());
    for mut lender in lenders {
        lender.destroy(&device, scene.stage.host.allocator());
    }
    scene.end_with(|device, allocator| own.destroy(device, allocator));
}
