//! Converts map coordinates to places on a grid.

use super::super::{CoordinateSystem, Georeference};
use geosweep_surface::Chart;
use geosweep_surface::shown::exact;

/// A grid, and the location of its points in map coordinates.
///
/// ```
/// use geosweep::io::{CoordinateSystem, Georeference, GridFrame};
/// use geosweep::surface::Chart;
///
/// // 30 m between points, from the upper left one southwards and eastwards.
/// let georeference = Georeference {
///     origin: [500_015.0, 4_000_985.0],
///     down: [0.0, -30.0],
///     right: [30.0, 0.0],
///     system: Some(CoordinateSystem::Projected(32616)),
/// };
/// let frame = GridFrame::new(Chart { rows: 40, cols: 60 }, Ok(georeference));
/// assert_eq!(frame.place([500_045.0, 4_000_955.0])?, [1.0, 1.0]);
/// assert!(frame.place([-84.5, 36.1]).unwrap_err().contains("outside the grid"));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug)]
pub struct GridFrame {
    /// The grid's size.
    pub chart: Chart,
    /// The grid's map coordinates, or the reason why there are none.
    pub georeference: Result<Georeference, String>,
    /// Numbers of rows by which the surface extends beyond the grid's first and last row, and the same for columns.
    margins: [[f64; 2]; 2],
    /// Whether the map coordinates are known to be longitudes and latitudes in degrees.
    in_degrees: bool,
}

/// The coordinate system of a file's map coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapCoordinates {
    /// The surface's system: the file names none.
    Surface,
    /// Easting and northing.
    Projected,
    /// Longitude and latitude.
    Geographic,
    /// GeoJSON that names no system: longitude and latitude on WGS 84 according to RFC 7946.
    Unnamed,
    /// A system, by its EPSG number.
    Epsg(u32),
}

/// Distance in cells outside the grid within which a place counts as a place on the border, since files round
/// coordinates.
const BORDER: f64 = 0.01;
/// Distance in cells from a line of grid points within which a place counts as a place on the line.
const ON_LINE: f64 = 1e-6;

/// Distance in cells outside the grid's points within which a place on the map lies in a border cell, whose value stands
/// for all of the cell.
const HALF_CELL: f64 = 0.5;
/// A full turn of longitudes in degrees.
const TURN: f64 = 360.0;

impl GridFrame {
    /// Makes a frame of a grid of this size.
    pub fn new(chart: Chart, georeference: Result<Georeference, String>) -> Self {
        Self { chart, georeference, margins: [[0.0; 2]; 2], in_degrees: false }
    }

    /// States that the map coordinates are longitudes and latitudes in degrees, also if their system has no number.
    pub fn in_degrees(self) -> Self {
        Self { in_degrees: true, ..self }
    }

    /// Lets places lie beyond the grid's points. `margins` are numbers of rows before the first and after the last row,
    /// and the same for columns. A surface extends beyond its grid's points if these are the middles of cells
    /// ([`geosweep_surface::CompletedGrid::margins`]).
    pub fn with_margins(self, margins: [[f64; 2]; 2]) -> Self {
        Self { margins, ..self }
    }

    /// Returns the row and column of map coordinates `x` (eastwards) and `y` (northwards). A place that is at most a
    /// millionth of a cell away from a line of grid points is moved onto the line. A place in the outer half of a border
    /// cell is moved to the outermost points, as a GIS gives it the value of that cell. Longitudes may differ from the
    /// grid's by full turns.
    ///
    /// # Errors
    /// If the grid has no map coordinates, or the place lies outside it.
    pub fn place(&self, at: [f64; 2]) -> Result<[f64; 2], String> {
        let georeference = self.georeference.as_ref().map_err(|why| not_placed(why))?;
        let within = |at: [f64; 2], beyond: f64| {
            let mut places = self.turned(georeference, at);
            places.find_map(|place| self.moved_within(place, beyond))
        };
        let found = within(at, BORDER).or_else(|| within(at, HALF_CELL));
        let swapped = || within([at[1], at[0]], BORDER).is_some();
        found.ok_or_else(|| self.outside(georeference, at, swapped()))
    }

    /// Returns the row and column of map coordinates wherever they lie, on the turn of longitudes on which that is
    /// closest to the grid, or `None` if there are none.
    pub fn unbounded_place(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let georeference = self.georeference.as_ref().ok()?;
        let ends = self.ends();
        let beyond = |place: &[f64; 2]| {
            let [rows, cols] = [0, 1].map(|k| place[k] - place[k].clamp(ends[k][0], ends[k][1]));
            rows.hypot(cols)
        };
        self.turned(georeference, at).min_by(|a, b| beyond(a).total_cmp(&beyond(b)))
    }

    /// Returns the rows and columns of map coordinates. Longitudes are turned to that of the grid's middle and to one
    /// turn before and after it.
    fn turned<'a>(
        &'a self,
        georeference: &'a Georeference,
        [x, y]: [f64; 2],
    ) -> impl Iterator<Item = [f64; 2]> + 'a {
        let turns = self.turn().map_or([None, None, None], |turn| {
            let (last_row, last_col) = self.chart.last();
            let middle =
                georeference.coordinates([last_row, last_col].map(|last| 0.5 * last as f64));
            let nearest = ((middle[0] - x) / turn).round();
            [0.0, -1.0, 1.0].map(|other| Some(turn * (nearest + other)))
        });
        let turns = turns.into_iter().flatten();
        // Coordinates on the grid's own turn stay exact.
        let all = std::iter::once(0.0).chain(turns.filter(|turn| *turn != 0.0));
        all.filter_map(move |turn| georeference.place([x + turn, y]))
    }

    /// Returns a place moved onto a line of grid points or onto an end of the surface, if it lies at most `beyond` cells
    /// outside.
    fn moved_within(&self, place: [f64; 2], beyond: f64) -> Option<[f64; 2]> {
        let nearest = self.nearest(place);
        let ends = self.ends();
        let on_axis = |k: usize| {
            let ([first, last], line) = (ends[k], nearest[k]);
            // Where the surface goes on to an end beyond the grid's points, there is no border cell.
            let [before, after] =
                self.margins[k].map(|margin| if margin > 0.0 { BORDER } else { beyond });
            let at = if (place[k] - line).abs() <= ON_LINE { line } else { place[k] };
            ((first - before)..=last + after).contains(&at).then(|| at.clamp(first, last))
        };
        Some([on_axis(0)?, on_axis(1)?])
    }

    /// Returns the full turn of the map's first coordinate, if that is a longitude.
    pub(super) fn turn(&self) -> Option<f64> {
        let is_geographic = matches!(self.system(), Some(CoordinateSystem::Geographic(_)));
        (is_geographic || self.in_degrees).then_some(TURN)
    }

    /// Returns whether the grid mirrors its map.
    pub(super) fn is_mirrored(&self) -> bool {
        self.georeference.as_ref().is_ok_and(Georeference::is_mirrored)
    }

    /// Returns a place given by row and column, if it lies on the surface. If the surface ends beyond the grid's
    /// points, a place at most a millionth of a cell away from that end is moved onto it, since files round numbers.
    pub fn within(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let ends = self.ends();
        let on_axis = |k: usize| {
            let is_end = |&k_end: &usize| {
                self.margins[k][k_end] > 0.0 && (place[k] - ends[k][k_end]).abs() <= ON_LINE
            };
            let at = (0..2).find(is_end).map_or(place[k], |end| ends[k][end]);
            (ends[k][0]..=ends[k][1]).contains(&at).then_some(at)
        };
        Some([on_axis(0)?, on_axis(1)?])
    }

    /// Returns the row and column of the surface's point that is nearest to a place. Beyond the grid's points, the
    /// surface has points only at its ends.
    pub(super) fn nearest(&self, place: [f64; 2]) -> [f64; 2] {
        let (last_row, last_col) = self.chart.last();
        let ends = self.ends();
        let on_axis = |k: usize, last: f64| {
            let ([first, end], at) = (ends[k], place[k]);
            match at {
                ..0.0 if at > 0.5 * first => 0.0,
                ..0.0 => first,
                _ if at > last && at - last < 0.5 * (end - last) => last,
                _ if at > last => end,
                _ => at.round(),
            }
        };
        [on_axis(0, last_row as f64), on_axis(1, last_col as f64)]
    }

    /// Returns the first and the last row of the surface, and the same for columns.
    fn ends(&self) -> [[f64; 2]; 2] {
        let (last_row, last_col) = self.chart.last();
        let ends = |last: usize, [before, after]: [f64; 2]| [0.0 - before, last as f64 + after];
        [ends(last_row, self.margins[0]), ends(last_col, self.margins[1])]
    }

    fn outside(&self, georeference: &Georeference, [x, y]: [f64; 2], swapped: bool) -> String {
        let (last_row, last_col) = self.chart.last();
        let corners = [(0, 0), (0, last_col), (last_row, 0), (last_row, last_col)]
            .map(|(row, col)| georeference.coordinates([row as f64, col as f64]));
        let from = |k: usize| corners.iter().map(|at| at[k]).fold(f64::INFINITY, f64::min);
        let to = |k: usize| corners.iter().map(|at| at[k]).fold(f64::NEG_INFINITY, f64::max);
        let system = georeference.system.map(|system| format!(" in EPSG:{}", system.epsg()));
        let mut said = format!(
            "x {}, y {} lies outside the grid, whose points run from x {} to {} and from y {} to {}{}",
            exact(x),
            exact(y),
            exact(from(0)),
            exact(to(0)),
            exact(from(1)),
            exact(to(1)),
            system.unwrap_or_default()
        );
        let is_geographic = matches!(georeference.system, Some(CoordinateSystem::Geographic(_)));
        if swapped {
            said += "; with x and y swapped it lies inside; give x (eastwards) first";
        } else if !is_geographic && x.abs() <= TURN && y.abs() <= 90.0 {
            said += "; if these are longitude and latitude, convert them first";
            if let Some(system) = georeference.system {
                said += &format!(" (ogr2ogr -t_srs EPSG:{})", system.epsg());
            }
        }
        said
    }

    fn system(&self) -> Option<CoordinateSystem> {
        self.georeference.as_ref().ok().and_then(|georeference| georeference.system)
    }
}

fn not_placed(why: &str) -> String {
    format!("map coordinates need a georeferenced surface; {why}. Give rows and columns")
}

impl MapCoordinates {
    /// Returns an error if the coordinates are known to be in a different system than the surface's.
    pub(super) fn check(self, frame: &GridFrame) -> Result<(), String> {
        frame.georeference.as_ref().map_err(|why| not_placed(why))?;
        let Some(system) = frame.system() else { return Ok(()) };
        let epsg = system.epsg();
        let are = match (self, system) {
            (Self::Geographic, CoordinateSystem::Projected(_)) => "longitude and latitude".into(),
            (Self::Projected, CoordinateSystem::Geographic(_)) => "easting and northing".into(),
            (Self::Epsg(own), _) if own != u32::from(epsg) => format!("EPSG:{own}"),
            _ => return Ok(()),
        };
        Err(format!(
            "its coordinates are {are}, the surface's are EPSG:{epsg}; convert them first (ogr2ogr \
             -t_srs EPSG:{epsg} OUT IN)"
        ))
    }

    /// Returns a remark on the assumed coordinate system, if the file does not determine it.
    pub(super) fn assumption(self, frame: &GridFrame) -> Option<String> {
        match (self, frame.system()) {
            (Self::Unnamed, Some(CoordinateSystem::WGS_84)) => None,
            (Self::Unnamed, Some(system)) => Some(format!(
                "names no coordinate system (member crs); its coordinates are taken as the surface's, \
                 EPSG:{}",
                system.epsg()
            )),
            (Self::Unnamed | Self::Epsg(_), None) => Some(
                "its coordinates are taken as the surface's, which has no named coordinate system"
                    .into(),
            ),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame(georeference: Georeference) -> GridFrame {
        GridFrame::new(Chart { rows: 30, cols: 50 }, Ok(georeference))
    }

    fn north_up(origin: [f64; 2], cell: f64, system: Option<CoordinateSystem>) -> Georeference {
        Georeference { origin, down: [0.0, -cell], right: [cell, 0.0], system }
    }

    proptest! {
        #[test]
        fn places_are_found_from_their_rounded_coordinates(
            origin in prop::array::uniform2(-5e6..5e6f64),
            cell in 0.5..100.0f64,
            turn in 0.0..6.2f64,
            row in 0.0..=29.0f64,
            col in 0.0..=49.0f64,
            whole: bool,
        ) {
            let place = if whole { [row.round(), col.round()] } else { [row, col] };
            let (sine, cosine) = turn.sin_cos();
            let georeference = Georeference {
                origin,
                right: [cell * cosine, cell * sine],
                down: [cell * sine, -cell * cosine],
                system: None,
            };
            let rounded = georeference.coordinates(place).map(|c| (c * 1e3).round() / 1e3);
            let found = frame(georeference).place(rounded).unwrap();
            prop_assert!((0..2).all(|k| (found[k] - place[k]).abs() < 1.5e-3), "{found:?} {place:?}");
            let exact = frame(georeference).place(georeference.coordinates(place)).unwrap();
            prop_assert!(!whole || exact == place, "{exact:?} {place:?}");
        }

        #[test]
        fn places_outside_are_refused(row in -90.0..120.0f64, col in -90.0..140.0f64) {
            let utm = north_up([5e5, 4e6], 30.0, Some(CoordinateSystem::Projected(32616)));
            let at = utm.coordinates([row, col]);
            let is_inside = (-0.5..=29.5).contains(&row) && (-0.5..=49.5).contains(&col);
            let found = frame(utm).place(at);
            prop_assert_eq!(found.is_ok(), is_inside);
            if let Ok(place) = found {
                let moved = [row.clamp(0.0, 29.0), col.clamp(0.0, 49.0)];
                prop_assert!((0..2).all(|k| (place[k] - moved[k]).abs() < 1e-6));
            }
        }

        #[test]
        fn longitudes_may_differ_by_any_number_of_turns(
            west in -360.0..360.0f64,
            turns in -9..=9i32,
            place in (0..30u32, 0..50u32),
        ) {
            let grid = frame(north_up([west, 20.0], 0.5, Some(CoordinateSystem::WGS_84)));
            let place = [place.0, place.1].map(f64::from);
            let [x, y] = grid.georeference.as_ref().unwrap().coordinates(place);
            prop_assert_eq!(grid.place([x + 360.0 * f64::from(turns), y]), Ok(place));
        }
    }

    #[test]
    fn degrees_on_a_projected_surface_are_told_apart() {
        let utm = frame(north_up([5e5, 4e6], 30.0, Some(CoordinateSystem::Projected(32616))));
        let reason = utm.place([-84.5, 36.1]).unwrap_err();
        assert!(
            reason.contains("longitude and latitude") && reason.contains("EPSG:32616"),
            "{reason}"
        );
        let far = utm.place([6e5, 4e6]).unwrap_err();
        assert!(!far.contains("longitude"), "{far}");
        let swapped = utm.place([3_999_900.0, 500_100.0]).unwrap_err();
        assert!(swapped.contains("with x and y swapped"), "{swapped}");
        assert!(MapCoordinates::Geographic.check(&utm).unwrap_err().contains("EPSG:32616"));
        assert!(MapCoordinates::Epsg(4326).check(&utm).unwrap_err().contains("EPSG:4326"));
        assert_eq!(MapCoordinates::Epsg(32616).check(&utm), Ok(()));
        assert!(MapCoordinates::Unnamed.assumption(&utm).unwrap().contains("EPSG:32616"));
    }

    #[test]
    fn longitudes_are_the_same_after_a_turn() {
        let world = frame(north_up([170.0, 20.0], 0.5, Some(CoordinateSystem::WGS_84)));
        assert_eq!(world.place([190.0, 15.0]), Ok([10.0, 40.0]));
        assert_eq!(world.place([-170.0, 15.0]), Ok([10.0, 40.0]));
        assert_eq!(world.place([-530.0, 15.0]), Ok([10.0, 40.0]));
        assert_eq!(world.place([194.7, 20.2]), Ok([0.0, 49.0]));
        assert!(world.place([194.8, 20.2]).is_err());
        let wider = world.clone().with_margins([[0.5, 0.0], [0.0, 1.0]]);
        assert_eq!(wider.place([195.0, 20.25]), Ok([-0.5, 50.0]));
        assert!(wider.place([195.5, 20.0]).is_err() && wider.place([180.0, 20.5]).is_err());
        assert_eq!(wider.place([195.0 + 1e-8, 20.25 - 1e-8]), Ok([-0.5, 50.0]));
        assert!(MapCoordinates::Projected.check(&world).is_err());
        assert_eq!(MapCoordinates::Unnamed.assumption(&world), None);
    }

    #[test]
    fn a_surface_ends_beyond_the_middles_of_cells() {
        let world = frame(north_up([170.0, 20.0], 0.5, Some(CoordinateSystem::WGS_84)));
        assert_eq!(
            (world.within([0.0, 49.0]), world.within([0.0, 49.0 + 1e-9])),
            (Some([0.0, 49.0]), None)
        );
        assert_eq!(world.nearest([-0.3, 49.7]), [0.0, 49.0]);
        let rounded = 1.0 - f64::EPSILON;
        for after in [1.0, rounded, 0.7] {
            let wider = world.clone().with_margins([[0.5, 0.4], [0.0, after]]);
            let end = 49.0 + after;
            assert_eq!(wider.within([29.4, end + 1e-7]), Some([29.4, end]));
            assert_eq!(wider.within([-0.5 - 1e-7, end - 1e-7]), Some([-0.5, end]));
            assert_eq!(wider.within([7.25, 49.3]), Some([7.25, 49.3]));
            for outside in [[-0.51, 3.0], [29.41, 3.0], [3.0, -1e-7], [3.0, end + 0.01]] {
                assert_eq!(wider.within(outside), None, "{outside:?}");
            }
            assert_eq!(wider.nearest([-0.3, 49.1]), [-0.5, 49.0]);
            assert_eq!(wider.nearest([-0.2, 49.6]), [0.0, end]);
            assert_eq!(wider.nearest([29.3, 12.6]), [29.4, 13.0]);
        }
    }

    #[test]
    fn a_surface_without_map_coordinates_has_no_places() {
        let nowhere = GridFrame::new(Chart { rows: 3, cols: 3 }, Err("it is a plane".into()));
        assert!(nowhere.place([1.0, 1.0]).unwrap_err().contains("it is a plane"));
    }
}
