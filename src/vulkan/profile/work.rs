//! Counts what passes have to move and compute. The counts come from the plan, and from the device's
//! decisions where those are read back.
//!
//! A count covers what the update of a point needs by itself, once. It does not include what workgroups
//! compute twice at their borders, and it does not subtract what caches save. `docs/speed.md` compares the
//! same counts with a device's ceilings.

use crate::vulkan::upload::SEED_BYTES;

/// Bytes, texels and updates of a pass. `None` stands for a number that is unknown, or not counted for passes
/// of this kind.
///
/// The table lists the moved data in numbers of 4 bytes. A number counts once for the texel, place or map
/// that needs it, however many invocations read it.
///
/// | pass | reads | writes |
/// |---|---|---|
/// | prepare, forget | | the images with their border |
/// | points | the values used of each point | the same and its slowness |
/// | edges | the points around the band | four lengths a point |
/// | curvature | four lengths a point, and one number more in the second pass | one number a point |
/// | start | | the progress and six numbers a tile; for a batch a copy of its progress |
/// | resume | six numbers | the progress of rounds, and one number a tile |
/// | sources, by a dispatch | four numbers a source | ten numbers for each of four texels |
/// | sources, by a copy | | four numbers a source |
/// | surroundings | four numbers a source, and 100 texels around it as a scan does | ten numbers a texel |
/// | seed | ten numbers a texel, and both layers of its fronts | its fronts; in a batch all texels' fronts |
/// | scans, tiles | a texel's times, 16 lengths and *curvatures* | times, curved fronts' curvature |
/// | exchange | both layers of each copy's texel, and of each texel with copies | both layers of these texels |
/// | settle | one number a tile, and both layers of the texels that are brought back | the same |
/// | count, before the map is done | seven numbers of the progress | five; two more if it is done now |
/// | count, afterwards | one number | |
/// | fans | the numbers of each pair's fan | the same |
/// | workgroups | the fans of all pairs in all scans, and begun maps | distances, or maps to be continued |
/// | decisions, outcome | the copied bytes | the same |
/// | distances, unpack | each point's time | the same |
/// | lookup | two numbers a place, and the four times around it | one distance a place |
/// | contours: counts | each point's time | one number a row of cells, and one for each of its 64 strips |
/// | contours: offsets | one number a row of cells | the same, and six numbers of the record |
/// | contours: segments | the times and numbers again | `None`: the device finds the segments |
/// | paths: starts | two numbers and four times a start, four numbers a source | 24 a path, three a start |
/// | paths: steps | `None`: depends on how many steps the device takes | `None` |
/// | lift | `None`: depends on how many vertices the device has found | `None` |
/// | regions: clear | | two numbers a point |
/// | regions: sources, twice | four numbers a source | `None`: the device finds the points around sources |
/// | regions: beginnings of ways | two numbers, the time, 4 lengths and *curvatures* | three numbers a point |
/// | regions: ways, then labels | `None`: depends on how many points the ways lead past | `None` |
///
/// With curved fronts, *curvatures* are those of the fronts and of the surface; with others there are none. The entries
/// for paths count all paths for which there is room.
///
/// In a batch, the count that ends the last iteration of a map differs. In place of the two further numbers it reads
/// and writes the number of pending maps, and writes that this map is done. With the last map of the batch it writes
/// two numbers more.
///
/// Places that may be invalid count as valid ones. Sources count as lying inside cells. The four or 100
/// texels around a source count as lying on the grid and as belonging to no other source. Looked-up places
/// and starts of paths count as lying on the grid where the map is reached. There is room for all contours.
/// The counts leave out what depends on positions and is little beside the rest: the lengths of edges around
/// a source, the tiles that seeds and rounds put on lists, the levels that a search for contours examines, the
/// numbers by which rounds are counted, and the four by which blocks past the middle of the grid are due after
/// pairs of scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Number of visited texels, of 2 x 2 points each. A tile counts as a whole even where it reaches beyond
    /// the grid.
    pub texels: Option<u64>,
    /// Number of texels that the pass skipped, and that a pass without bounds would have visited. They are skipped by
    /// the paper's scissor test, by lists of tiles, or because the map has converged. Lines that a scan skips before
    /// its first block count to that block.
    pub skipped: Option<u64>,
    /// Number of bytes read.
    pub bytes_read: Option<u64>,
    /// Number of bytes written.
    pub bytes_written: Option<u64>,
    /// Number of updates of a point from one triangle.
    pub triangles: Option<u64>,
}

/// Bytes of a texel of four 32-bit numbers.
const TEXEL: u64 = 16;
/// Points of a texel times the triangles of a point that a scan uses.
const SCAN_TRIANGLES: u64 = 4 * 2;

impl Work {
    /// Returns the bytes read and written.
    pub fn bytes(&self) -> Option<u64> {
        Some(self.bytes_read? + self.bytes_written?)
    }

    /// Returns the sum of the work of two passes that visit texels.
    pub(super) fn and(self, other: Self) -> Self {
        let sum = |a: Option<u64>, b: Option<u64>| Some(a? + b?);
        Self {
            texels: sum(self.texels, other.texels),
            skipped: sum(self.skipped, other.skipped),
            bytes_read: sum(self.bytes_read, other.bytes_read),
            bytes_written: sum(self.bytes_written, other.bytes_written),
            triangles: sum(self.triangles, other.triangles),
        }
    }

    /// Returns this work plus the known bytes of a pass that visits no texels.
    pub(crate) fn and_bytes(self, other: Self) -> Self {
        let sum = |a: Option<u64>, b: Option<u64>| Some(a? + b.unwrap_or(0));
        Self {
            bytes_read: sum(self.bytes_read, other.bytes_read),
            bytes_written: sum(self.bytes_written, other.bytes_written),
            ..self
        }
    }

    /// Returns the known bytes of two passes that visit no texels.
    pub(super) fn and_known_bytes(self, other: Self) -> Self {
        let sum = |a: Option<u64>, b: Option<u64>| a.map_or(b, |a| Some(a + b.unwrap_or(0)));
        Self {
            bytes_read: sum(self.bytes_read, other.bytes_read),
            bytes_written: sum(self.bytes_written, other.bytes_written),
            ..self
        }
    }

    /// Returns work that consists of bytes only.
    pub(crate) const fn of_bytes(read: u64, written: u64) -> Self {
        Self {
            texels: None,
            skipped: None,
            bytes_read: Some(read),
            bytes_written: Some(written),
            triangles: None,
        }
    }

    /// Returns the work of updating texels. The arrival times of a texel's points are read and written, and
    /// the lengths of their edges are read. With curved fronts their curvature is read and written too, and
    /// the surface's is read.
    pub(super) fn of_updates(
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

    /// Returns the work of updating texels in a scan.
    pub(super) fn of_scan(texels: u64, skipped: u64, curved: bool) -> Self {
        Self::of_updates(texels, skipped, curved, Some(SCAN_TRIANGLES))
    }

    /// Returns the bytes that are read and written to solve the surroundings of sources, `each` texels around a source.
    /// These texels are read once, updated as often as necessary, and written as seeds.
    pub(crate) fn of_surroundings(sources: u64, each: u64, curved: bool) -> [Option<u64>; 2] {
        let Self { bytes_read, .. } = Self::of_updates(sources * each, 0, curved, None);
        let places = sources * size_of::<[f32; 4]>() as u64;
        [bytes_read.map(|read| read + places), Some(sources * each * SEED_BYTES)]
    }

    /// Returns this work without that of texels that were not visited.
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

    /// Returns the work of `maps` of the `all` maps of a batch, given the work of one. All maps visit the
    /// same texels.
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

    /// Returns the work of a pass over the same texels that visits none of them.
    pub(super) fn none(self) -> Self {
        self.of_maps(0, 1)
    }
}
