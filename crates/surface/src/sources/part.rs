//! Finds the seeds of a source separately for each part, which never crosses a seam.

use std::collections::BTreeSet;

use glam::DVec2;

use super::course::{Segment, parts};
use super::error::SourceError;
use super::origin::Origin;
use super::pieces::{Pieces, check_inside};
use super::seed::Seed;
use super::source::Source;
use crate::{Sheet, Surface};

/// Number of rows and columns around a part on which its seeds depend.
const AROUND: usize = 4;

/// Segments of a source without a jump over a seam between them.
pub struct SourcePart {
    segments: Vec<Segment>,
    /// Position of the source in the seeds of all parts of a point source.
    name: Option<DVec2>,
}

impl SourcePart {
    /// Returns the parts of a source.
    ///
    /// A point source on an edge of a seam has a part at each of its copies. A curve along a seam has a part on each
    /// side of the seam, except where the grid goes on over the seam: there the sheet around the part on one side holds
    /// the other side too.
    pub(super) fn all(surface: &Surface, source: &Source) -> Vec<Self> {
        match source {
            Source::Point { at, initial } => {
                let copies = surface.copies_of(*at);
                // At a grid point one copy is enough: solvers give all copies of a point the same front.
                let is_grid_point = at.fract() == DVec2::ZERO;
                let seen = if is_grid_point { 1 } else { copies.len() };
                let name = (copies.len() > 1).then_some(copies[0]);
                let point = |&at: &DVec2| Segment::point(at, Origin::point(at, *initial));
                let part = |at: &DVec2| Self { segments: vec![point(at)], name };
                copies.iter().take(seen).map(part).collect()
            }
            Source::Curve { vertices, initial } => {
                let mut all = parts(surface, vertices, *initial);
                let others = all.iter().flatten().flat_map(|&part| beyond_seam(surface, part));
                let others: Vec<_> = others.map(|segment| vec![segment]).collect();
                all.extend(others);
                all.into_iter().map(|segments| Self { segments, name: None }).collect()
            }
        }
    }

    /// Returns the part's first place.
    pub(super) fn first(&self) -> DVec2 {
        self.segments[0].ends[0].0
    }

    /// Cuts the part into pieces on a sheet around it.
    fn placed<'a>(&self, surface: &'a Surface) -> Result<Placed<'a>, SourceError> {
        let places = || self.segments.iter().flat_map(|segment| segment.ends.map(|(at, _)| at));
        places().try_for_each(|at| check_inside(surface, at))?;
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        let span = |low: f64, high: f64| [low as usize, high.ceil() as usize];
        let sheet = surface.sheet_over_seams(span(low.x, high.x), span(low.y, high.y), AROUND);
        let mut pieces = Pieces::default();
        for segment in &self.segments {
            let segment = moved(*segment, |at| sheet.local(at));
            pieces.add(sheet.part(), segment).map_err(|error| on_grid(&sheet, error))?;
        }
        Ok(Placed { sheet, pieces, name: self.name })
    }
}

/// Returns the initial values at the corners of the cells that the parts of a source touch. A corner may have several
/// initial values.
pub(super) fn seeds(
    surface: &Surface,
    parts: &[SourcePart],
    initial: f64,
) -> Result<Vec<Seed>, SourceError> {
    let parts: Vec<_> = parts.iter().map(|part| part.placed(surface)).collect::<Result<_, _>>()?;
    if let [part] = &parts[..] {
        let corners = part.pieces.corners(part.sheet.part()).into_iter();
        return Ok(corners.filter_map(|local| part.seed(local, initial)).collect());
    }
    // A corner of the cells that one part touches may be nearer to another part, which does not touch these cells.
    let name = |part: &Placed<'_>, local| surface.first_copy(part.sheet.point(local));
    let corners: BTreeSet<_> = parts
        .iter()
        .flat_map(|part| {
            part.pieces.corners(part.sheet.part()).into_iter().map(|at| name(part, at))
        })
        .collect();
    let of_part = |part: &Placed<'_>| -> Vec<Seed> {
        let near = part.pieces.around(part.sheet.part()).into_iter();
        let near = near.filter(|&local| corners.contains(&name(part, local)));
        near.filter_map(|local| part.seed(local, initial)).collect()
    };
    Ok(parts.iter().flat_map(of_part).collect())
}

/// A part on a sheet around it.
struct Placed<'a> {
    sheet: Sheet<'a>,
    pieces: Pieces,
    name: Option<DVec2>,
}

impl Placed<'_> {
    /// Returns the initial value on the whole grid at a point of the sheet, if a piece is near.
    fn seed(&self, (row, col): (usize, usize), initial: f64) -> Option<Seed> {
        let seed = self.pieces.seed(self.sheet.part(), row, col, initial)?;
        let heading = seed.heading.turned(self.sheet.turn((row, col)));
        let (row, col) = self.sheet.point((row, col));
        let named = |at: DVec2| self.name.unwrap_or_else(|| self.sheet.place(at));
        let origin = seed.origin.map(|origin| Origin { ends: origin.ends.map(named), ..origin });
        Some(Seed { row, col, from: seed.from.map(named), origin, heading, ..seed })
    }
}

/// Converts the place that an error names from the sheet to the whole grid.
fn on_grid(sheet: &Sheet<'_>, error: SourceError) -> SourceError {
    match error {
        SourceError::Hole { row, col } => {
            let at = sheet.place(DVec2::new(row, col));
            SourceError::Hole { row: at.x, col: at.y }
        }
        other => other,
    }
}

/// Returns a segment with its places converted by `to`.
fn moved(segment: Segment, to: impl Fn(DVec2) -> DVec2) -> Segment {
    let origin = segment.origin.map(|origin| Origin { ends: origin.ends.map(&to), ..origin });
    Segment { origin, ..segment.between(segment.ends.map(|(at, _)| to(at))) }
}

/// Returns the copies of a segment along a seam beyond which the grid does not go on.
fn beyond_seam(surface: &Surface, segment: Segment) -> Vec<Segment> {
    if !surface.is_glued() {
        return Vec::new();
    }
    let places = segment.ends.map(|(at, _)| at);
    let [from, to] = places.map(|at| surface.copies_of(at));
    let middle = surface.copies_of(places[0].midpoint(places[1]));
    let is_copy = |ends: &[DVec2; 2]| {
        let half = ends[0].midpoint(ends[1]);
        *ends != places
            && surface.turn_at_copy(places[0], ends[0]).is_none()
            && middle.iter().any(|copy| copy.distance(half) <= 1e-6)
    };
    let pairs = from.iter().flat_map(|&from| to.iter().map(move |&to| [from, to]));
    let copy = |ends: [DVec2; 2]| {
        let origin = segment.origin.map(|origin| Origin { ends, ..origin });
        Segment { origin, ..segment.between(ends) }
    };
    pairs.filter(is_copy).map(copy).collect()
}
