//! Reads the surface on which distances are measured.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, TypedValueParser};
use geosweep::io::{self, GeoTags, Georeference, MapScale, SurfaceFile};
use geosweep::shown::exact;
use geosweep::surface::{Chart, Ellipsoid, Geometry, Resolution, Seam};
use geosweep::{EdgeRule, Spacing, Surface};

use super::earth::Earth;
use super::geodetic::{GeodeticArgs, Location};
use super::given::GivenGrid;
use super::gluing::{GlueArgs, Whole};
use super::scene::Scene;
use crate::choices::one_of;
use crate::numbers::numbers;
use crate::surface_arg::SurfaceArg;
use crate::terminal::Spinner;

#[derive(clap::Args)]
pub struct SurfaceArgs {
    /// A file, or builtin:NAME:ROWSxCOLS. Files: .npy with positions (M, N, 3), heights (M, N) or a metric
    /// (M, N, 2, 2); .npz with one such array, or one that is named surface, positions, heights or metric;
    /// .tif with heights in one band, as GDAL reads it; .asc with heights, an ESRI ASCII grid; .png with
    /// heights, grey, 8 or 16 bits; .exr with positions in channels X, Y, Z or R, G, B, or heights in a
    /// single channel or three equal ones. NaN, no-data and an alpha of 0 mark holes
    #[arg(value_parser = OsStringValueParser::new().try_map(SurfaceArg::parse))]
    surface: SurfaceArg,

    /// Distance between columns and between rows of heights, in the unit of the heights; the package for Python
    /// takes rows first, (dy, dx) (default: that of a projected GeoTIFF or an ESRI ASCII grid, otherwise 1)
    #[arg(long, value_name = "DX[,DY]", help_heading = "Surface", value_parser = spacing)]
    #[arg(allow_hyphen_values = true)]
    spacing: Option<Spacing>,
    /// Value of SURFACE that marks holes, for files that cannot say it (.npy, .npz, .png, .exr) or do not (.tif). All
    /// coordinates of a position must have it
    #[arg(long, value_name = "VALUE", help_heading = "Surface", allow_hyphen_values = true)]
    nodata: Option<f64>,
    /// Mask of the surface (non-zero) and its holes (zero or no-data): .npy (M, N) of booleans or integers,
    /// .npz (named mask, if it holds several), an 8-bit grey .png, .tif or .asc. Points that touch only at a
    /// corner, between two holes, are not connected. Widen lines that are 8-connected, such as rasterised
    /// rivers, to 4-connected ones
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    mask: Option<PathBuf>,
    /// Slowness of each point, the reciprocal of a speed, by which lengths are multiplied, so that distances
    /// become travel times: .npy (M, N), .npz (named slowness, if it holds several), .tif or .asc, positive
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    slowness: Option<PathBuf>,
    /// Metric that gives the lengths in place of SURFACE's positions, which are still used for the picture:
    /// .npy or .npz (M, N, 2, 2), symmetric and positive definite, per step of one row (axis 0) and one
    /// column (axis 1)
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    metric: Option<PathBuf>,
    /// Rule for the length between neighbouring points (default: arc). A metric has its own lengths
    #[arg(long, value_parser = one_of(&EDGE_RULES), help_heading = "Surface")]
    edges: Option<EdgeRule>,
    #[command(flatten)]
    glue: GlueArgs,
    #[command(flatten)]
    pub geodetic: GeodeticArgs,
}

const EDGE_RULES: [(EdgeRule, &str); 2] = [
    (EdgeRule::Arc, "Along the surface if it bends alike at both ends, otherwise the chord"),
    (EdgeRule::Chord, "Straight: the surface is the polyhedron of its points"),
];

fn spacing(text: &str) -> Result<Spacing, String> {
    let spacing = match numbers(text)?[..] {
        [both] => Spacing::square(both),
        [dx, dy] => Spacing { dx, dy },
        _ => return Err("a spacing is one number, or one for columns and one for rows".into()),
    };
    if spacing.dx > 0.0 && spacing.dy > 0.0 {
        Ok(spacing)
    } else {
        Err("a spacing must be positive".into())
    }
}

/// A surface as read from a file or made by name.
struct Given {
    surface: Surface,
    georeference: Result<Georeference, String>,
    geo_tags: Option<GeoTags>,
    unit: Option<&'static str>,
    earth: Option<Earth>,
}

impl SurfaceArgs {
    pub fn read(&self) -> Result<Scene, Box<dyn Error>> {
        let Given { surface: given, georeference, geo_tags, unit, mut earth } =
            self.read_surface()?;
        // Seams are taken from the positions, since a metric does not define them.
        let mut seams = given.seams();
        let chart = earth.as_ref().map_or(given.chart(), |earth| earth.chart);
        let (rows, cols) = (chart.rows, chart.cols);
        let place = georeference.as_ref().ok();
        let (mut surface, mut shape) = self.measured(given)?;
        if let Some(path) = &self.mask {
            let mut mask = io::read_mask(path)?.fit_surface(path, rows, cols, place)?;
            if let Some(earth) = &mut earth {
                mask = earth.mask(&mask);
            }
            surface = surface.with_mask(&mask).map_err(|e| format!("{}: {e}", path.display()))?;
            seams = match &shape {
                None => surface.seams(),
                Some(shape) => shape.clone().with_mask(&mask)?.seams(),
            };
        }
        if let Some(path) = &self.slowness {
            let slowness = io::read_slowness(path)?.fit_surface(path, rows, cols, place)?;
            let slowness = match &earth {
                Some(earth) => earth.slowness(&slowness),
                None => Ok(slowness),
            };
            surface = slowness
                .and_then(|slowness| surface.with_slowness(slowness))
                .map_err(|e| format!("{}: {e}", path.display()))?;
        }
        let mut grid = earth.as_ref().map(Earth::given);
        if let Some((glue, last)) = self.glue.wanted()? {
            let whole = glue.apply(surface, shape.as_ref(), &seams, last)?;
            let Whole { surface: glued, shape: whole_shape, lines, goes_round } = whole;
            (surface, shape) = (glued, whole_shape.or(shape));
            seams = if shape.is_none() { surface.seams() } else { Vec::new() };
            grid = lines.map(|lines| GivenGrid::new(lines, georeference.clone(), goes_round));
        }
        // On the Earth, seams are glued already, and a sector that ends at a pole is not a closed surface.
        if earth.is_none() {
            warn_of_seams(&seams);
        }
        warn_of_resolution(&surface, self);
        if self.edges.is_some() && matches!(surface.geometry(), Geometry::Metric(_)) {
            return Err(
                "--edges is for positions and heights; a metric has its own lengths, leave \
                        one of them out"
                    .into(),
            );
        }
        let surface = surface.with_edge_rule(self.edges.unwrap_or_default());
        // With a slowness, lengths become times. A separate metric may be in another unit.
        let unit = unit.filter(|_| shape.is_none() && surface.slowness().is_none());
        let is_on_earth = earth.is_some();
        Ok(Scene { surface, shape, georeference, geo_tags, unit, grid, is_on_earth })
    }

    /// Returns the surface with the lengths of the metric, and the given surface, which has the positions.
    /// Without a metric, returns the given surface alone.
    fn measured(&self, given: Surface) -> Result<(Surface, Option<Surface>), Box<dyn Error>> {
        let Some(path) = &self.metric else { return Ok((given, None)) };
        let (rows, cols) = (given.rows(), given.cols());
        let metric = io::read_metric(path)?.fit(path, rows, cols)?;
        let surface = Surface::from_metric(rows, cols, metric)
            .and_then(|surface| surface.with_mask(given.present()))
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok((surface, Some(given)))
    }

    /// Returns the surface's file, if it comes from one.
    pub fn file(&self) -> Option<&PathBuf> {
        match &self.surface {
            SurfaceArg::File(path) => Some(path),
            SurfaceArg::Builtin(_) => None,
        }
    }

    /// Returns the files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        let optional =
            [self.file(), self.mask.as_ref(), self.slowness.as_ref(), self.metric.as_ref()];
        optional.into_iter().flatten()
    }

    fn read_surface(&self) -> Result<Given, Box<dyn Error>> {
        match &self.surface {
            SurfaceArg::Builtin(builtin) => {
                if self.spacing.is_some() {
                    return Err("--spacing is for heights from a file; a built-in surface has \
                                its own size, leave it out"
                        .into());
                }
                if self.nodata.is_some() {
                    return Err("--nodata is for files; a built-in surface has no such values, \
                                leave it out"
                        .into());
                }
                if self.geodetic.is_wanted() {
                    return Err(
                        "--geodetic is for heights from a file; a built-in surface does not lie \
                                on the Earth, leave it out"
                            .into(),
                    );
                }
                let nowhere = "a built-in surface has no place on the Earth";
                Ok(Given {
                    surface: builtin.surface()?,
                    georeference: Err(nowhere.into()),
                    geo_tags: None,
                    unit: None,
                    earth: None,
                })
            }
            SurfaceArg::File(path) => {
                let _spinner = Spinner::new("reading");
                let file = self.without_no_data(path, SurfaceFile::read(path)?);
                if self.geodetic.is_wanted() {
                    return self.read_geodetic(path, file);
                }
                if file.lacks_spacing() && self.spacing.is_none() {
                    let name = path.display();
                    note!("{name}: heights are taken as 1 apart; --spacing sets another distance");
                }
                if file.assumes_metres() && self.spacing.is_none() {
                    let name = path.display();
                    note!(
                        "{name}: pixel size and heights are taken as metres, since the file \
                             does not say its unit; --spacing sets another distance"
                    );
                }
                let georeference = file.georeference().map_err(|error| error.to_string());
                // A spacing from the command line may be in any unit.
                let unit = file.unit().filter(|_| self.spacing.is_none());
                let geo_tags = file.geo_tags().cloned();
                let place = georeference.as_ref().ok().copied().filter(|_| self.spacing.is_none());
                let surface = file.into_surface(self.spacing)?;
                if let Some(place) = place {
                    note_scale(path, &place, surface.chart());
                }
                Ok(Given { surface, georeference, geo_tags, unit, earth: None })
            }
        }
    }

    /// Makes holes where a file has the value of --nodata.
    fn without_no_data(&self, path: &Path, file: SurfaceFile) -> SurfaceFile {
        let Some(value) = self.nodata else { return file };
        let (file, holes) = file.with_no_data(value);
        if holes == 0 {
            note!("{}: no point has the value {} of --nodata", path.display(), exact(value));
        }
        file
    }

    fn read_geodetic(&self, path: &Path, file: SurfaceFile) -> Result<Given, Box<dyn Error>> {
        let heights = file.clone().into_heights()?;
        let chart = Chart { rows: heights.rows, cols: heights.cols };
        let location = self.geodetic.location(path, &file, chart)?;
        let Location { georeference, geo_tags, ellipsoid } = location;
        let named = |error: String| format!("{}: {error}", path.display());
        let earth = Earth::new(&georeference, ellipsoid, chart, &heights.values).map_err(named)?;
        let surface = earth.grid.surface(&heights.values);
        let surface = surface.map_err(|error| named(error.to_string()))?;
        match ellipsoid == Ellipsoid::WGS_84 {
            true => note!("{EARTH}"),
            false => note!("{ELSEWHERE}"),
        }
        Ok(Given {
            surface,
            georeference: Ok(georeference),
            geo_tags: Some(geo_tags),
            unit: Some("m"),
            earth: Some(earth),
        })
    }
}

/// Prints a note if lengths on the map are not those on the ground.
fn note_scale(path: &Path, place: &Georeference, chart: Chart) {
    let Some(MapScale { projection, range: [least, largest] }) = place.map_scale(chart) else {
        return;
    };
    note!(
        "{}: the {projection} map has a scale of {least:.3} to {largest:.3} here, so that distances on it are that many \
         times those on the ground; gdalwarp to a projection for this area, or to EPSG:4326 and --geodetic, measures on \
         the ground",
        path.display()
    );
}

/// The note on the assumed reference of heights on the Earth, and the reason for maps in double precision.
const EARTH: &str = "heights are taken as those above the ellipsoid WGS 84; heights above sea level differ by up to \
                     107 m, which changes distances by at most a 60,000th. Maps are in double precision by default, \
                     since thin cells near the poles cost digits";

/// The note for other ellipsoids.
const ELSEWHERE: &str = "heights are taken as those above the ellipsoid. Maps are in double precision by default, since \
                         thin cells near the poles cost digits";

/// Prints a warning if the cells are too skewed for updates, and one if the surface turns too far from point to point to
/// be smooth, with a likely cause.
fn warn_of_resolution(surface: &Surface, args: &SurfaceArgs) {
    if let Some(unresolved) = surface.unresolved() {
        warning!(
            "{unresolved}. Distances may be late by tens of per cent there, unless rows or columns follow the direction \
             in which lengths are short"
        );
    }
    let Some(Resolution { sharp_edges, .. }) = surface.resolution() else { return };
    if sharp_edges <= MOST_SHARP {
        return;
    }
    let share = 100.0 * sharp_edges;
    let mut said = format!(
        "the grid does not resolve the surface: it turns by more than 30 degrees along {share:.0} % of the edges. \
         Distances are those of a polyhedron, good to several per cent"
    );
    let one_apart = |spacing: &Spacing| spacing.dx == 1.0 && spacing.dy == 1.0;
    let is_unspaced = args.spacing.is_none()
        && matches!(surface.geometry(), Geometry::Heights { spacing, .. } if one_apart(spacing));
    if is_unspaced {
        said += "; no --spacing was given, so points lie one unit apart";
    }
    warning!("{said}");
}

/// The largest fraction of sharp edges of a resolved surface. Built-in surfaces with creases have a smaller
/// fraction.
const MOST_SHARP: f64 = 0.1;

/// Prints a warning that paths end at seams, with the remedy.
fn warn_of_seams(seams: &[Seam]) {
    if seams.is_empty() {
        return;
    }
    let names = seams.iter().map(Seam::to_string).collect::<Vec<_>>().join(", ");
    let mut said = format!("the surface is closed: {names}");
    if seams.iter().any(|seam| !matches!(seam, Seam::Pole { .. })) {
        said += ". No path crosses such a seam unless --glue auto joins its sides";
    }
    if seams.iter().any(|seam| matches!(seam, Seam::Sides { .. } | Seam::Fold(_))) {
        said += "; --mask can remove one of two equal lines";
    }
    if seams.iter().any(|seam| matches!(seam, Seam::Pole { exact: false, .. })) {
        said += ". Mask all but one of a pole's points, or make them equal to the last digit";
    }
    warning!("{said}");
}
