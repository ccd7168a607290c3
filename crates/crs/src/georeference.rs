//! Defines the affine map from places on a grid to map coordinates.

/// The affine map from rows and columns to map coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeference {
    /// Coordinates at row 0, column 0: eastwards, then northwards.
    pub origin: [f64; 2],
    /// Change of the coordinates from a row to the next.
    pub down: [f64; 2],
    /// Change of the coordinates from a column to the next.
    pub right: [f64; 2],
    /// Coordinate reference system, if the file names it by an EPSG code.
    pub system: Option<CoordinateSystem>,
}

/// A coordinate reference system, by its number in the EPSG register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateSystem {
    /// Longitude and latitude in degrees.
    Geographic(u16),
    /// Easting and northing on a map.
    Projected(u16),
}

impl Georeference {
    /// Returns the coordinates of a place given by row and column.
    pub fn coordinates(&self, [row, col]: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| self.origin[k] + row * self.down[k] + col * self.right[k])
    }

    /// Returns row and column of map coordinates, the inverse of [`Georeference::coordinates`]. Both may be
    /// fractional and lie outside the grid. The result is `None` if the map has no inverse, or a coordinate
    /// is not finite.
    pub fn place(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [down, right] = [self.down, self.right];
        let [dx, dy] = [x - self.origin[0], y - self.origin[1]];
        let determinant = down[0] * right[1] - down[1] * right[0];
        let row = (dx * right[1] - dy * right[0]) / determinant;
        let col = (down[0] * dy - down[1] * dx) / determinant;
        (row.is_finite() && col.is_finite()).then_some([row, col])
    }

    /// Checks that both georeferences put the corners of a grid of this size at the same coordinates, up to a tenth of
    /// a cell.
    pub fn agrees(&self, other: &Self, rows: usize, cols: usize) -> Result<(), String> {
        if let (Some(own), Some(other)) = (self.system, other.system)
            && own != other
        {
            return Err(format!(
                "lies in the coordinate system EPSG:{}, the surface in EPSG:{}",
                own.epsg(),
                other.epsg()
            ));
        }
        let ends = |count: usize| [0.0, count.saturating_sub(1) as f64];
        for place in ends(rows).into_iter().flat_map(|row| ends(cols).map(|col| [row, col])) {
            let coordinates = self.coordinates(place);
            let [row, col] = other.place(coordinates).unwrap_or([f64::INFINITY; 2]);
            if (row - place[0]).abs() > SAME_PLACE || (col - place[1]).abs() > SAME_PLACE {
                let (there, [x, y]) = (other.coordinates(place), coordinates);
                return Err(format!(
                    "has row {}, column {} at {x}, {y}, but the surface has it at {}, {}",
                    place[0], place[1], there[0], there[1]
                ));
            }
        }
        Ok(())
    }
}

/// Number of rows or columns by which corners of two equal grids may differ. Files often store rounded numbers.
const SAME_PLACE: f64 = 0.1;

impl CoordinateSystem {
    /// Longitude and latitude on WGS 84, as GPS gives them.
    pub const WGS_84: Self = Self::Geographic(4326);

    /// Returns the EPSG number.
    pub fn epsg(self) -> u16 {
        let (Self::Geographic(epsg) | Self::Projected(epsg)) = self;
        epsg
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn places_and_coordinates_are_inverse(
            origin in prop::array::uniform2(-1e6..1e6f64),
            size in prop::array::uniform2(0.01..100.0f64),
            turn in 0.0..std::f64::consts::TAU,
            mirrored in any::<bool>(),
            place in prop::array::uniform2(-10.0..1000.0f64),
        ) {
            let (sine, cosine) = turn.sin_cos();
            let sign = if mirrored { -1.0 } else { 1.0 };
            let right = [size[0] * cosine, size[0] * sine];
            let down = [-sign * size[1] * sine, sign * size[1] * cosine];
            let map = Georeference { origin, down, right, system: None };
            let found = map.place(map.coordinates(place)).unwrap();
            // Coordinates of 1e6 have a rounding error of 1e-10, which is 1e-8 of a cell of 0.01.
            prop_assert!((0..2).all(|k| (found[k] - place[k]).abs() < 1e-6), "{found:?} {place:?}");
        }
    }

    #[test]
    fn maps_without_an_inverse_have_no_places() {
        let flat =
            Georeference { origin: [0.0; 2], down: [1.0, 2.0], right: [2.0, 4.0], system: None };
        assert_eq!(flat.place([1.0, 1.0]), None);
        let map = Georeference { down: [0.0, -1.0], right: [1.0, 0.0], ..flat };
        assert_eq!(map.place([f64::NAN, 1.0]), None);
        assert_eq!(map.place([3.0, -2.0]), Some([2.0, 3.0]));
    }
}
