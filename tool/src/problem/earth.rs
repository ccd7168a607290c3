//! Makes a surface on the Earth from the grid of a file. The surface may have one more row at each pole, and one more
//! column where the grid goes round the Earth.

use geosweep::io::Georeference;
use geosweep::surface::{Chart, Ellipsoid, GeodeticGrid, SurfaceError};

use super::given::GivenGrid;

/// The grid of a file on the Earth.
pub struct Earth {
    pub grid: GeodeticGrid,
    /// The size of the given grid.
    pub chart: Chart,
    /// The given grid in longitudes and latitudes.
    georeference: Georeference,
    /// Whether each given point is present.
    present: Vec<bool>,
}

impl Earth {
    /// Makes the grid of points at the longitudes and latitudes of a georeference on an ellipsoid. NaN in `heights` marks
    /// holes.
    pub fn new(
        georeference: &Georeference,
        ellipsoid: Ellipsoid,
        chart: Chart,
        heights: &[f64],
    ) -> Result<Self, String> {
        let at = |row: usize, col: usize| georeference.coordinates([row as f64, col as f64]);
        let latitudes: Vec<_> = (0..chart.rows).map(|row| at(row, 0)[1]).collect();
        let longitudes: Vec<_> = (0..chart.cols).map(|col| at(0, col)[0]).collect();
        let grid = GeodeticGrid::new(&latitudes, &longitudes).map_err(|error| error.to_string())?;
        let grid = grid.with_ellipsoid(ellipsoid);
        let present = heights.iter().map(|height| !height.is_nan()).collect();
        Ok(Self { grid, chart, georeference: *georeference, present })
    }

    /// Returns the given grid. Its frame has margins that reach to the ends of the surface.
    pub fn given(&self) -> GivenGrid {
        let lines = self.grid.lines().clone();
        let given = GivenGrid::new(lines, Ok(self.georeference), self.grid.goes_round());
        GivenGrid { frame: given.frame.in_degrees(), ..given }
    }

    /// Makes holes of the given points that `mask` leaves out, and returns a mask of all points of the surface. A
    /// pole is present if any point of the row beside it is.
    pub fn mask(&mut self, mask: &[bool]) -> Vec<bool> {
        self.present.iter_mut().zip(mask).for_each(|(present, &keep)| *present &= keep);
        let values = self.without_holes(&vec![1.0; mask.len()]);
        self.grid.lines().extend(&values).into_iter().map(|value| !value.is_nan()).collect()
    }

    /// Returns the slowness of all points of the surface. A pole has the mean of the row beside it, so negative
    /// values are refused before they enter a mean.
    pub fn slowness(&self, given: &[f64]) -> Result<Vec<f64>, SurfaceError> {
        let given = self.without_holes(given);
        match given.iter().position(|&value| value < 0.0) {
            None => Ok(self.grid.lines().extend(&given)),
            Some(index) => {
                let ((row, col), value) = (self.chart.position(index), given[index]);
                Err(SurfaceError::Slowness { value, row, col })
            }
        }
    }

    /// Returns values at the given points, with NaN at holes.
    fn without_holes(&self, values: &[f64]) -> Vec<f64> {
        let value = |(&value, &present)| if present { value } else { f64::NAN };
        values.iter().zip(&self.present).map(value).collect()
    }
}
