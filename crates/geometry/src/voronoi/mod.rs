//! Computes geodesic Voronoi regions: the points nearest to each source (paper, section 6.3).

mod borders;
mod continuation;
mod fronts;
mod guess;
mod known;
mod own_maps;
mod source_fronts;
mod starts;

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::area::{of_triangles, rows};
use super::{Curve, MapError, join_over_seams};
pub use borders::Border;
use borders::Split;
use fronts::Fronts;
use geosweep_surface::Surface;
use geosweep_surface::{EdgeLengths, Sources};
pub use known::NO_REGION;

/// The Voronoi regions of several sources, and the borders between them.
#[derive(Clone, Debug)]
pub struct Voronoi {
    /// The label of each grid point, row-major: the index of its nearest source, or [`NO_REGION`]. Sources
    /// are numbered from 0 in the order in which they were given.
    pub labels: Vec<u32>,
    /// The borders. Each runs from junction to junction. On glued surfaces, borders go on over seams
    /// ([`crate::join_over_seams`]).
    pub borders: Vec<Border>,
    /// The triangles on borders, with the fraction of each region.
    splits: Vec<Split>,
    regions: usize,
}

impl Voronoi {
    /// Computes the Voronoi regions of sources. `distances` is their converged map on this surface, of any engine,
    /// row-major, as in [`geosweep_surface::DistanceMap::distances`]. `edges` are the edge lengths of `surface`.
    ///
    /// A point that is equally far from two sources belongs to the first of them. If two sources are the
    /// same, all their points belong to the first. A region without a grid point is empty.
    ///
    /// Near borders the wavefronts of both sources are propagated across the border: circular ones from
    /// points, and straight ones from curves. The border is where they arrive at once, by linear
    /// interpolation between grid points. So the border is as accurate for sources side by side as for
    /// distant ones. On the plane, the cylinder and the sphere of 129 x 129 points, the border lies within
    /// 0.07 of a cell of the exact bisector of two points, whether they are one cell apart or many. A
    /// junction of three regions lies where three wavefronts arrive at once. It is in a triangle with a
    /// corner in each region, or at most a few triangles away from such a triangle.
    ///
    /// # Errors
    /// If a source lies off the surface, or the number of distances differs from the number of grid points.
    ///
    /// # Panics
    /// If `edges` belong to a surface of another size.
    ///
    /// ```
    /// use geosweep::geometry::Voronoi;
    /// use geosweep::surface::EdgeLengths;
    /// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
    ///
    /// let surface = Surface::from_heights(33, 41, vec![0.0; 33 * 41], Spacing::square(1.0))?;
    /// let sources = Sources::point(16.0, 10.0).and_point(16.0, 31.0, 0.0);
    /// let map = distance_map(&surface, &sources, &Options::default())?;
    /// let edges = EdgeLengths::new(&surface)?;
    /// let regions = Voronoi::new(&surface, &edges, &sources, &map.distances)?;
    /// assert_eq!(regions.neighbours(), [[0, 1]]);
    /// let border = &regions.borders[0].curve;
    /// assert!(border.vertices.iter().all(|at| (at[1] - 20.5).abs() < 1e-3));
    /// assert!((regions.areas(&surface)[0] - 32.0 * 20.5).abs() < 1e-2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        surface: &Surface,
        edges: &EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        assert_eq!(edges.chart(), surface.chart(), "the edges are another surface's");
        let regions = sources.iter().count();
        if let Some(labels) = starts::of_one_source(surface, sources, distances)? {
            return Ok(Self { labels, borders: Vec::new(), splits: Vec::new(), regions });
        }
        let (fronts, labels) = Fronts::new(surface, edges, sources, distances)?;
        let (borders, splits) = borders::march(&fronts, &labels);
        let borders = if surface.is_glued() { over_seams(borders, surface) } else { borders };
        Ok(Self { labels, borders, splits, regions })
    }

    /// Merges regions: region `k` becomes a part of region `numbers[k]`, of `regions` regions. Borders within a merged
    /// region are left out.
    ///
    /// # Panics
    /// If there is not one number for each region, or a number is not below `regions`.
    #[must_use]
    pub fn merged(mut self, numbers: &[u32], regions: usize) -> Self {
        assert_eq!(numbers.len(), self.regions, "one number for each region");
        assert!(numbers.iter().all(|&number| (number as usize) < regions), "a region is missing");
        for label in self.labels.iter_mut().filter(|label| **label != NO_REGION) {
            *label = numbers[*label as usize];
        }
        for Border { regions: [a, b], curve } in &mut self.borders {
            [*a, *b] = [*a, *b].map(|region| numbers[region as usize]);
            if *a > *b {
                // The smaller number is that of the region on the left.
                (*a, *b) = (*b, *a);
                curve.vertices.reverse();
            }
        }
        self.borders.retain(|border| border.regions[0] != border.regions[1]);
        for (label, _) in self.splits.iter_mut().flat_map(|split| &mut split.parts) {
            *label = numbers[*label as usize];
        }
        // A triangle whose corners are of one region now counts as a whole.
        let labels = &self.labels;
        self.splits.retain(|split| {
            let [a, b, c] = split.points.map(|point| labels[point]);
            a != b || b != c
        });
        Self { regions, ..self }
    }

    /// Returns the number of regions: one for each source, empty ones included.
    pub fn regions(&self) -> usize {
        self.regions
    }

    /// Returns the edges of the Delaunay graph: all pairs of regions with a common border, in ascending
    /// order. In each pair the smaller number comes first.
    pub fn neighbours(&self) -> Vec<[u32; 2]> {
        let pairs: BTreeSet<_> = self.borders.iter().map(|border| border.regions).collect();
        pairs.into_iter().collect()
    }

    /// Returns the area of each region on the surface, in the surface's unit squared. A slowness does not
    /// change it.
    ///
    /// Areas are sums over the triangles into which cells are split. A triangle on a border is divided along
    /// the border. The sum of all areas is the area of the part of the surface that the sources reach; if
    /// they reach all of it, it equals [`super::area`].
    ///
    /// # Panics
    /// If `surface` has another size than the regions.
    pub fn areas(&self, surface: &Surface) -> Vec<f64> {
        assert_eq!(surface.chart().points(), self.labels.len(), "the surface has another size");
        let inside = |index: usize| self.labels[index] != NO_REGION;
        // A row of cells meets only a few of the regions.
        let of_row = |row: usize| {
            let mut areas = BTreeMap::<u32, f64>::new();
            for (points, area) in of_triangles(surface, row, inside) {
                let [a, b, c] = points.map(|index| self.labels[index]);
                if a == b && b == c {
                    *areas.entry(a).or_default() += area;
                }
            }
            areas
        };
        // The sums run in row order, so that they do not depend on the number of threads.
        let rows: Vec<_> = rows(surface).map(of_row).collect();
        let mut areas = vec![0.0; self.regions];
        for (label, area) in rows.into_iter().flatten() {
            areas[label as usize] += area;
        }
        for Split { points, parts } in &self.splits {
            let area = surface.geometry().triangle_area(surface.chart(), *points);
            for (label, part) in parts {
                areas[*label as usize] += part * area;
            }
        }
        areas
    }
}

/// Joins the borders between the same two regions over the seams of a surface.
fn over_seams(borders: Vec<Border>, surface: &Surface) -> Vec<Border> {
    let mut by_regions: BTreeMap<[u32; 2], Vec<Curve>> = BTreeMap::new();
    for Border { regions, curve } in borders {
        by_regions.entry(regions).or_default().push(curve);
    }
    let joined = by_regions.into_iter().flat_map(|(regions, curves)| {
        let curves = join_over_seams(curves, surface).into_iter();
        curves.map(move |curve| Border { regions, curve })
    });
    joined.collect()
}
