//! Puts sources on the surface, and decides what becomes of those that do not lie on it.

use std::error::Error;
use std::fmt::Display;
use std::path::Path;

use clap::ValueEnum;
use geosweep::Sources;
use geosweep::geometry::NO_SOURCE;
use geosweep::io::{Misplaced, PlacedCurve, PlacedPoint, misplaced};
use geosweep::surface::SourceError;

use super::Scene;
use super::sources::GivenSources;
use crate::terminal::counted;

/// The treatment of sources that lie outside the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Outside {
    /// They are an error, which names the first of them
    #[default]
    Refuse,
    /// They are left out, and a note tells how many there are
    Skip,
    /// Points are moved to the nearest point of the surface, and a note tells how many there are
    Snap,
}

/// Sources on the surface's grid, as they are placed one after another.
pub struct Placing<'a> {
    scene: &'a Scene,
    outside: Outside,
    sources: Sources,
    labels: Vec<Option<i32>>,
    are_polygons: bool,
    refused: Vec<Misplaced>,
    skipped: usize,
    snapped: usize,
}

impl<'a> Placing<'a> {
    pub fn new(scene: &'a Scene, outside: Outside) -> Self {
        Self {
            scene,
            outside,
            sources: Sources::default(),
            labels: Vec::new(),
            are_polygons: true,
            refused: Vec::new(),
            skipped: 0,
            snapped: 0,
        }
    }

    /// Adds a point of the command line. `at` is its row and column on the given grid.
    pub fn point(
        &mut self,
        at: Result<[f64; 2], Misplaced>,
        start: f64,
        name: impl Fn() -> String,
    ) {
        self.put(at.map(|at| PlacedPoint { at, start, value: None }), start, name);
    }

    /// Adds a point of a file.
    pub fn file_point(&mut self, path: &Path, point: Result<PlacedPoint, Misplaced>) {
        let name = |at: [f64; 2]| format!("{}: the source {},{}", path.display(), at[0], at[1]);
        let at = point.as_ref().map_or([f64::NAN; 2], |point| point.at);
        let start = point.as_ref().map_or(0.0, |point| point.start);
        let point = point.map_err(|missed| named(path, missed));
        self.put(point, start, || name(at));
    }

    /// Adds a curve of a file.
    pub fn curve(
        &mut self,
        path: &Path,
        curve: Result<PlacedCurve, Misplaced>,
    ) -> Result<(), String> {
        match curve {
            Ok(PlacedCurve { vertices, start, value, is_ring }) => match vertices[..] {
                [at] => self.file_point(path, Ok(PlacedPoint { at, start, value })),
                _ => {
                    let vertices = self.scene.curve(vertices);
                    let vertices = vertices.map_err(|why| format!("{}: {why}", path.display()))?;
                    self.add(None, is_ring, |sources| sources.and_curve(vertices, start));
                }
            },
            Err(missed) => self.file_point(path, Err(missed)),
        }
        Ok(())
    }

    /// Returns the sources, and prints notes on those that were moved or left out.
    ///
    /// # Errors
    /// If sources lie outside the surface and are not to be moved or left out, or if none is left.
    pub fn sources(self) -> Result<GivenSources, Box<dyn Error>> {
        if !self.refused.is_empty() {
            let said = misplaced(&self.refused.iter().collect::<Vec<_>>());
            let remedy = match self.outside {
                Outside::Snap => "only points can be moved; --sources-outside skip leaves them out",
                _ => {
                    "--sources-outside skip leaves such sources out, and snap moves points to the surface"
                }
            };
            return Err(format!("{said}; {remedy}").into());
        }
        let sources = |count| counted(count, "source");
        if self.skipped > 0 {
            note!("{} outside the surface left out", sources(self.skipped as u64));
        }
        if self.snapped > 0 {
            note!("{} moved to the nearest point of the surface", sources(self.snapped as u64));
        }
        if self.skipped > 0 && self.labels.is_empty() {
            return Err("no source lies on the surface, so nothing is left".into());
        }
        let are_polygons = self.are_polygons && !self.labels.is_empty();
        // In outputs, this number means that there is no source.
        let labels = self.labels.into_iter().collect::<Option<Vec<_>>>();
        let labels = labels.filter(|labels| !labels.contains(&NO_SOURCE));
        Ok(GivenSources { sources: self.sources, are_polygons, labels })
    }

    fn put(
        &mut self,
        point: Result<PlacedPoint, Misplaced>,
        start: f64,
        name: impl Fn() -> String,
    ) {
        let value = point.as_ref().ok().and_then(|point| point.value);
        let placed = point.and_then(|point| self.on_surface(point.at, &name));
        let at = match (placed, self.outside) {
            (Ok(at), _) => at,
            (Err(_), Outside::Skip) => {
                self.skipped += 1;
                return;
            }
            (Err(missed), Outside::Snap) => {
                match missed.near.and_then(|near| self.scene.snapped(near)) {
                    Some(at) => {
                        self.snapped += 1;
                        at
                    }
                    None => return self.refused.push(missed),
                }
            }
            (Err(missed), Outside::Refuse) => return self.refused.push(missed),
        };
        let label = value.filter(|value| value.fract() == 0.0).map(|value| value as i32);
        let label = label.filter(|&label| Some(f64::from(label)) == value);
        self.add(label, false, |sources| sources.and_point(at[0], at[1], start));
    }

    /// Converts a given place to a place on the surface's grid, which must not be a hole.
    fn on_surface(
        &self,
        given: [f64; 2],
        name: impl Fn() -> String,
    ) -> Result<[f64; 2], Misplaced> {
        let missed = |reason: String| Misplaced { reason, near: Some(given) };
        let [row, col] = self.scene.place(given).map_err(|why| missed(format!("source {why}")))?;
        let surface = &self.scene.surface;
        let hole = || {
            missed(format!("{} lies in a hole of the surface (NaN, no-data or masked out)", name()))
        };
        let (last_row, last_col) = surface.chart().last();
        let is_point =
            |at: f64, last: usize| at.fract() == 0.0 && (0.0..=last as f64).contains(&at);
        // Rasters may have a million sources, all at grid points.
        if is_point(row, last_row) && is_point(col, last_col) {
            let is_there = surface.has(row as usize, col as usize);
            return if is_there { Ok([row, col]) } else { Err(hole()) };
        }
        match Sources::point(row, col).seeds(surface) {
            Ok(_) => Ok([row, col]),
            Err(SourceError::Hole { .. }) => Err(hole()),
            Err(SourceError::Outside { .. }) => Err(missed(format!(
                "{} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}",
                name()
            ))),
            Err(error) => Err(missed(format!("{}: {error}", name()))),
        }
    }

    fn add(&mut self, label: Option<i32>, is_ring: bool, add: impl FnOnce(Sources) -> Sources) {
        self.sources = add(std::mem::take(&mut self.sources));
        self.labels.push(label);
        self.are_polygons &= is_ring;
    }
}

/// Returns a misplaced point with the name of its file.
fn named(path: impl AsRef<Path>, missed: Misplaced) -> Misplaced {
    let name: &dyn Display = &path.as_ref().display();
    Misplaced { reason: format!("{name}: {}", missed.reason), ..missed }
}
