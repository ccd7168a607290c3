//! What the figures and the accuracy report share: what is measured, against what.

use std::time::Duration;

use geosweep::accuracy::Errors;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Real, SurfaceError};
use geosweep::{
    DistanceMap, Error, Options, Report, Sources, Surface, Wavefront, distance_map,
    distance_map_f64,
};
use indicatif::{ProgressBar, ProgressStyle};

use crate::precision::Precision;

/// A square grid on a built-in surface, with a source and the distances from it.
pub struct Problem {
    pub surface: Surface,
    pub source: [f64; 2],
    pub reference: Vec<f64>,
}

impl Problem {
    /// The source lies at a fraction of the rows and of the columns, at the nearest point.
    pub fn new(builtin: Builtin, points: usize, source: [f64; 2]) -> Result<Self, SurfaceError> {
        let surface = builtin.surface(points, points)?;
        let source = source.map(|fraction| (fraction * (points - 1) as f64).round());
        let reference = builtin.reference_distances(points, points, source);
        Ok(Self { surface, source, reference })
    }

    pub fn point_source(&self) -> Sources {
        Sources::point(self.source[0], self.source[1])
    }

    /// Computes the map from some sources: how, and how far it is from the reference.
    pub fn solve(
        &self,
        sources: &Sources,
        options: &Options,
        precision: Precision,
    ) -> Result<(Report, Errors), Error> {
        Ok(match precision {
            Precision::Single => self.compare(distance_map(&self.surface, sources, options)?),
            Precision::Double => self.compare(distance_map_f64(&self.surface, sources, options)?),
        })
    }

    fn compare<R: Real>(&self, map: DistanceMap<R>) -> (Report, Errors) {
        (map.report, Errors::of(&map.distances, &self.reference))
    }
}

/// Points a side, as an argument.
pub fn size(text: &str) -> Result<usize, String> {
    const RANGE: std::ops::RangeInclusive<usize> = 2..=16384;
    match text.trim().parse() {
        Ok(size) if RANGE.contains(&size) => Ok(size),
        _ => Err(format!(
            "`{text}` is no number of points a side from {} to {}",
            RANGE.start(),
            RANGE.end()
        )),
    }
}

/// Sizes in order, each once.
pub fn ascending(sizes: &[usize]) -> Vec<usize> {
    let mut sizes = sizes.to_vec();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// A wavefront's name, as an argument.
pub fn wavefront(text: &str) -> Result<Wavefront, String> {
    let found = Wavefront::EVERY.into_iter().find(|wavefront| wavefront.name() == text.trim());
    found.ok_or_else(|| format!("no wavefront is called `{text}`; there are {}", wavefront_names()))
}

/// All wavefronts' names, for help and messages.
pub fn wavefront_names() -> String {
    Wavefront::EVERY.map(Wavefront::name).join(", ")
}

/// What was asked for, each once, or else the default.
pub fn or_else<T: Clone + PartialEq>(asked: &[T], default: impl FnOnce() -> Vec<T>) -> Vec<T> {
    let mut unique = if asked.is_empty() { default() } else { Vec::new() };
    for one in asked {
        if !unique.contains(one) {
            unique.push(one.clone());
        }
    }
    unique
}

/// A wavefront's name in a figure.
pub fn label(wavefront: Wavefront) -> &'static str {
    match wavefront {
        Wavefront::PointSource => "point-source",
        other => other.name(),
    }
}

/// A bar on a terminal, and nothing elsewhere.
pub fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_msg} {bar:30} {pos}/{len}")
        .expect("the template is part of the program");
    let bar = ProgressBar::new(steps as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
