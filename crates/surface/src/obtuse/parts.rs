//! Stores the parts of all obtuse triangles ([`EdgeLengths::split`](crate::EdgeLengths::split)) of a
//! surface, in the order in which scans visit them.

use std::ops::Range;
use std::sync::OnceLock;

use crate::real::Real;

/// The parts of all obtuse triangles, by the side of their point on which they lie. They are computed for calls that
/// solve several maps. For a single map they are computed if at most a quarter of the points have obtuse triangles, or
/// once the map has taken more than a few iterations. `None` in the lock means that there are no such triangles, or too
/// many to store.
#[derive(Clone, Debug)]
pub(crate) struct SplitParts<R>(pub(super) OnceLock<Option<[SideParts<R>; 4]>>);

impl<R> Default for SplitParts<R> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<R: Real> SplitParts<R> {
    /// Returns the number of bytes held.
    #[inline]
    pub(crate) fn bytes(&self) -> usize {
        let sides = self.0.get().and_then(Option::as_ref);
        sides.map_or(0, |sides| sides.iter().map(SideParts::bytes).sum())
    }
}

/// The obtuse triangles on one side of their points, with their parts. On each side a point has two
/// triangles, which share the edge to the neighbour there.
///
/// Triangles are sorted by their points: line by line, and along lines. Lines are rows where that neighbour lies in
/// another row, else columns. Index 0 of lines, and of places in a line, is the border.
#[derive(Clone, Debug)]
pub struct SideParts<R> {
    /// Bands of [`LINES`] lines; the last may have fewer.
    pub(super) bands: Vec<Band<R>>,
}

/// Number of adjacent lines whose parts a thread finds together.
pub(super) const LINES: usize = 16;

/// The obtuse triangles of adjacent lines.
#[derive(Clone, Debug, Default)]
pub(super) struct Band<R> {
    /// Index of the first triangle of each line of the band, followed by the number of all triangles of the band. Empty
    /// if no point of the band has an obtuse triangle.
    pub(super) starts: Vec<u32>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) parts: Vec<Stored<R>>,
    /// For each part, the slowness that counts at x0, x1 and x2. The part's lengths are distances times the mean
    /// slowness of their ends. Empty on surfaces without a slowness.
    pub(super) slowness: Vec<[R; 3]>,
}

/// An obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Position of the point in its line.
    pub(super) place: u32,
    /// Index after the triangle's last part. Its first part follows the parts of the triangle before. A triangle may
    /// have no part.
    pub(super) end: u32,
}

/// Stored form of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored<R> {
    pub(super) corners: [u32; 2],
    pub(super) lengths: [R; 3],
}

/// A part of an obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub struct SplitPart<R> {
    /// The two other corners, as indices into the bordered array.
    pub corners: [usize; 2],
    /// Lengths of x0 x1, x0 x2 and x1 x2.
    pub lengths: [R; 3],
    /// Slowness that counts at x0, x1 and x2. The lengths include it. It is 1 on surfaces without a slowness.
    pub slowness: [R; 3],
}

/// Successive obtuse triangles of a line.
#[derive(Clone, Debug)]
pub struct SplitTriangles<'a, R> {
    band: &'a Band<R>,
    triangles: Range<usize>,
}

impl<'a, R: Real> SplitTriangles<'a, R> {
    #[doc(hidden)]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Returns, for each triangle, its parts and the place of its point in the line, counted from the border.
    #[doc(hidden)]
    pub fn parts(
        self,
    ) -> impl Iterator<Item = (usize, impl Iterator<Item = SplitPart<R>> + use<'a, R>)> + use<'a, R>
    {
        let Self { band, triangles } = self;
        let part = move |at: usize| {
            let Stored { corners, lengths } = band.parts[at];
            SplitPart {
                corners: corners.map(|corner| corner as usize),
                lengths,
                slowness: band.slowness.get(at).copied().unwrap_or([R::one(); 3]),
            }
        };
        let place = |triangle: usize| band.triangles[triangle].place as usize;
        triangles.map(move |triangle| (place(triangle), band.parts_of(triangle).map(part)))
    }
}

impl<R: Real> SideParts<R> {
    /// Returns the obtuse triangles of the points of a line whose places lie in `range`.
    #[inline]
    #[doc(hidden)]
    pub fn within(&self, line: usize, range: Range<usize>) -> SplitTriangles<'_, R> {
        let band = &self.bands[line / LINES];
        // Most bands and most lines have no obtuse triangle.
        let of_line = match band.starts.get(line % LINES..line % LINES + 2) {
            Some(&[start, end]) if start < end => start as usize..end as usize,
            _ => return SplitTriangles { band, triangles: 0..0 },
        };
        let triangles = &band.triangles[of_line.clone()];
        let before = |end: usize| {
            of_line.start + triangles.partition_point(|triangle| (triangle.place as usize) < end)
        };
        SplitTriangles { band, triangles: before(range.start)..before(range.end) }
    }

    fn bytes(&self) -> usize {
        self.bands.iter().map(|band| size_of_val(band) + band.bytes()).sum()
    }
}

impl<R: Real> Band<R> {
    fn parts_of(&self, triangle: usize) -> Range<usize> {
        let start = triangle.checked_sub(1).map_or(0, |before| self.triangles[before].end);
        start as usize..self.triangles[triangle].end as usize
    }

    fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.parts.as_slice())
            + size_of_val(self.slowness.as_slice())
    }
}
