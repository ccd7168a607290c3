//! Finds the nearest of many points with a single map from one place.

use crate::surface::Surface;
use crate::{Error, Options, Sources, Targets, distance_map};

/// A point of a list, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearPoint {
    /// The index of the point in the list.
    pub index: usize,
    /// The distance.
    pub distance: f32,
}

/// Finds the `count` of the given grid points (rows and columns) nearest to a place (row and column), in order of
/// distance. Points at equal distances come in the order of the list. Points farther than the radius of `options`, and
/// those that no path reaches, are left out. So the result may be shorter, or empty.
///
/// Distances are symmetric, so a single map from the place suffices. It is computed only as far as the nearest points.
///
/// ```
/// use geosweep::pairwise::nearest_points;
/// use geosweep::{Options, Spacing, Surface};
///
/// let surface = Surface::from_heights(30, 30, vec![0.0; 900], Spacing::square(1.0))?;
/// let wells = [[25, 20], [3, 4], [10, 17], [10, 3]];
/// let found = nearest_points(&surface, [10.0, 10.0], &wells, 2, &Options::default())?;
/// let found: Vec<_> = found.iter().map(|near| (near.index, near.distance)).collect();
/// assert_eq!(found, [(2, 7.0), (3, 7.0)]);
/// # Ok::<(), geosweep::Error>(())
/// ```
///
/// # Errors
/// The errors of [`distance_map`]. It is also an error if the place or one of the points is not on the surface,
/// `count` is 0 or the options have targets of their own.
pub fn nearest_points(
    surface: &Surface,
    place: [f64; 2],
    points: &[[usize; 2]],
    count: usize,
    options: &Options,
) -> Result<Vec<NearPoint>, Error> {
    let fault = |message: &str| Err(Error::Options(message.into()));
    if options.targets.is_some() {
        return fault("the targets of this search are the points; leave other targets out");
    }
    if count == 0 {
        return fault("no point was asked for; ask for 1 or more");
    }
    let targets = Targets::nearest(count, points.iter().copied());
    let options = options.clone().with_targets(targets);
    let map = distance_map(surface, &Sources::point(place[0], place[1]), &options)?;
    let distances = points.iter().map(|&[row, col]| map.distance(row, col)).enumerate();
    let reached = distances.filter(|(_, distance)| distance.is_finite());
    let mut near: Vec<_> = reached.map(|(index, distance)| NearPoint { index, distance }).collect();
    near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    near.truncate(count);
    Ok(near)
}
