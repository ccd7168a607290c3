//! Maps that end at a radius or at targets: their distances are those of the whole map, and their work is that
//! of the area they reach.

use geosweep::cpu::{Order, RotatedScan};
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Real, Seed};
use geosweep::{Error, Stop};
use geosweep::{Engine, Options, Sources, Spacing, Surface, Targets, Wavefront, distance_map};

use crate::common::{CONVERGED, CONVERGED_F64, at, off_centre, rough};

#[test]
fn explore() {
    for (name, surface) in surfaces(400) {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let source = if name == "maze" { [0.0, 0.0] } else { [0.4*surface.rows() as f64, 0.45 * surface.cols() as f64] };
        let seeds = at(source.map(f64::floor)).seeds(&surface).unwrap();
        for wavefront in Wavefront::ALL {
            for order in [Order::Lines, Order::Patches { side: 32 }] {
                let mut solver = RotatedScan::in_order(&edges, wavefront, order);
                let c = solver.solve(&seeds, CONVERGED);
                let whole = solver.distances();
                let all = solver.visits();
                let finite = || whole.iter().copied().filter(|d| d.is_finite());
                let farthest = finite().fold(0.0, f32::max);
                for share in [0.05, 0.2, 0.5] {
                    let radius = share * f64::from(farthest);
                    let mut solver = RotatedScan::in_order(&edges, wavefront, order);
                    solver.set_radius(radius);
                    let c2 = solver.solve(&seeds, CONVERGED);
                    let near = solver.distances();
                    let inside = finite().filter(|&d| f64::from(d) <= radius).count();
                    let area = inside as f64 / finite().count() as f64;
                    let worst = near.iter().zip(&whole).map(|(n, w)| if f64::from(*w) <= radius || n.is_finite() { (n - w).abs() / w.max(1e-3) } else { 0.0 }).fold(0.0, |a: f32, b| if b.is_nan() { f32::INFINITY } else { a.max(b) });
                    println!("{name:14} {wavefront:9} {order:?} {share:4} area {area:.4} visits ratio {:.3} differ {worst:e} it {} {}", solver.visits() as f64 / all as f64 / area, c.iterations, c2.iterations);
                }
            }
        }
    }
}

fn surfaces(side: usize) -> Vec<(&'static str, Surface)> {
    let built = |builtin: Builtin, rows, cols| builtin.surface(rows, cols).unwrap();
    vec![
        ("plane", built(Builtin::Plane, side, side)),
        ("sphere", built(Builtin::Sphere, side, side)),
        ("peaks", built(Builtin::Peaks, side, side)),
        ("face", built(Builtin::Face, side, side)),
        ("maze", built(Builtin::Maze, side, side)),
        ("sheared plane", built(Builtin::ShearedPlane { degrees: 60.0 }, side, side)),
        ("rough with holes", rough(side, side, 9)),
    ]
}
