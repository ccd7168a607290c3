//! Places a grid of heights on the Earth, as requested on the command line.

use std::error::Error;
use std::path::Path;

use clap::ValueEnum;
use geosweep::io::{CoordinateSystem, GeoTags, Georeference, SurfaceFile};
use geosweep::shown::{exact, seven_digits};
use geosweep::surface::{Chart, Ellipsoid};

use crate::numbers::numbers;

#[derive(clap::Args)]
pub struct GeodeticArgs {
    /// Take SURFACE as heights in metres on the ellipsoid of its coordinate system, by default that of WGS 84, in a grid
    /// of longitudes and latitudes. Distances are in metres.
    /// Paths pass the date line and the poles where the grid goes round the Earth. A GeoTIFF or an ESRI ASCII grid in
    /// degrees says where it lies; other files need --extent
    #[arg(long, help_heading = "Earth", conflicts_with_all = ["spacing", "metric", "glue", "wrap", "layout"])]
    geodetic: bool,
    /// Extent of the grid in degrees, for files that do not give it. EAST may be less than WEST, across the date line
    #[arg(long, value_name = "WEST,SOUTH,EAST,NORTH", help_heading = "Earth", value_parser = extent)]
    #[arg(allow_hyphen_values = true, requires_all = ["geodetic", "registration"])]
    extent: Option<Extent>,
    /// Where the values lie in --extent
    #[arg(long, value_enum, help_heading = "Earth", requires = "extent")]
    registration: Option<Registration>,
    /// The first row of the file is the southernmost one, not the northernmost
    #[arg(long, help_heading = "Earth", requires = "extent")]
    south_up: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Registration {
    /// Values at the middles of cells. The extent is the outer edge of the cells: 180 x 360 values for the Earth at one
    /// degree
    Pixel,
    /// Values on lines. The outermost lines are the extent: 181 x 361 values
    Gridline,
}

/// The sides of a grid in degrees. `east` is larger than `west`.
#[derive(Clone, Copy, Debug)]
struct Extent {
    west: f64,
    south: f64,
    east: f64,
    north: f64,
}

/// The location of a file's points in degrees, and the fields of a GeoTIFF that give it.
pub struct Location {
    pub georeference: Georeference,
    pub geo_tags: GeoTags,
    pub ellipsoid: Ellipsoid,
}

/// The angle of a full turn in degrees.
const TURN: f64 = 360.0;
/// Least span of an extent in degrees, a tenth of a millimetre. Smaller spans come from rounding errors and count as
/// empty.
const LEAST_SPAN: f64 = 1e-9;
fn extent(text: &str) -> Result<Extent, String> {
    let form = "an extent is four numbers in degrees: WEST,SOUTH,EAST,NORTH";
    let [west, south, east, north] = numbers(text)?.try_into().map_err(|_| form)?;
    for latitude in [south, north] {
        check_latitude(latitude)?;
    }
    if south > north {
        return Err(format!(
            "SOUTH {} is not less than NORTH {}; --south-up is for files that begin in the south",
            exact(south),
            exact(north)
        ));
    }
    let east = if east < west { east + TURN } else { east };
    if east - west > TURN {
        return Err("the extent must span at most 360 degrees of longitude".into());
    }
    if (east - west).min(north - south) < LEAST_SPAN {
        return Err("the extent must span more than 0 degrees of longitude and of latitude; a grid that goes round \
                    the Earth ends 360 degrees from where it begins"
            .into());
    }
    Ok(Extent { west, south, east, north })
}

/// Checks a latitude in degrees.
pub fn check_latitude(degrees: f64) -> Result<(), String> {
    match degrees.abs() <= 90.0 {
        true => Ok(()),
        false => {
            Err(format!("latitude {}; latitudes lie between -90 and 90 degrees", exact(degrees)))
        }
    }
}

impl GeodeticArgs {
    /// Returns whether the surface lies on the Earth.
    pub fn is_wanted(&self) -> bool {
        self.geodetic
    }

    /// Returns the location of the points of a file. `chart` is the size of its grid.
    pub fn location(
        &self,
        path: &Path,
        file: &SurfaceFile,
        chart: Chart,
    ) -> Result<Location, Box<dyn Error>> {
        let name = path.display();
        match (file.georeference(), self.extent.zip(self.registration)) {
            (Ok(_), Some(_)) => {
                Err(format!("{name} says where it lies on the Earth; leave --extent out").into())
            }
            (Err(why), None) => Err(format!(
                "{why}. Give --extent WEST,SOUTH,EAST,NORTH and --registration pixel or gridline"
            )
            .into()),
            (Err(_), Some((extent, registration))) => {
                let georeference = extent.georeference(chart, registration, self.south_up);
                let (geo_tags, ellipsoid) = (GeoTags::new(&georeference), Ellipsoid::WGS_84);
                Ok(Location { georeference, geo_tags, ellipsoid })
            }
            (Ok(given), None) => {
                check_degrees(given, file).map_err(|why| format!("{name}: {why}"))?;
                let ellipsoid = file.ellipsoid()?;
                remark(path, ellipsoid);
                // A system without a number on another ellipsoid has no name here, but its fields are kept.
                let is_own = ellipsoid.is_some_and(|ellipsoid| ellipsoid != Ellipsoid::WGS_84);
                let system = (!is_own).then_some(CoordinateSystem::WGS_84);
                let georeference = Georeference { system: given.system.or(system), ..given };
                let named = file.geo_tags().filter(|_| is_own || given.system.is_some()).cloned();
                let geo_tags = named.unwrap_or_else(|| GeoTags::new(&georeference));
                let ellipsoid = ellipsoid.unwrap_or(Ellipsoid::WGS_84);
                Ok(Location { georeference, geo_tags, ellipsoid })
            }
        }
    }
}

impl Extent {
    fn georeference(
        self,
        Chart { rows, cols }: Chart,
        registration: Registration,
        south_up: bool,
    ) -> Georeference {
        let Self { west, south, east, north } = self;
        // There is one step fewer than there are gridlines. A grid of one line is refused later.
        let (fewer, half) = match registration {
            Registration::Pixel => (0, 0.5),
            Registration::Gridline => (1, 0.0),
        };
        let step = |span: f64, count: usize| span / count.saturating_sub(fewer).max(1) as f64;
        let (right, up) = (step(east - west, cols), step(north - south, rows));
        let (first, down) =
            if south_up { (south + half * up, up) } else { (north - half * up, -up) };
        Georeference {
            origin: [west + half * right, first],
            down: [0.0, down],
            right: [right, 0.0],
            system: Some(CoordinateSystem::WGS_84),
        }
    }
}

/// Checks that a file gives longitudes and latitudes.
fn check_degrees(given: Georeference, file: &SurfaceFile) -> Result<(), String> {
    if let Some(CoordinateSystem::Projected(epsg)) = given.system {
        return Err(format!(
            "its coordinates are those of the map EPSG:{epsg}, not longitudes and latitudes; leave \
             --geodetic out, or gdalwarp -t_srs EPSG:4326 makes a grid of degrees"
        ));
    }
    if given.down[0] != 0.0 || given.right[1] != 0.0 {
        return Err("its rows do not follow parallels, or its columns meridians; gdalwarp -t_srs \
                    EPSG:4326 makes such a grid"
            .into());
    }
    if !file.may_be_in_degrees() {
        return Err("the spacing of its points is a length on a map, not degrees; leave --geodetic out, or gdalwarp \
                    -t_srs EPSG:4326 makes a grid of degrees"
            .into());
    }
    Ok(())
}

/// Prints a note on the ellipsoid of a file, if it names none or another one than that of WGS 84.
fn remark(path: &Path, ellipsoid: Option<Ellipsoid>) {
    let name = path.display();
    match ellipsoid {
        Some(Ellipsoid::WGS_84) => {}
        Some(Ellipsoid { equator, flattening }) => note!(
            "{name}: distances are measured on its own ellipsoid, of the radius {} m and the flattening {}",
            exact(equator),
            match flattening {
                0.0 => "0".to_string(),
                _ => format!("1/{}", seven_digits(flattening.recip())),
            }
        ),
        None => note!("{name} names no coordinate system; it is taken as WGS 84, in degrees"),
    }
}
