//! Defines patches, and the messages that their visits exchange.

use crate::lines::window::Window;
use crate::progress::Progress;
use crate::rotated::tiles::Tiles;
use geosweep_surface::{Block, Real};

/// A part of the grid that is visited as a whole.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// The points of the patch.
    pub block: Block,
    /// The patch and the tiles around it.
    pub window: Window,
    /// The tiles of the window, with the changes that the patch's scans have not seen yet.
    pub tiles: Tiles,
    pub progress: Progress,
}

/// A patch along whose border something has changed.
pub(super) struct Woken<'p, R: Real> {
    pub number: usize,
    pub patch: &'p mut Patch,
    /// The time of the earliest front whose change has been passed on to the patch.
    pub time: R,
    /// Number of points that were examined, and whether a scan has work.
    pub looked: u64,
    pub is_due: bool,
}

/// A change that is reported to a patch: of a tile along its border, or of a point that has copies beyond a seam.
#[derive(Clone, Copy, Debug)]
pub(super) struct News<R: Real> {
    /// Number of the patch that sees the change.
    pub to: usize,
    /// A point of the tile, or the point that has copies.
    pub at: (usize, usize),
    /// The earliest time of a front that has changed, and the largest change.
    pub time: R,
    pub change: R::Bits,
}
