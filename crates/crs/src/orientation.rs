//! Turns directions from the frame of a grid to that of its map.

use crate::Georeference;

/// The orientation of a grid on its map. Directions on a grid count rows as running to the south and columns as running
/// to the east. On rasters whose rows or columns run in other directions, this turns them to the map's north. The default
/// turns nothing.
///
/// ```
/// use geosweep_crs::Georeference;
///
/// // The first row is the southernmost one.
/// let south_up =
///     Georeference { origin: [0.0, 0.0], down: [0.0, 30.0], right: [30.0, 0.0], system: None };
/// let turned = south_up.orientation()?;
/// assert_eq!([turned.compass(180.0), turned.compass(90.0)], [360.0, 90.0]);
/// assert_eq!(turned.link(3)?, 7);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orientation {
    /// Compass bearing, on the map, of the direction of decreasing rows, in degrees.
    north: f64,
    /// Whether columns run to the left of that direction.
    is_mirrored: bool,
}

/// Largest cosine of the angle between rows and columns that count as being at a right angle. The rounding errors of a
/// turned grid stay below it.
const RIGHT_ANGLE: f64 = 1e-6;
/// Largest deviation from a quarter turn, in degrees, that counts as rounding.
const QUARTER: f64 = 1e-6;

impl Georeference {
    /// Returns whether a curve that turns to the left on the map turns to the right in a picture of the grid with rows
    /// downwards.
    pub fn is_mirrored(&self) -> bool {
        let [down, right] = [self.down, self.right];
        right[0] * down[1] - right[1] * down[0] > 0.0
    }

    /// Returns the orientation of the grid on its map.
    ///
    /// # Errors
    /// If rows and columns are not at right angles on the map.
    pub fn orientation(&self) -> Result<Orientation, String> {
        let [down, right] = [self.down, self.right];
        let lengths = down[0].hypot(down[1]) * right[0].hypot(right[1]);
        if (down[0] * right[0] + down[1] * right[1]).abs() > RIGHT_ANGLE * lengths {
            return Err("its rows and columns are not at right angles, so directions on the grid are none on the map; \
                        gdalwarp makes a plain grid of it"
                .into());
        }
        let north = (-down[0]).atan2(-down[1]).to_degrees();
        Ok(Orientation { north, is_mirrored: self.is_mirrored() })
    }
}

impl Orientation {
    /// Returns the compass bearing on the map, above 0 and up to 360, of a compass bearing on the grid. 0, which marks
    /// sources, and negative values, which mark points without a direction, stay as they are.
    pub fn compass(&self, bearing: f32) -> f32 {
        if bearing <= 0.0 || self.is_grid() {
            return bearing;
        }
        let turned = if self.is_mirrored { -f64::from(bearing) } else { f64::from(bearing) };
        let turned = (self.north + turned).rem_euclid(360.0) as f32;
        if turned == 0.0 { 360.0 } else { turned }
    }

    /// Returns the angle on the map counter-clockwise from east, above 0 and up to 360, of such an angle on the grid. 0
    /// and negative values stay as they are.
    pub fn grass(&self, angle: f32) -> f32 {
        if angle <= 0.0 || self.is_grid() {
            return angle;
        }
        // 90 degrees minus one angle is the other.
        let bearing = (90.0 - f64::from(angle)).rem_euclid(360.0) as f32;
        let turned = self.compass(if bearing == 0.0 { 360.0 } else { bearing });
        let angle = (90.0 - f64::from(turned)).rem_euclid(360.0) as f32;
        if angle == 0.0 { 360.0 } else { angle }
    }

    /// Returns the code on the map of a back link on the grid: 1 to 8 are the neighbours clockwise from east. Other
    /// codes stay as they are.
    ///
    /// # Errors
    /// If rows run neither along meridians nor along parallels, so that neighbours lie in none of the eight directions.
    pub fn link(&self, code: i32) -> Result<i32, String> {
        let quarters = self.north / 90.0;
        if (quarters - quarters.round()).abs() > QUARTER {
            return Err("its rows run neither along nor across the map's north, so that neighbours lie in none of the \
                        eight directions; gdalwarp makes a plain grid of it"
                .into());
        }
        if !(1..=8).contains(&code) {
            return Ok(code);
        }
        // Eighths of a turn clockwise from north.
        let eighths = if self.is_mirrored { -(code + 1) } else { code + 1 };
        Ok((2 * quarters.round() as i32 + eighths - 2).rem_euclid(8) + 1)
    }

    /// Returns the direction on the grid, as columns and rows, of a direction on the map that is given as parts to the
    /// east and to the south.
    pub fn on_grid(&self, [east, south]: [f64; 2]) -> [f64; 2] {
        if self.is_grid() {
            return [east, south];
        }
        let (sine, cosine) = self.north.to_radians().sin_cos();
        // Parts along the direction of decreasing rows, and to its right.
        let (ahead, right) = (east * sine - south * cosine, east * cosine + south * sine);
        [if self.is_mirrored { -right } else { right }, -ahead]
    }

    /// Returns whether columns run to the left of the direction of decreasing rows.
    pub fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }

    /// Returns whether directions on the map are those on the grid.
    fn is_grid(&self) -> bool {
        self.north == 0.0 && !self.is_mirrored
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Compares with directions between points that the georeference places on the map.
        #[test]
        fn directions_are_those_between_points_on_the_map(
            turn in prop_oneof![0.0..360.0f64, (0..8i32).prop_map(|eighths| 45.0 * f64::from(eighths))],
            mirrored: bool,
            cell in prop::array::uniform2(0.5..50.0f64),
            step in prop::array::uniform2(-9..=9i32),
        ) {
            prop_assume!(step != [0, 0]);
            let (sine, cosine) = turn.to_radians().sin_cos();
            let [dx, dy] = cell;
            let right = if mirrored { -dx } else { dx };
            let at = Georeference {
                origin: [3e5, 5e6],
                down: [-dy * sine, -dy * cosine],
                right: [right * cosine, -right * sine],
                system: None,
            };
            let place = step.map(f64::from);
            let [from, to] = [at.coordinates([0.0; 2]), at.coordinates(place)];
            let (east, north) = (to[0] - from[0], to[1] - from[1]);
            let on_grid = (place[1] * dx).atan2(-place[0] * dy).to_degrees().rem_euclid(360.0) as f32;
            let on_grid = if on_grid == 0.0 { 360.0 } else { on_grid };
            let apart = |a: f32, b: f64| (f64::from(a) - b + 180.0).rem_euclid(360.0) - 180.0;
            let turned = at.orientation().unwrap();
            // An angle of 0 marks a source.
            let counted = (450.0 - on_grid) % 360.0;
            let counted = if counted == 0.0 { 360.0 } else { counted };
            let (bearing, angle) = (turned.compass(on_grid), turned.grass(counted));
            prop_assert!(apart(bearing, east.atan2(north).to_degrees()).abs() < 1e-2);
            prop_assert!(apart(angle, north.atan2(east).to_degrees()).abs() < 1e-2);
            for angle in [bearing, angle] {
                prop_assert!(angle > 0.0 && angle <= 360.0);
            }
            prop_assert_eq!([turned.compass(0.0), turned.grass(-1.0)], [0.0, -1.0]);
            let [cols, rows] = turned.on_grid([east, -north]);
            prop_assert!((cols - place[1] * dx).abs() < 1e-6 && (rows - place[0] * dy).abs() < 1e-6);
        }

        #[test]
        fn links_lead_to_the_same_neighbours(quarters in 0..4i32, mirrored: bool, code in 1..=8i32) {
            let down = [[0.0, -1.0], [-1.0, 0.0], [0.0, 1.0], [1.0, 0.0]][quarters as usize];
            let right = if mirrored { [down[1], -down[0]] } else { [-down[1], down[0]] };
            let at = Georeference { origin: [0.0; 2], down, right, system: None };
            let steps = |code: i32| [[0, 1], [1, 1], [1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1]][code as usize - 1];
            let [x, y] = at.coordinates(steps(code).map(f64::from));
            let turned = at.orientation().unwrap();
            let [south, east] = steps(turned.link(code).unwrap()).map(f64::from);
            prop_assert_eq!([east, -south], [x, y]);
            prop_assert_eq!([turned.link(0), turned.link(-1)], [Ok(0), Ok(-1)]);
        }
    }

    #[test]
    fn slanted_and_turned_grids_are_refused() {
        let slanted =
            Georeference { origin: [0.0; 2], down: [0.5, -1.0], right: [1.0, 0.0], system: None };
        assert!(slanted.orientation().unwrap_err().contains("right angles"));
        let turned = Georeference { down: [0.6, -0.8], right: [0.8, 0.6], ..slanted };
        assert!(turned.orientation().unwrap().link(1).unwrap_err().contains("eight directions"));
    }
}
