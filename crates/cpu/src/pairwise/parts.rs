//! Updates points through parts of their obtuse triangles, in SIMD lanes.

use super::kernel::{Kernel, LANES, Lanes, merged};
use super::marks::WORD;
use crate::scan::Scan;
use geosweep_surface::lanes::Loop;
use geosweep_surface::{EdgeLengths, min};

/// The parts of the obtuse triangles of a scan, in the scan's order of points along a line.
pub(super) struct LaneParts<K: Kernel> {
    /// Start of each line's parts; empty if there are no parts.
    starts: Vec<u32>,
    parts: Vec<LanePart<K::Part>>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct LanePart<P> {
    /// Position of the point in the line.
    point: u32,
    /// The two other corners, as indices into the bordered array.
    corners: [u32; 2],
    coefficients: P,
}

impl<K: Kernel> LaneParts<K> {
    pub(super) fn new(edges: &EdgeLengths<f32>, scan: Scan) -> Self {
        let (mut starts, mut all) = (Vec::new(), Vec::new());
        if let Some(parts) = edges.parts_on_side(scan.back()) {
            let lines = edges.chart().by(scan.lines());
            starts.push(0);
            for line in 0..lines.rows {
                let of_line = parts.within(line + 1, 1..lines.cols + 1);
                for (place, parts) in of_line.parts() {
                    all.extend(parts.map(|part| LanePart {
                        point: place as u32 - 1,
                        corners: part.corners.map(|corner| corner as u32),
                        coefficients: K::part(part.lengths),
                    }));
                }
                starts.push(all.len() as u32);
            }
        }
        Self { starts, parts: all }
    }

    pub(super) fn bytes(&self) -> usize {
        self.starts.len() * size_of::<u32>() + self.parts.len() * size_of::<LanePart<K::Part>>()
    }

    /// Returns the parts of a line.
    pub(super) fn of_line(&self, line: usize) -> &[LanePart<K::Part>] {
        match self.starts.get(line..line + 2) {
            Some(&[start, end]) => &self.parts[start as usize..end as usize],
            _ => &[],
        }
    }
}

/// The update of the marked points of a line through parts of their triangles.
pub(super) struct VisitParts<'a, K: Kernel, const TRACKS: bool> {
    pub points: &'a mut [Lanes],
    /// The first point of the line, and the offset from a point to the next.
    pub first: usize,
    pub step: usize,
    pub parts: &'a [LanePart<K::Part>],
    pub marks: &'a [u64],
    /// Marks of the points that have changed by more than `wakes`; see [`Lanes::lower`].
    pub changed: &'a mut [u64],
    pub wakes: u32,
    /// A mask for each map, with all bits set if the scan passes the line in that map.
    pub maps: [u32; LANES],
}

impl<K: Kernel, const TRACKS: bool> Loop for VisitParts<'_, K, TRACKS> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let Self { points, first, step, mut parts, marks, changed, wakes, maps } = self;
        let mut largest = [0; LANES];
        while let &[LanePart { point, .. }, ..] = parts {
            let of_point = parts.iter().take_while(|part| part.point == point).count();
            let (these, others) = parts.split_at(of_point);
            parts = others;
            let (word, bit) = (point as usize / WORD, point as usize % WORD);
            if marks[word] >> bit & 1 == 0 {
                continue;
            }
            let mut times = Lanes::UNREACHED;
            for part in these {
                let ends = part.corners.map(|corner| points[corner as usize]);
                let arrivals = K::through(ends.each_ref(), &part.coefficients);
                for lane in 0..LANES {
                    times.0[lane] = min(times.0[lane], arrivals.0[lane]);
                }
            }
            let here = first + point as usize * step;
            let old = points[here];
            let mut is_earlier = false;
            for lane in 0..LANES {
                is_earlier |= times.0[lane] < old.0[lane];
            }
            if is_earlier {
                let mut state = old;
                let wakes_others = state.lower::<TRACKS>(times, wakes, &mut largest);
                changed[word] |= u64::from(wakes_others) << bit;
                points[here] = merged(state, old, maps);
            }
        }
        if TRACKS { largest.into_iter().max().unwrap_or_default() } else { u32::MAX }
    }
}
