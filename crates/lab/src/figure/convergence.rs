//! Implements `geosweep-lab figure convergence`: the paper's figure 5, with more accurate wavefronts beside it.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::Stop;
use geosweep::accuracy::{Errors, exact_disc};
use geosweep::cpu::raster_scan;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Options, Sources, Wavefront};
use serde::Serialize;

use crate::lists;
use crate::plot::{Axis, COLORS, Color, Line, Plot, Series, Sheet, Slopes};
use crate::reference::Reference;
use geosweep_cli::output::{commit, done, png_output, stage_picture, wanted_file};
use geosweep_cli::precision::Precision;
use geosweep_cli::terminal::{List, Outcome, print_json, progress};

/// The arguments of `geosweep-lab figure convergence`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// Points per side
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    #[arg(default_values_t = [17, 33, 65, 129, 257, 513, 1025])]
    sizes: Vec<usize>,
    /// Write the numbers as a table: surface, wavefront, source, iterations, side,
    /// mean_relative_error
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The mean relative error against the number of points per side. The plot on the left has
one iteration of directed raster scans with the planar wavefront, as in the paper: from
a point, and from exact values in a disc of radius 0.15 around it. The other two plots
show converged maps from a point, one with circular and one with curved fronts. All maps
are computed on the CPU in single precision.

Examples:
  geosweep-lab figure convergence -o convergence.png --csv convergence.csv
  geosweep-lab figure convergence --sizes 33,65,129 --json -o convergence.png";

/// The place of the source, as fractions of rows and columns. It is a point of every grid of the default
/// sizes.
const SOURCE: [f64; 2] = [0.25, 0.375];
/// The radius of the disc of exact values.
const RADIUS: f64 = 0.15;

const SHEARED: Builtin = Builtin::ShearedPlane { degrees: Builtin::DEFAULT_SHEAR };
/// The surfaces of the paper's figure, and two more that unroll into the plane.
const SURFACES: [(Builtin, &str); 5] = [
    (Builtin::Plane, "plane"),
    (SHEARED, "sheared"),
    (Builtin::Sphere, "sphere"),
    (Builtin::Cylinder, "cylinder"),
    (Builtin::Cone, "cone"),
];
const IN_THE_PAPER: usize = 3;
/// The width and height of a plot, in pixels.
const FRAME: [usize; 2] = [450, 500];
/// The wavefronts whose converged maps are shown beside the paper's figure.
const CONVERGED: &[Wavefront] = &[Wavefront::Circular, Wavefront::Curved];

/// The start of a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Start {
    Point,
    Disc,
}

/// The error of one map.
#[derive(Clone, Serialize)]
struct Row {
    surface: String,
    wavefront: &'static str,
    source: Start,
    iterations: u32,
    /// The number of points per side.
    side: usize,
    mean_relative_error: f64,
}

/// One line of a plot, and how its maps are computed.
struct Study {
    builtin: Builtin,
    /// The name of the surface in the figure. `color` is its colour.
    label: &'static str,
    color: Color,
    wavefront: Wavefront,
    start: Start,
    /// Whether to run one iteration of the paper's directed raster scans. Otherwise the tool's CPU engine
    /// computes a converged map.
    one_iteration: bool,
    line: Line,
}

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    let table = wanted_file(args.csv.as_ref(), "a table is", "csv")?;
    let sizes = lists::ascending(&args.sizes);

    let studies = studies();
    let bar = progress(studies.iter().map(Vec::len).sum::<usize>() * sizes.len());
    let rows: Vec<Vec<Vec<Row>>> = studies
        .iter()
        .map(|studies| studies.iter().map(|study| study.rows(&sizes, &bar)).collect())
        .collect::<Result<_, geosweep::Error>>()?;
    bar.finish_and_clear();

    let sheet = sheet(&sizes, &studies, &rows);
    let rows: Vec<Row> = rows.into_iter().flatten().flatten().collect();
    let mut staged = vec![stage_picture(output, || sheet.draw())?];
    if let Some(table) = table {
        staged.push(table.stage(|writer| write_table(writer, &rows))?);
    }
    done([], &commit(staged)?);
    if args.json {
        print_json("figure convergence", &List("maps", &rows))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the lines of each plot. The first plot has the lines of the paper's figure, from a point and
/// from a disc. One plot follows for each wavefront of [`CONVERGED`].
fn studies() -> Vec<Vec<Study>> {
    let surfaces = || SURFACES.into_iter().zip(COLORS);
    let starts = [(Start::Point, Line::Solid), (Start::Disc, Line::Dashed)];
    let one_iteration = |((builtin, label), color)| {
        starts.map(|(start, line)| Study {
            builtin,
            label,
            color,
            wavefront: Wavefront::Planar,
            start,
            one_iteration: true,
            line,
        })
    };
    let converged = |wavefront| {
        let study = |((builtin, label), color)| Study {
            builtin,
            label,
            color,
            wavefront,
            start: Start::Point,
            one_iteration: false,
            line: Line::Solid,
        };
        surfaces().map(study).collect()
    };
    let in_the_paper = surfaces().take(IN_THE_PAPER).flat_map(one_iteration).collect();
    std::iter::once(in_the_paper).chain(CONVERGED.iter().copied().map(converged)).collect()
}

impl Study {
    fn rows(
        &self,
        sizes: &[usize],
        bar: &indicatif::ProgressBar,
    ) -> Result<Vec<Row>, geosweep::Error> {
        let row = |&points: &usize| {
            bar.set_message(format!("{} {points}", self.builtin));
            let reference = Reference::new(self.builtin, points, SOURCE)?;
            let sources = match self.start {
                Start::Point => reference.point_source(),
                Start::Disc => exact_disc(reference.surface.chart(), &reference.distances, RADIUS),
            };
            let (iterations, errors) = self.solve(&reference, &sources)?;
            bar.inc(1);
            Ok(Row {
                surface: self.builtin.to_string(),
                wavefront: self.wavefront.name(),
                source: self.start,
                iterations,
                side: points,
                mean_relative_error: errors.mean_relative,
            })
        };
        sizes.iter().map(row).collect()
    }

    /// Returns the iterations and errors of the map from some sources.
    fn solve(
        &self,
        reference: &Reference,
        sources: &Sources,
    ) -> Result<(u32, Errors), geosweep::Error> {
        if self.one_iteration {
            // The tool's own engines scan in another order than the paper.
            let edges = EdgeLengths::<f32>::new(&reference.surface)?;
            let seeds = sources.seeds(&reference.surface)?;
            let solution = raster_scan(&edges, &seeds, self.wavefront, Stop::after(1));
            return Ok((1, Errors::of(&solution.distances(), &reference.distances)));
        }
        let options = Options::default().with_engine(Engine::Cpu).with_wavefront(self.wavefront);
        let (report, errors) = reference.solve(sources, &options, Precision::Single)?;
        Ok((report.iterations, errors))
    }
}

fn sheet(sizes: &[usize], studies: &[Vec<Study>], rows: &[Vec<Vec<Row>>]) -> Sheet {
    let errors = |rows: &[Vec<Vec<Row>>]| {
        let errors: Vec<_> =
            rows.iter().flatten().flatten().map(|row| row.mean_relative_error).collect();
        Axis::decades("mean relative error", errors.into_iter())
    };
    let (paper_axis, converged_axis) = (errors(&rows[..1]), errors(&rows[1..]));
    let plot = |(index, (studies, rows)): (usize, (&Vec<Study>, &Vec<Vec<Row>>))| {
        let (title, y) = match index {
            0 => ("Planar wavefront, one iteration".into(), paper_axis.clone()),
            _ => (converged_title(studies[0].wavefront), converged_axis.clone()),
        };
        let series = |(study, rows): (&Study, &Vec<Row>)| Series {
            label: study.label.into(),
            color: study.color,
            line: study.line,
            points: rows.iter().map(|row| [row.side as f64, row.mean_relative_error]).collect(),
        };
        Plot {
            title,
            x: Axis::at("points a side, n", sizes),
            y,
            series: studies.iter().zip(rows).map(series).collect(),
            slopes: Some(Slopes {
                from: [0.05, 0.36],
                width: 0.2,
                powers: vec![(-1.0, "1/n"), (-2.0, "1/n²")],
            }),
        }
    };
    Sheet {
        plots: studies.iter().zip(rows).enumerate().map(plot).collect(),
        columns: studies.len(),
        frame: FRAME,
        key: vec![
            (Line::Solid, "from a point".into()),
            (Line::Dashed, "from exact values in a disc around it".into()),
        ],
    }
}

fn converged_title(wavefront: Wavefront) -> String {
    let mut title = format!("{} wavefront, converged", wavefront.name());
    title[..1].make_ascii_uppercase();
    title
}

fn write_table(writer: &mut impl Write, rows: &[Row]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(writer);
    rows.iter().try_for_each(|row| table.serialize(row))?;
    table.flush()
}
