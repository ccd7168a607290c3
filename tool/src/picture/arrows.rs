//! Draws directions as colours of a wheel and as arrows.

use geosweep::{Sources, Surface};

use super::canvas::{Canvas, Color, mix};
use super::colors::{INK, UNREACHED};
use super::curves::{CurvePicture, Key, Line, Look, mark_all};
use super::raster::Paint;

/// The number of arrows along the longer side.
const ALONG: usize = 32;
/// The length of an arrow, as a fraction of the distance between arrows.
const LENGTH: f64 = 0.7;

/// A picture of the way back at each point.
pub struct Arrows<'a> {
    /// The surface on which the map was computed.
    pub surface: &'a Surface,
    /// The surface that is drawn: the same grid with positions.
    pub shape: &'a Surface,
    pub sources: &'a Sources,
    /// The distances from the sources.
    pub values: &'a [f32],
    /// The directions in rows and columns.
    pub directions: &'a [[f32; 2]],
    /// The compass bearings on the map in degrees, negative where there is none.
    pub bearings: &'a [f32],
}

impl Arrows<'_> {
    pub fn draw(&self) -> Canvas {
        let colors: Vec<Color> = self.bearings.iter().map(|&bearing| wheel(bearing)).collect();
        let (source_lines, marks) = mark_all(self.sources);
        let lines: Vec<Line> = self.arrows().into_iter().chain(source_lines).collect();
        let names = [
            "north",
            "north-east",
            "east",
            "south-east",
            "south",
            "south-west",
            "west",
            "north-west",
        ];
        let entry =
            |(eighth, name): (usize, &str)| (wheel(45.0 * eighth as f32 + 1e-3), name.into());
        let entries: Vec<(Color, String)> = names.into_iter().enumerate().map(entry).collect();
        CurvePicture {
            surface: self.surface,
            shape: self.shape,
            values: self.values,
            paint: Paint::Colors(&colors),
            lines: &lines,
            marks: &marks,
            names: &[],
            key: Key::Names { title: "way back", entries: &entries },
        }
        .draw(Look::Map)
    }

    fn arrows(&self) -> Vec<Line> {
        let chart = self.surface.chart();
        let apart = chart.rows.max(chart.cols).div_ceil(ALONG).max(1);
        let places = (apart / 2..chart.rows)
            .step_by(apart)
            .flat_map(|row| (apart / 2..chart.cols).step_by(apart).map(move |col| (row, col)));
        let arrow = |(row, col): (usize, usize)| {
            let [down, right] = self.directions[row * chart.cols + col].map(f64::from);
            // Sources and unreached points have no arrow.
            if [down, right] == [0.0; 2] || down.is_nan() {
                return None;
            }
            let half = 0.5 * LENGTH * apart as f64;
            let at = |ahead: f64, aside: f64| {
                [
                    row as f64 + half * (ahead * down - aside * right),
                    col as f64 + half * (ahead * right + aside * down),
                ]
            };
            let head = at(1.0, 0.0);
            let vertices = vec![at(-1.0, 0.0), head, at(0.4, 0.4), head, at(0.4, -0.4)];
            Some(Line { vertices, radius: 0.9, color: INK, rim: None })
        };
        places.filter_map(arrow).collect()
    }
}

/// Returns the colour of a bearing on a wheel that begins with blue in the north.
fn wheel(bearing: f32) -> Color {
    const STOPS: [Color; 4] =
        [[0.30, 0.47, 0.80], [0.93, 0.79, 0.28], [0.86, 0.36, 0.33], [0.35, 0.66, 0.42]];
    if bearing < 0.0 {
        return UNREACHED;
    }
    let quarters = bearing.rem_euclid(360.0) / 90.0;
    let (first, share) = (quarters as usize % 4, quarters.fract());
    mix(mix(STOPS[first], STOPS[(first + 1) % 4], share), [1.0; 3], 0.25)
}
