//! Largest amount of the machine's memory that maps take, as the operating system counts it.

use geosweep::Stop;
use geosweep::cpu::RotatedScan;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, Method};
use geosweep::{DeviceChoice, Sources, Surface, Wavefront};

use crate::ALONE;

const STOP: Stop = Stop::within(1e-6).or_after(100);

/// Returns the bytes in memory, at present (`VmRSS`) or at most so far (`VmHWM`).
fn resident(field: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(':'));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")).expect("in KiB");
    1024.0 * kib.trim().parse::<f64>().unwrap()
}

/// Returns by how many bytes per point a process grows at most during `work`, for `points` points.
fn growth<T>(points: usize, work: impl FnOnce() -> T) -> f64 {
    std::fs::write("/proc/self/clear_refs", "5").expect("Linux resets the largest size so");
    let before = resident("VmRSS");
    let result = work();
    let grown = resident("VmHWM") - before;
    drop(result);
    grown / points as f64
}

fn map_on_cpu(surface: &Surface, wavefront: Wavefront) -> f64 {
    let seeds = Sources::point(0.0, 0.0).seeds(surface).unwrap();
    growth(surface.chart().points(), || {
        let edges = EdgeLengths::<f32>::new(surface).unwrap();
        let mut solver = RotatedScan::new(&edges, wavefront);
        // The first map keeps memory that makes further ones faster, so a second one is measured.
        solver.solve(&seeds, STOP);
        solver.solve(&seeds, STOP);
    })
}

/// The bytes are in addition to the surface itself. They include what measuring its edges and its curvature
/// takes.
#[test]
fn the_cpu_takes_at_most_forty_bytes_a_point() {
    // Arrays of this size do not come from freed memory on the heap.
    const POINTS: usize = 3000;
    let _alone = ALONE.lock();
    let surface = Builtin::Sphere.surface(POINTS, POINTS).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        map_on_cpu(&Builtin::Sphere.surface(50, 50).unwrap(), wavefront);
        let bytes = map_on_cpu(&surface, wavefront);
        println!("{wavefront}: {bytes:.1} bytes a point");
        // At least four edges and two copies of arrival times must show, or the measurement sees nothing.
        assert!((23.0..40.0).contains(&bytes), "{wavefront}: {bytes}");
    }
}

/// The bytes are in addition to the surface and the map, which are uploaded and downloaded. With drivers on
/// the processor, device memory is the machine's.
#[test]
fn a_device_takes_at_most_forty_eight_bytes_a_point() {
    // Maps of this size are large compared with the memory that a driver takes for shaders.
    const POINTS: usize = 1800;
    let _alone = ALONE.lock();
    let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
    let mut solver = HeadlessSolver::new(&DeviceChoice::Name(device)).unwrap();
    let mut map = |surface: &Surface| {
        let seeds = Sources::point(0.0, 0.0).seeds(surface).unwrap();
        let method = Method::new(Wavefront::Curved, STOP);
        growth(surface.chart().points(), || {
            let mut on_device = solver.upload(surface).unwrap();
            solver.solve(&mut on_device, &seeds, method).unwrap()
        })
    };
    map(&Builtin::Sphere.surface(50, 50).unwrap());
    let with_map = map(&Builtin::Sphere.surface(POINTS, POINTS).unwrap());
    let bytes = with_map - size_of::<f32>() as f64;
    println!("{bytes:.1} bytes a point");
    assert!(bytes < 48.0, "{bytes}");
}
