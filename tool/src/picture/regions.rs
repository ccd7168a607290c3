//! Draws Voronoi regions.

use geosweep::geometry::{Border, NO_REGION, Voronoi};
use geosweep::{Sources, Surface};

use super::canvas::Canvas;
use super::colors::{INK, UNREACHED, region_colors};
use super::curves::{CurvePicture, Key, Line, Look, mark_all, number_all};
use super::legend::number;
use super::raster::Paint;

/// A picture of regions in different colours, with borders and sources.
pub struct Regions<'a> {
    /// The surface on which the map was computed.
    pub surface: &'a Surface,
    /// The grid with positions.
    pub shape: &'a Surface,
    pub sources: &'a Sources,
    /// The label of each region.
    pub labels: &'a [i32],
    /// The distances from the sources.
    pub values: &'a [f32],
    pub voronoi: &'a Voronoi,
    /// The regions' areas and their unit, if a legend is drawn.
    pub areas: Option<(&'a [f64], Option<&'a str>)>,
}

impl Regions<'_> {
    pub fn draw(&self, look: Look) -> Canvas {
        let voronoi = self.voronoi;
        let palette = region_colors(voronoi.regions(), &voronoi.neighbours());
        let color = |&label: &u32| match label {
            NO_REGION => UNREACHED,
            label => palette[label as usize],
        };
        let colors: Vec<_> = voronoi.labels.iter().map(color).collect();
        let border = |border: &Border| Line {
            vertices: border.curve.points().collect(),
            radius: 1.2,
            color: INK,
            rim: None,
        };
        let (source_lines, marks) = mark_all(self.sources);
        let lines: Vec<_> = voronoi.borders.iter().map(border).chain(source_lines).collect();
        // Several sources of one region have no numbers of their own.
        let is_numbered = self.areas.is_some() && self.sources.iter().count() == self.labels.len();
        let names = if is_numbered { number_all(self.sources) } else { Vec::new() };
        let (areas, unit) = self.areas.unwrap_or_default();
        let whole: f64 = areas.iter().sum();
        let entry = |(index, area): (usize, &f64)| {
            let share = if whole > 0.0 { 100.0 * area / whole } else { 0.0 };
            (palette[index], format!("{}: {} ({share:.1} %)", self.labels[index], number(*area)))
        };
        let entries: Vec<_> = areas.iter().enumerate().map(entry).collect();
        let title = match unit {
            Some(unit) => format!("area ({unit}²)"),
            None => "area".into(),
        };
        CurvePicture {
            surface: self.surface,
            shape: self.shape,
            values: self.values,
            paint: Paint::Colors(&colors),
            lines: &lines,
            marks: &marks,
            names: &names,
            key: match self.areas {
                Some(_) => Key::Names { title: &title, entries: &entries },
                None => Key::Nothing,
            },
        }
        .draw(look)
    }
}
