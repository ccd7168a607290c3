//! Implements `geosweep-lab figure face`: the paper's figure 7.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{Levels, PathError, PathTracer, Voronoi, contours};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{DistanceMap, Engine, Options, Sources, Surface, distance_map};

use geosweep_cli::output::{commit, done, png_output, stage_picture};
use geosweep_cli::picture::{
    Canvas, Line, Look, MapPicture, Mark, Regions, Tile, path_line, tiled,
};
use geosweep_cli::terminal::{Outcome, progress};

/// The arguments of `geosweep-lab figure face`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
}

const EXAMPLES: &str = "\
The built-in face of 21,769 points, in millimetres, with contours of the distance from
the tip of the nose, shortest paths back to it, the Voronoi diagram of 20 points, and
offset curves of two curves that are not connected. All are computed on the CPU with
the curved wavefront.

Example:
  geosweep-lab figure face -o face.png";

/// The size of the face's grid. `NOSE` is the tip of its nose.
const SIZE: [usize; 2] = [183, 155];
const NOSE: [f64; 2] = [103.0, 77.0];
/// The longer side of a panel, in pixels.
const PANEL: usize = 680;
/// The number of paths, which start around the face. `REACH` is the distance of their starts from the middle,
/// as fractions of half the grid.
const PATHS: usize = 24;
const REACH: [f64; 2] = [0.9, 0.86];
/// The number of sites of the Voronoi diagram.
const SITES: usize = 20;
/// The distance between contours. `OFFSET_STEP` is that between offset curves.
const CONTOUR_STEP: f64 = 10.0;
const OFFSET_STEP: f64 = 8.0;

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    let [rows, cols] = SIZE;
    let face = Face::new(Builtin::Face.surface(rows, cols)?)?;
    let bar = progress(4);
    let panels: [(&str, Panel); 4] = [
        ("equidistant contours", Face::contours),
        ("shortest paths", Face::paths),
        ("Voronoi diagram", Face::voronoi),
        ("offset curves", Face::offsets),
    ];
    let mut tiles = Vec::new();
    for (title, panel) in panels {
        bar.set_message(title);
        tiles.push(Tile { title: title.into(), heading: true, picture: panel(&face)? });
        bar.inc(1);
    }
    bar.finish_and_clear();
    done([], &commit([stage_picture(output, || tiled(&[tiles]))?])?);
    Ok(ExitCode::SUCCESS)
}

type Panel = fn(&Face) -> Result<Canvas, Box<dyn Error>>;

struct Face {
    surface: Surface,
    edges: EdgeLengths<f32>,
}

const LOOK: Look = Look::Space { toward: None, orientation: None, long_side: PANEL };

impl Face {
    fn new(surface: Surface) -> Result<Self, geosweep::Error> {
        let edges = EdgeLengths::new(&surface)?;
        Ok(Self { surface, edges })
    }

    fn solve(&self, sources: &Sources) -> Result<DistanceMap, geosweep::Error> {
        let options = Options::default().with_engine(Engine::Cpu);
        distance_map(&self.surface, sources, &options)
    }

    fn contours(&self) -> Result<Canvas, Box<dyn Error>> {
        let sources = Sources::point(NOSE[0], NOSE[1]);
        self.with_levels(&sources, CONTOUR_STEP, true, |_| Ok((Vec::new(), Vec::new())))
    }

    fn offsets(&self) -> Result<Canvas, Box<dyn Error>> {
        let sources = Sources::curve(brow()).and_curve(mouth(), 0.0);
        self.with_levels(&sources, OFFSET_STEP, true, |_| Ok((Vec::new(), Vec::new())))
    }

    fn paths(&self) -> Result<Canvas, Box<dyn Error>> {
        let sources = Sources::point(NOSE[0], NOSE[1]);
        let middle = SIZE.map(|points| 0.5 * (points - 1) as f64);
        let start = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / PATHS as f64).sin_cos();
            [middle[0] * (1.0 - REACH[0] * cos), middle[1] * (1.0 + REACH[1] * sin)]
        };
        let starts: Vec<_> = (0..PATHS).map(start).collect();
        self.with_levels(&sources, CONTOUR_STEP, false, |map| {
            let paths = PathTracer::new(&self.surface, &self.edges, &sources, &map.distances)?;
            let paths = paths.trace_all(&starts).into_iter();
            let paths: Vec<_> = paths.collect::<Result<_, PathError>>()?;
            Ok(paths.iter().map(path_line).unzip())
        })
    }

    /// Draws the distances with their contours, the lines and marks that `over` returns, and the sources.
    fn with_levels(
        &self,
        sources: &Sources,
        step: f64,
        plain: bool,
        over: impl FnOnce(&DistanceMap) -> Result<(Vec<Line>, Vec<Mark>), PathError>,
    ) -> Result<Canvas, Box<dyn Error>> {
        let map = self.solve(sources)?;
        let levels = Levels::Spacing(step).on(&map, sources)?;
        let picture = MapPicture {
            surface: &self.surface,
            shape: &self.surface,
            map: &map,
            sources,
            contours: &contours(&map, sources, &levels),
            plain,
            curves: over(&map)?,
            quantity: None,
        };
        Ok(picture.draw(LOOK))
    }

    fn voronoi(&self) -> Result<Canvas, Box<dyn Error>> {
        let sources = self.sites();
        let map = self.solve(&sources)?;
        let voronoi = Voronoi::new(&self.surface, &self.edges, &sources, &map.distances)?;
        let labels: Vec<_> = (0..).take(sources.iter().count()).collect();
        let regions = Regions {
            surface: &self.surface,
            shape: &self.surface,
            sources: &sources,
            labels: &labels,
            values: &map.distances,
            voronoi: &voronoi,
            areas: None,
        };
        Ok(regions.draw(LOOK))
    }

    /// Returns pseudo-random points of the surface, which are the same each time.
    fn sites(&self) -> Sources {
        let chart = self.surface.chart();
        // Knuth's linear congruential generator. Its upper bits are random enough.
        let mut state = 8u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % chart.points()
        };
        let present = std::iter::from_fn(|| Some(random()));
        let present = present.filter(|&index| self.surface.present()[index]).take(SITES);
        present.fold(Sources::default(), |sources, index| {
            let (row, col) = chart.position(index);
            sources.and_point(row as f64, col as f64, 0.0)
        })
    }
}

/// Returns a curve over both eyes.
fn brow() -> Vec<[f64; 2]> {
    let at = |k: usize| {
        let t = k as f64 / 40.0 - 0.5;
        [42.0 + 26.0 * t * t, NOSE[1] + 84.0 * t]
    };
    (0..=40).map(at).collect()
}

/// Returns a curve along the mouth.
fn mouth() -> Vec<[f64; 2]> {
    let at = |k: usize| {
        let t = k as f64 / 20.0 - 0.5;
        [127.0 - 14.0 * t * t, NOSE[1] + 40.0 * t]
    };
    (0..=20).map(at).collect()
}
