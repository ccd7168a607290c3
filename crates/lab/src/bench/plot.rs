//! Plots time against the number of points, one plot per surface and wavefront.

use crate::plot::{Axis, COLORS, Line, Plot, Series, Sheet, Slopes};

use super::measure::{Method, Timing};

const COLUMNS: usize = 3;
const FRAME: [usize; 2] = [430, 340];

/// Returns the plots. Timings of the same surface and wavefront must be consecutive.
pub fn by_points(timings: &[Timing], methods: &[Method]) -> Sheet {
    let x = Axis::decades("points", timings.iter().map(|timing| timing.points as f64));
    let y = Axis::decades("seconds for a map", timings.iter().map(Timing::median));
    let groups: Vec<_> =
        timings.chunk_by(|a, b| a.surface == b.surface && a.wavefront == b.wavefront).collect();
    let columns = COLUMNS.min(groups.len()).max(1);
    let plot = |(index, maps): (usize, &&[Timing])| {
        let (leftmost, lowest) = (index % columns == 0, index + columns >= groups.len());
        let series = |(index, &method): (usize, &Method)| Series {
            label: match method {
                Method::Vulkan(schedule) => schedule.name().into(),
                other => other.engine().into(),
            },
            color: COLORS[index % COLORS.len()],
            line: Line::Solid,
            points: maps
                .iter()
                .filter(|map| map.method == method)
                .map(|map| [map.points as f64, map.median()])
                .collect(),
        };
        let name = maps[0].surface.to_string();
        Plot {
            title: format!("{name}, {}", maps[0].wavefront.name()),
            x: x.written(lowest),
            y: y.written(leftmost),
            series: methods.iter().enumerate().map(series).collect(),
            slopes: (index == 0).then(|| Slopes {
                from: [0.62, 0.05],
                width: 0.24,
                powers: vec![(1.0, "linear")],
            }),
        }
    };
    let plots = groups.iter().enumerate().map(plot).collect();
    Sheet { plots, columns, frame: FRAME, key: Vec::new() }
}
