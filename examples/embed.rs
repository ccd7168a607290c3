//! geosweep inside a program that has surfaces already: many maps of one surface on one device.
//!
//! `cargo run --release --example embed`

use geosweep::cpu::Stop;
use geosweep::vulkan::{Method, Solver};
use geosweep::{DeviceChoice, Sources, Spacing, Surface, Wavefront};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (rows, cols) = (240, 320);
    let height = |index: usize| {
        let (row, col) = ((index / cols) as f64, (index % cols) as f64);
        20.0 * (row / 40.0).sin() * (col / 55.0).cos()
    };
    let heights = (0..rows * cols).map(height).collect();
    let surface = Surface::from_heights(rows, cols, heights, Spacing::square(1.0))?;

    // The device, its pipelines and the surface's edge lengths are set up once ...
    let mut solver = Solver::new(&DeviceChoice::Any)?;
    let mut on_device = solver.upload(&surface)?;
    println!("{}: {} KiB", solver.device_name(), on_device.bytes() / 1024);

    // ... and serve any number of maps.
    let stop = Stop { tolerance: 1e-6, iterations: 1000 };
    let method = Method { wavefront: Wavefront::Curved, schedule: None, stop };
    for (row, col) in [(0.0, 0.0), (120.25, 160.5), (239.0, 319.0)] {
        let seeds = Sources::point(row, col).seeds(&surface)?;
        let map = solver.solve(&mut on_device, &seeds, method)?;
        let farthest = map.distances.iter().copied().fold(0.0, f32::max);
        println!(
            "from {row},{col}: up to {farthest:.2}, {} iterations in {:.1?}",
            map.iterations, map.time
        );
    }
    Ok(())
}
