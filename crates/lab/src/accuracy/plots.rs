//! Plots the measurements, one plot per surface.

use geosweep::Wavefront;
use geosweep::surface::builtin::Builtin;

use crate::plot::{Axis, COLORS, Color, Line, OTHERS, Plot, Series, Sheet};

use super::measure::Measurement;
use super::peers::Peer;

/// The names of the plots' files: by size and by time.
pub const FILES: [&str; 2] = ["accuracy-size.png", "accuracy-time.png"];

const COLUMNS: usize = 3;
/// The width and height of a plot. The height fits the names of all solvers.
const FRAME: [usize; 2] = [470, 520];

/// Plots the errors against the number of points per side.
pub fn by_size(measured: &[Measurement], peers: &[Peer]) -> Sheet {
    let peer_sizes = peers.iter().map(|peer| peer.points);
    let mut sizes: Vec<_> = measured.iter().map(|m| m.points).chain(peer_sizes).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let errors = |m: &Measurement| [m.errors.mean_relative, m.errors.max_relative];
    let x = Axis::at("points a side", &sizes);
    let y = Axis::decades("relative error", measured.iter().flat_map(errors).chain(means(peers)));
    let mean = Curve {
        line: Line::Solid,
        named: true,
        point: |m| [m.points as f64, m.errors.mean_relative],
    };
    let max = Curve {
        line: Line::Dashed,
        named: false,
        point: |m| [m.points as f64, m.errors.max_relative],
    };
    let key = vec![(mean.line, "mean".into()), (max.line, "largest".into())];
    let of_peer = |peer: &Peer| [peer.points as f64, peer.mean];
    sheet(measured, peers, [x, y], &[mean, max], of_peer, key)
}

/// Plots the mean error against the time.
pub fn by_time(measured: &[Measurement], peers: &[Peer]) -> Sheet {
    let seconds = |m: &Measurement| m.time.as_secs_f64();
    let x = Axis::decades(
        "solve time, seconds",
        measured.iter().map(seconds).chain(peers.iter().map(|peer| peer.seconds)),
    );
    let y = Axis::decades(
        "mean relative error",
        measured.iter().map(|m| m.errors.mean_relative).chain(means(peers)),
    );
    let curve = Curve {
        line: Line::Solid,
        named: true,
        point: |m| [m.time.as_secs_f64(), m.errors.mean_relative],
    };
    let sizes = || measured.iter().map(|m| m.points);
    let (smallest, largest) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
    let key = format!("from {smallest} to {largest} points a side");
    let key = vec![(curve.line, key)];
    sheet(measured, peers, [x, y], &[curve], |peer| [peer.seconds, peer.mean], key)
}

fn means(peers: &[Peer]) -> impl Iterator<Item = f64> {
    peers.iter().map(|peer| peer.mean)
}

fn title(builtin: Builtin) -> String {
    match builtin {
        Builtin::ShearedPlane { degrees } => format!("plane sheared by {degrees}°"),
        other => other.name().into(),
    }
}

/// Returns the colour of a wavefront, by its name.
fn color(name: &str) -> Color {
    let index = Wavefront::ALL.iter().position(|wavefront| wavefront.name() == name);
    COLORS[index.unwrap_or(Wavefront::ALL.len())]
}

/// Returns the colour and line of a solver that was measured separately. A wavefront in double precision has
/// its own colour, and all other solvers share one.
fn look(solver: &str) -> (Color, Line) {
    match solver.split_once(", double precision") {
        Some((wavefront, _)) => (color(wavefront), Line::Solid),
        None => (OTHERS, Line::Thin),
    }
}

/// The look of a series of measurements.
struct Curve {
    line: Line,
    /// Whether the name of the wavefront is written at the end of the line.
    named: bool,
    point: fn(&Measurement) -> [f64; 2],
}

/// Returns a plot for each surface. All plots have the same axes.
fn sheet(
    measured: &[Measurement],
    peers: &[Peer],
    [x, y]: [Axis; 2],
    curves: &[Curve],
    of_peer: fn(&Peer) -> [f64; 2],
    key: Vec<(Line, String)>,
) -> Sheet {
    let surfaces: Vec<_> = measured.chunk_by(|a, b| a.builtin == b.builtin).collect();
    let mut solvers: Vec<_> = peers.iter().map(|peer| &peer.solver).collect();
    solvers.dedup();
    let plot = |(index, of_surface): (usize, &&[Measurement])| {
        let (leftmost, lowest) = (index % COLUMNS == 0, index + COLUMNS >= surfaces.len());
        let of_wavefronts = of_surface.chunk_by(|a, b| a.wavefront == b.wavefront);
        let series = |of_wavefront: &[Measurement]| {
            let name = of_wavefront[0].wavefront.name();
            let series = |curve: &Curve| Series {
                label: if curve.named { name.to_owned() } else { String::new() },
                color: color(name),
                line: curve.line,
                points: of_wavefront.iter().map(curve.point).collect(),
            };
            curves.iter().map(series).collect::<Vec<_>>()
        };
        let builtin = of_surface[0].builtin;
        let of_peers = solvers.iter().map(|solver| {
            let of_solver = |peer: &&Peer| peer.builtin == builtin && peer.solver == **solver;
            let (color, line) = look(solver);
            Series {
                label: (*solver).clone(),
                color,
                line,
                points: peers.iter().filter(of_solver).map(of_peer).collect(),
            }
        });
        Plot {
            title: title(of_surface[0].builtin),
            x: x.written(lowest),
            y: y.written(leftmost),
            // Later series are drawn over earlier ones.
            series: of_peers.chain(of_wavefronts.flat_map(series)).collect(),
            slopes: None,
        }
    };
    let plots = surfaces.iter().enumerate().map(plot).collect();
    Sheet { plots, columns: COLUMNS, frame: FRAME, key }
}
