//! Where a grid of heights lies on the Earth.

/// A place on the Earth for each place of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeference {
    /// Coordinates at row 0, column 0; eastwards, then northwards.
    pub origin: [f64; 2],
    /// How they change from a row to the next...
    pub down: [f64; 2],
    /// ... and from a column to the next.
    pub right: [f64; 2],
    /// What the coordinates are.
    pub system: CoordinateSystem,
}

/// A coordinate reference system by its number in the EPSG register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateSystem {
    /// Longitude and latitude in degrees.
    Geographic(u16),
    /// Easting and northing on a map.
    Projected(u16),
}

impl Georeference {
    /// Coordinates of a place given by row and column.
    pub fn coordinates(&self, [row, col]: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| self.origin[k] + row * self.down[k] + col * self.right[k])
    }
}

impl CoordinateSystem {
    /// Longitude and latitude on WGS 84, as GPS gives them.
    pub const WGS_84: Self = Self::Geographic(4326);

    /// The EPSG number.
    pub fn epsg(self) -> u16 {
        let (Self::Geographic(epsg) | Self::Projected(epsg)) = self;
        epsg
    }
}
