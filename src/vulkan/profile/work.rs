//! What passes have to move and compute, counted from the plan, and from what the device has
//! decided where that is read back.
//!
//! Counted is what the update of a point needs by itself, once: what workgroups compute twice at
//! their borders is not added, and what caches save is not subtracted. `docs/speed.md` compares
//! the same counts with a device's ceilings.

use crate::vulkan::upload::SEED_BYTES;

/// Bytes, texels and updates of a pass; `None` for what is not known, or not counted for passes of
/// its kind.
///
/// What is moved, in numbers of 4 bytes. One counts once for the texel, place or map that needs it,
/// however many invocations look at it:
///
/// | pass | reads | writes |
/// |---|---|---|
/// | prepare, forget | | the images, their border too |
/// | points | of each point what is looked at | that and its slowness |
/// | edges | the points around the band | four lengths a point |
/// | curvature | four lengths a point; in the second pass a number more | a number a point |
/// | start | | the progress, and six numbers a tile; many maps at once: a copy of their progress |
/// | resume | six numbers | the progress of rounds, and a number a tile |
/// | sources | as a dispatch four numbers each | ten for each of four texels; as a copy four each |
/// | surroundings | four numbers a source, and of each of 100 texels around it its times and 16 lengths; with curved fronts their curvature and the surface's | ten for each of these texels |
/// | seed | ten numbers a texel, both layers of its fronts | its fronts; many maps at once: those of all |
/// | scans, all points, tiles | a texel's times and 16 lengths; with curved fronts their curvature and the surface's | times; with curved fronts their curvature |
/// | settle | a number a tile, and both layers of the texels that are brought back | the same |
/// | count | of a map that goes on seven numbers of its progress, of one that is done one | five, and two more if it is done now; or none |
/// | fans | the numbers of each pair's fan | the same |
/// | workgroups | the fans of all pairs in all scans, and maps that were begun before | distances, or maps to go on with |
/// | decisions, outcome | what is copied | the same |
/// | distances, unpack | each point's time | the same |
/// | lookup | of each place two numbers, and four times around it | a distance |
/// | contours: counts | each point's time | a number for each row of cells, and for each of its 64 strips |
/// | their offsets | a number for each row of cells | the same, and six of the record |
/// | their segments | times and numbers again | `None`: as many as the device finds |
/// | paths: starts | of each two numbers and four times, and four numbers of each source | 24 numbers for each that there is room for, three for each start |
/// | their steps | `None`: as many as the device takes | `None` |
/// | lift | `None`: as many vertices as the device has found | `None` |
/// | regions: as a clear | | two numbers a point |
/// | their sources, twice | four numbers each | `None`: as many points as lie around them |
/// | the beginnings of ways | of each point two numbers, its time and four lengths; with curved fronts their curvature and the surface's | three numbers |
/// | the ways, then what is left | `None`: as many points as the ways lead past | `None` |
///
/// With many maps at once, the count by which one is done reads and writes how many are pending and
/// writes that this one is not, and with the last of them two numbers more, in place of the two.
///
/// Where a place may be bad, it counts as if it were good: sources lie inside cells, the texels around one,
/// four or 100, lie on the grid and are no other source's, places looked up and starts lie on the grid where
/// the map is reached, and there is room for all contours. Not counted is what depends on where things lie,
/// and is little beside the rest: the lengths of edges around a source, the tiles that seeds and rounds put
/// on lists, the levels that a search for contours looks at, and the numbers by which rounds are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Texels visited, of 2 x 2 points each. Tiles count whole, also where they reach beyond the
    /// grid.
    pub texels: Option<u64>,
    /// Texels that a pass without bounds would have visited as well: the gain of the paper's
    /// scissor test, of lists of tiles, and of passes beyond convergence. The lines that a scan
    /// passes over before its first block count to that block.
    pub skipped: Option<u64>,
    /// Bytes read.
    pub bytes_read: Option<u64>,
    /// Bytes written.
    pub bytes_written: Option<u64>,
    /// Updates of a point from one triangle.
    pub triangles: Option<u64>,
}

/// Bytes of a texel of four 32-bit numbers.
const TEXEL: u64 = 16;
/// Triangles of a point that a scan sees, times the points of a texel.
const SCAN_TRIANGLES: u64 = 4 * 2;

impl Work {
    /// Bytes read and written.
    pub fn bytes(&self) -> Option<u64> {
        Some(self.bytes_read? + self.bytes_written?)
    }

    /// Of both, the other of the same kind or a count of an iteration, which visits no texels.
    pub(crate) fn and(self, other: Self) -> Self {
        let sum = |a: Option<u64>, b: Option<u64>| Some(a? + b?);
        let visits = |a: Option<u64>, b: Option<u64>| Some(a? + b.unwrap_or(0));
        Self {
            texels: visits(self.texels, other.texels),
            skipped: visits(self.skipped, other.skipped),
            bytes_read: sum(self.bytes_read, other.bytes_read),
            bytes_written: sum(self.bytes_written, other.bytes_written),
            triangles: visits(self.triangles, other.triangles),
        }
    }

    /// Nothing but bytes.
    pub(crate) const fn of_bytes(read: u64, written: u64) -> Self {
        Self {
            texels: None,
            skipped: None,
            bytes_read: Some(read),
            bytes_written: Some(written),
            triangles: None,
        }
    }

    /// Of texels that are updated: arrival times of the texel's points read and written and the
    /// lengths of their edges read; with curved fronts their curvature and the surface's as well.
    pub(crate) fn of_updates(
        texels: u64,
        skipped: u64,
        curved: bool,
        triangles: Option<u64>,
    ) -> Self {
        let layers = if curved { 2 } else { 1 };
        let read = TEXEL * (layers + 4 + u64::from(curved));
        Self {
            texels: Some(texels),
            skipped: Some(skipped),
            bytes_read: Some(texels * read),
            bytes_written: Some(texels * layers * TEXEL),
            triangles: triangles.map(|each| texels * each),
        }
    }

    /// Of texels that a scan updates.
    pub(crate) fn of_scan(texels: u64, skipped: u64, curved: bool) -> Self {
        Self::of_updates(texels, skipped, curved, Some(SCAN_TRIANGLES))
    }

    /// Of the texels around so many sources, so many around each, which are read once, updated as often as it
    /// takes, and written as seeds.
    pub(crate) fn of_surroundings(sources: u64, each: u64, curved: bool) -> Self {
        let Self { bytes_read, .. } = Self::of_updates(sources * each, 0, curved, None);
        let places = sources * size_of::<[f32; 4]>() as u64;
        let seeds = sources * each * SEED_BYTES;
        Self { bytes_read: bytes_read.map(|read| read + places), ..Self::of_bytes(0, seeds) }
    }

    /// The same, but for texels that have not been visited.
    pub(super) fn without(self, unvisited: Self) -> Self {
        let less = |a: Option<u64>, b: Option<u64>| Some(a? - b?);
        Self {
            texels: less(self.texels, unvisited.texels),
            skipped: self.skipped.zip(unvisited.texels).map(|(a, b)| a + b),
            bytes_read: less(self.bytes_read, unvisited.bytes_read),
            bytes_written: less(self.bytes_written, unvisited.bytes_written),
            triangles: less(self.triangles, unvisited.triangles),
        }
    }

    /// What one map takes, of so many of `all` maps of a batch that visit the same texels.
    pub(crate) fn of_maps(self, maps: u64, all: u64) -> Self {
        let each = |count: Option<u64>| Some(count? * maps);
        let texels = each(self.texels);
        let everywhere = self.texels.zip(self.skipped).map(|(texels, skipped)| texels + skipped);
        Self {
            texels,
            skipped: everywhere.zip(texels).map(|(each, visited)| each * all - visited),
            bytes_read: each(self.bytes_read),
            bytes_written: each(self.bytes_written),
            triangles: each(self.triangles),
        }
    }

    /// Of the same texels, none visited.
    pub(super) fn none(self) -> Self {
        let skipped = self.texels.zip(self.skipped).map(|(texels, skipped)| texels + skipped);
        let zero = |count: Option<u64>| count.map(|_| 0);
        Self {
            texels: zero(self.texels),
            skipped,
            bytes_read: zero(self.bytes_read),
            bytes_written: zero(self.bytes_written),
            triangles: zero(self.triangles),
        }
    }
}
