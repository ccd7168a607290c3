//! Draws plots with logarithmic axes, side by side on a sheet. Lines are labelled at their ends.

use geosweep::glam::Vec2;

pub use geosweep_cli::picture::canvas::Color;
use geosweep_cli::picture::canvas::{Canvas, mix};
use geosweep_cli::picture::colors::{INK, PAPER};
use geosweep_cli::picture::text::Pen;

/// Plots in rows, from left to right.
pub struct Sheet {
    pub plots: Vec<Plot>,
    pub columns: usize,
    /// The width and height of a plot's frame, in pixels.
    pub frame: [usize; 2],
    /// The key: styles of lines, and what each of them means.
    pub key: Vec<(Line, String)>,
}

/// One frame with its axes.
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub slopes: Option<Slopes>,
}

/// A logarithmic axis.
#[derive(Clone)]
pub struct Axis {
    /// The title of the axis. It is empty if a neighbouring plot shows it.
    pub title: String,
    pub low: f64,
    pub high: f64,
    pub ticks: Vec<(f64, String)>,
    /// Whether ticks have labels. They have none if a neighbouring plot has the same ticks.
    pub labelled: bool,
}

/// A line through measured points.
pub struct Series {
    /// The label at the end of the line, unless empty.
    pub label: String,
    pub color: Color,
    pub line: Line,
    /// The points. Only positive values are drawn.
    pub points: Vec<[f64; 2]>,
}

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Line {
    Solid,
    /// A thinner line without marks.
    Dashed,
    /// A thinner line with small marks.
    Thin,
}

/// Light reference lines from one point. On each of them, y is proportional to a power of x.
#[derive(Clone)]
pub struct Slopes {
    /// The common start, as fractions of the frame rightwards and upwards.
    pub from: [f32; 2],
    /// The extent of the lines along the x axis, as a fraction of the frame's width.
    pub width: f32,
    /// The powers, each with its name.
    pub powers: Vec<(f32, &'static str)>,
}

/// Colours that people with any type of colour vision can distinguish (Okabe and Ito 2008). They are dark enough for
/// text on white.
pub const COLORS: [Color; 6] = [
    rgb(0x00_62_9b),
    rgb(0xc8_50_00),
    rgb(0x00_86_62),
    rgb(0xb0_5a_8c),
    rgb(0x8a_6d_00),
    rgb(0x33_33_33),
];

const fn rgb(hex: u32) -> Color {
    [(hex >> 16) as u8 as f32 / 255.0, (hex >> 8) as u8 as f32 / 255.0, hex as u8 as f32 / 255.0]
}

const GRID: Color = [0.9, 0.9, 0.9];
const AXIS: Color = [0.45, 0.45, 0.45];
/// The colour of other solvers, for comparison.
pub const OTHERS: Color = [0.55, 0.55, 0.55];
/// The colour of reference slopes and their names.
const LIGHT: Color = [0.62, 0.62, 0.62];

/// The size of text in pixels. Sheets are about 1900 pixels wide and shown at half size.
const TEXT: f32 = 28.0;
const TITLE: f32 = 31.0;
/// The gap between related elements.
const NEAR: f32 = 12.0;
const LINE_HEIGHT: f32 = 1.2 * TEXT;
/// The height of the title and the name of the y axis above a frame.
const HEADER: f32 = 2.6 * TITLE;
/// The distance from the end of a line to its label.
const LEADER: f32 = 26.0;
const MARGIN: f32 = 28.0;

impl Axis {
    /// Returns an axis with ticks at powers of ten over the positive values. If there are fewer than two, ticks at 2
    /// and 5 times powers of ten are added.
    pub fn decades(title: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|&value| value > 0.0)
            .fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low / 1.5, high * 1.5) } else { (0.1, 10.0) };
        let powers = |factor: f64| {
            let first = (low / factor).log10().ceil() as i32;
            let last = (high / factor).log10().floor() as i32;
            (first..=last).map(move |power| (factor * 10f64.powi(power), power_text(factor, power)))
        };
        let mut ticks: Vec<_> = powers(1.0).collect();
        if ticks.len() < 2 {
            ticks.extend(powers(2.0).chain(powers(5.0)));
            ticks.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { title: title.into(), low, high, ticks, labelled: true }
    }

    /// Returns a copy of the axis with labels at its ticks, or without labels and title for a plot whose neighbour
    /// shows them.
    pub fn written(&self, labelled: bool) -> Self {
        let title = if labelled { self.title.clone() } else { String::new() };
        Self { title, labelled, ..self.clone() }
    }

    /// Returns an axis with ticks at the given values, each labelled with its value.
    pub fn at(title: &str, values: &[usize]) -> Self {
        let ends = values.iter().fold((usize::MAX, 0), |(a, b), &n| (a.min(n), b.max(n)));
        let ticks = values.iter().map(|&value| (value as f64, value.to_string())).collect();
        let (low, high) = (ends.0 as f64 / 1.25, ends.1 as f64 * 1.25);
        Self { title: title.into(), low, high, ticks, labelled: true }
    }

    /// Returns the position of a value on the axis, from 0 to 1.
    fn fraction(&self, value: f64) -> f32 {
        (value / self.low).ln() as f32 / self.span()
    }

    /// Returns the natural logarithm of the ratio of both ends.
    fn span(&self) -> f32 {
        (self.high / self.low).ln() as f32
    }
}

/// Formats a power of ten as `2×10⁻³`, or as `10⁻³` for a factor of 1.
fn power_text(factor: f64, power: i32) -> String {
    let superscript = |digit: char| match digit {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹']
            [digit.to_digit(10).unwrap_or_default() as usize],
    };
    let power: String = power.to_string().chars().map(superscript).collect();
    if factor == 1.0 { format!("10{power}") } else { format!("{factor}×10{power}") }
}

/// The pens of a sheet.
struct Pens {
    text: Pen,
    title: Pen,
}

/// A plot's frame on the sheet.
struct Frame<'a> {
    plot: &'a Plot,
    origin: Vec2,
    size: Vec2,
}

/// The space before and after the frames of a row or column.
#[derive(Clone, Copy, Default)]
struct Margins {
    before: f32,
    after: f32,
}

impl Sheet {
    pub fn draw(&self) -> Canvas {
        let pens = Pens { text: Pen::new(TEXT), title: Pen::bold(TITLE) };
        let size = Vec2::new(self.frame[0] as f32, self.frame[1] as f32);
        let columns: Vec<_> = (0..self.columns.min(self.plots.len()))
            .map(|column| self.column_margins(column, &pens))
            .collect();
        let rows: Vec<_> = self.plots.chunks(self.columns).map(row_margins).collect();
        let extent = |margins: &[Margins], frame: f32| {
            margins.iter().map(|m| m.before + frame + m.after).sum::<f32>() + 2.0 * MARGIN
        };
        let key_height = if self.key.is_empty() { 0.0 } else { 1.5 * LINE_HEIGHT };
        let (width, height) = (extent(&columns, size.x), extent(&rows, size.y) + key_height);
        let mut canvas = Canvas::new(width.ceil() as usize, height.ceil() as usize, PAPER);
        for (index, plot) in self.plots.iter().enumerate() {
            let (row, column) = (index / self.columns, index % self.columns);
            let start = |margins: &[Margins], at: usize, frame: f32| {
                let passed: f32 = margins[..at].iter().map(|m| m.before + frame + m.after).sum();
                (MARGIN + passed + margins[at].before).round()
            };
            let origin = Vec2::new(start(&columns, column, size.x), start(&rows, row, size.y));
            Frame { plot, origin, size }.draw(&mut canvas, &pens);
        }
        let left = MARGIN + columns.first().map_or(0.0, |margins| margins.before);
        self.draw_key(&mut canvas, Vec2::new(left, height - MARGIN - 0.5 * LINE_HEIGHT), &pens);
        canvas
    }

    fn column_margins(&self, column: usize, pens: &Pens) -> Margins {
        let plots = || self.plots.iter().skip(column).step_by(self.columns);
        let ticks = plots().filter(|plot| plot.y.labelled).flat_map(|plot| &plot.y.ticks);
        let labels = plots().flat_map(|plot| &plot.series).map(|series| &series.label);
        let widest = |texts: &mut dyn Iterator<Item = &'_ String>| {
            texts.map(|text| pens.text.width(text)).fold(0.0, f32::max)
        };
        Margins {
            before: widest(&mut ticks.map(|(_, text)| text)) + NEAR,
            after: LEADER + NEAR + widest(&mut labels.into_iter()) + 2.0 * NEAR,
        }
    }

    fn draw_key(&self, canvas: &mut Canvas, mut at: Vec2, pens: &Pens) {
        const SAMPLE: f32 = 80.0;
        for (line, text) in &self.key {
            let ends = [at, at + Vec2::new(SAMPLE, 0.0)];
            line.draw(canvas, &ends, AXIS);
            at.x += SAMPLE + NEAR;
            pens.text.write(canvas, at.x, at.y, text, INK);
            at.x += pens.text.width(text) + 4.0 * NEAR;
        }
    }
}

fn row_margins(plots: &[Plot]) -> Margins {
    let lines = |plot: &Plot| {
        f32::from(u8::from(plot.x.labelled)) + f32::from(u8::from(!plot.x.title.is_empty()))
    };
    let below = plots.iter().map(lines).fold(0.0, f32::max);
    Margins { before: HEADER, after: below * LINE_HEIGHT + 3.0 * NEAR }
}

impl Frame<'_> {
    fn draw(&self, canvas: &mut Canvas, pens: &Pens) {
        self.draw_header(canvas, pens);
        self.draw_axes(canvas, pens);
        if let Some(slopes) = &self.plot.slopes {
            self.draw_slopes(canvas, pens, slopes);
        }
        for series in &self.plot.series {
            series.line.draw(canvas, &self.pixels(series), series.color);
        }
        self.draw_labels(canvas, pens);
    }

    fn pixel(&self, [x, y]: [f64; 2]) -> Vec2 {
        let (x, y) = (self.plot.x.fraction(x), self.plot.y.fraction(y));
        self.origin + self.size * Vec2::new(x, 1.0 - y)
    }

    fn pixels(&self, series: &Series) -> Vec<Vec2> {
        let visible = series.points.iter().filter(|[x, y]| *x > 0.0 && *y > 0.0);
        visible.map(|point| self.pixel(*point)).collect()
    }

    fn draw_header(&self, canvas: &mut Canvas, pens: &Pens) {
        let Plot { title, y, .. } = self.plot;
        let top = self.origin.y - HEADER;
        pens.title.write(canvas, self.origin.x, top + 0.5 * TITLE, title, INK);
        pens.text.write(canvas, self.origin.x, top + 1.8 * TITLE, &y.title, AXIS);
    }

    fn draw_axes(&self, canvas: &mut Canvas, pens: &Pens) {
        let (low, high) = (self.origin, self.origin + self.size);
        for (value, _) in &self.plot.y.ticks {
            let y = self.pixel([self.plot.x.low, *value]).y;
            canvas.stroke(Vec2::new(low.x, y), Vec2::new(high.x, y), 0.7, GRID);
        }
        for (value, _) in &self.plot.x.ticks {
            let x = self.pixel([*value, self.plot.y.low]).x;
            canvas.stroke(Vec2::new(x, low.y), Vec2::new(x, high.y), 0.7, GRID);
        }
        let corner = Vec2::new(low.x, high.y);
        canvas.stroke(corner, Vec2::new(low.x, low.y), 1.0, AXIS);
        canvas.stroke(corner, high, 1.0, AXIS);

        let Plot { x, y, .. } = self.plot;
        if y.labelled {
            let labels = y
                .ticks
                .iter()
                .map(|(value, text)| (self.pixel([x.low, *value]).y, LINE_HEIGHT, text));
            for (at, _, text) in sparse(labels.collect()) {
                pens.text.write(canvas, low.x - NEAR - pens.text.width(text), at, text, INK);
            }
        }
        let mut below = high.y + NEAR + 0.5 * LINE_HEIGHT;
        if x.labelled {
            let labels = x.ticks.iter().map(|(value, text)| {
                (self.pixel([*value, y.low]).x, pens.text.width(text) + NEAR, text)
            });
            for (at, _, text) in sparse(labels.collect()) {
                pens.text.write(canvas, at - 0.5 * pens.text.width(text), below, text, INK);
            }
            below += LINE_HEIGHT;
        }
        let middle = low.x + 0.5 * (self.size.x - pens.text.width(&x.title));
        pens.text.write(canvas, middle, below, &x.title, AXIS);
    }

    fn draw_slopes(&self, canvas: &mut Canvas, pens: &Pens, slopes: &Slopes) {
        let [right, up] = slopes.from;
        let from = self.origin + self.size * Vec2::new(right, 1.0 - up);
        // The pixels per factor of e along both axes.
        let scale = self.size / Vec2::new(self.plot.x.span(), self.plot.y.span());
        let width = slopes.width * self.size.x;
        for (power, name) in &slopes.powers {
            let to = from + width * Vec2::new(1.0, -power * scale.y / scale.x);
            canvas.stroke(from, to, 1.2, LIGHT);
            pens.text.write(canvas, to.x + 0.5 * NEAR, to.y, name, LIGHT);
        }
    }

    /// Draws the names of the lines to the right of the frame, without overlaps. A thin line connects each
    /// name with the end of its line.
    fn draw_labels(&self, canvas: &mut Canvas, pens: &Pens) {
        let named = self.plot.series.iter().filter(|series| !series.label.is_empty());
        let mut ends: Vec<_> =
            named.filter_map(|series| Some((series, *self.pixels(series).last()?))).collect();
        ends.sort_by(|(_, a), (_, b)| a.y.total_cmp(&b.y));
        let wanted: Vec<_> = ends.iter().map(|(_, end)| end.y).collect();
        let right = self.origin.x + self.size.x;
        // Names may take the height from the line of the title down to the labels of the ticks.
        let room = [self.origin.y - HEADER + 0.5 * TITLE, self.origin.y + self.size.y];
        let places = within(apart(&wanted, LINE_HEIGHT), room, LINE_HEIGHT);
        for ((series, end), y) in ends.into_iter().zip(places) {
            let from = end + Vec2::new(NEAR, 0.0);
            let light = mix(PAPER, series.color, 0.5);
            canvas.stroke(from, Vec2::new(right + LEADER, y), 0.8, light);
            pens.text.write(canvas, right + LEADER + 0.5 * NEAR, y, &series.label, series.color);
        }
    }
}

impl Line {
    fn draw(self, canvas: &mut Canvas, points: &[Vec2], color: Color) {
        // A dash of length `on` starts at every multiple of `period` along the line.
        let (radius, on, period) = match self {
            Self::Solid => (2.2, f32::MAX, f32::MAX),
            Self::Dashed => (1.3, 13.0, 22.0),
            Self::Thin => (1.1, f32::MAX, f32::MAX),
        };
        let mut start = 0.0;
        for ends in points.windows(2) {
            let end = start + ends[0].distance(ends[1]);
            let at = |along: f32| ends[0].lerp(ends[1], (along - start) / (end - start));
            let mut dash = (start / period).floor() * period;
            while dash < end {
                let (from, to) = (dash.max(start), (dash + on).min(end));
                if from <= to {
                    canvas.stroke(at(from), at(to), radius, color);
                }
                dash += period;
            }
            start = end;
        }
        let mark = match self {
            Self::Solid => 5.0,
            Self::Dashed => return,
            Self::Thin => 3.5,
        };
        for point in points {
            canvas.stroke(*point, *point, mark + 1.5, PAPER);
            canvas.stroke(*point, *point, mark, color);
        }
    }
}

/// Returns as many labels as fit without overlap, at regular intervals and including the last one. Each label
/// has its middle and its extent along the axis.
fn sparse<T>(labels: Vec<(f32, f32, T)>) -> Vec<(f32, f32, T)> {
    let last = labels.len().saturating_sub(1);
    let taken = |index: usize, every: usize| (last - index).is_multiple_of(every);
    let touch = |a: &(f32, f32, T), b: &(f32, f32, T)| (a.0 - b.0).abs() < 0.5 * (a.1 + b.1);
    let fits = |every: &usize| {
        (*every..=last)
            .filter(|&index| taken(index, *every))
            .all(|index| !touch(&labels[index - every], &labels[index]))
    };
    let every = (1..=last).find(fits).unwrap_or(last + 1);
    let indexed = labels.into_iter().enumerate();
    indexed.filter(|(index, _)| taken(*index, every)).map(|(_, label)| label).collect()
}

/// Returns positions that are at least `gap` apart and as close as possible to the wanted ones, in the same order, by
/// least squares (the algorithm "pool adjacent violators"). `wanted` must be ascending.
fn apart(wanted: &[f32], gap: f32) -> Vec<f32> {
    // After subtracting the gaps, positions only need to be ascending. Runs that are not ascending are replaced by
    // their mean.
    let mut runs: Vec<(f32, usize)> = Vec::new();
    for (index, place) in wanted.iter().enumerate() {
        let mut run = (place - index as f32 * gap, 1);
        while let Some(&(before, count)) = runs.last().filter(|(before, _)| *before >= run.0) {
            let sum = before * count as f32 + run.0 * run.1 as f32;
            run = (sum / (count + run.1) as f32, count + run.1);
            runs.pop();
        }
        runs.push(run);
    }
    let places = runs.into_iter().flat_map(|(place, count)| std::iter::repeat_n(place, count));
    places.enumerate().map(|(index, place)| place + index as f32 * gap).collect()
}

/// Moves positions into a range, as far as they all fit into it.
fn within(places: Vec<f32>, [low, high]: [f32; 2], gap: f32) -> Vec<f32> {
    let last = places.len().saturating_sub(1);
    let moved = |(index, place): (usize, f32)| {
        place.min(high - (last - index) as f32 * gap).max(low + index as f32 * gap)
    };
    places.into_iter().enumerate().map(moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_their_distance_and_their_order() {
        assert_eq!(apart(&[0.0, 100.0], 10.0), [0.0, 100.0]);
        assert_eq!(apart(&[50.0, 50.0, 50.0], 10.0), [40.0, 50.0, 60.0]);
        assert_eq!(apart(&[0.0, 4.0, 100.0], 10.0), [-3.0, 7.0, 100.0]);
        assert_eq!(apart(&[], 10.0), [0.0; 0]);
    }

    #[test]
    fn labels_stay_in_their_range_as_far_as_there_is_room() {
        assert_eq!(within(vec![-8.0, 50.0, 99.0], [0.0, 90.0], 10.0), [0.0, 50.0, 90.0]);
        assert_eq!(within(vec![70.0, 80.0, 90.0], [0.0, 80.0], 10.0), [60.0, 70.0, 80.0]);
        assert_eq!(within(vec![0.0, 10.0, 20.0], [0.0, 15.0], 10.0), [0.0, 10.0, 20.0]);
    }

    #[test]
    fn labels_that_touch_are_thinned_out_regularly() {
        let kept = |count: usize, extent: f32| {
            let labels = (0..count).map(|k| (10.0 * k as f32, extent, k)).collect();
            sparse(labels).into_iter().map(|(_, _, k)| k).collect::<Vec<_>>()
        };
        assert_eq!(kept(4, 10.0), [0, 1, 2, 3]);
        assert_eq!(kept(7, 20.0), [0, 2, 4, 6]);
        assert_eq!(kept(6, 20.0), [1, 3, 5]);
        assert_eq!(kept(3, 50.0), [2]);
        assert_eq!(kept(1, 50.0), [0]);
        assert_eq!(kept(0, 50.0), [0; 0]);
    }

    #[test]
    fn ticks_are_powers_of_ten_or_between_them() {
        let texts = |values: [f64; 2]| {
            let axis = Axis::decades("", values.into_iter());
            axis.ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts([2e-4, 3e-2]), ["10⁻³", "10⁻²"]);
        assert_eq!(texts([2e-3, 5e-3]), ["2×10⁻³", "5×10⁻³"]);
        assert_eq!(texts([0.0, 0.0]), ["10⁻¹", "10⁰", "10¹"]);
    }
}
