//! Adds the lines between the faces of a cube that has its values at the middles of texels.

use super::super::gluing::Groups;
use super::super::{Chart, Direction, Gluing, GluingError, GridSide, Run, Surface, SurfaceError};
use super::added::Added;
use super::axis::Axis;
use super::grid::CompletedGrid;
use super::layout::mean;

/// Arrangements of six faces in a grid, as rows and columns of faces.
const ARRANGEMENTS: [[usize; 2]; 6] = [[2, 3], [3, 2], [1, 6], [6, 1], [3, 4], [4, 3]];
const FACES: usize = 6;
/// Smallest number of texels along a face.
const LEAST_TEXELS: usize = 4;
/// Largest distance between the texels on both sides of an edge, in steps between texels beside it.
const FARTHEST: f64 = 2.0;

const SIDES: [GridSide; 4] =
    [GridSide::FirstRow, GridSide::LastRow, GridSide::FirstColumn, GridSide::LastColumn];

/// The faces of a cube in a grid.
struct Faces {
    rows: Axis,
    cols: Axis,
    given: Chart,
    completed: Chart,
    /// Row and column of each face that has points, counted in faces.
    blocks: Vec<[usize; 2]>,
}

/// A side of a face.
#[derive(Clone, Copy, PartialEq)]
struct FaceSide {
    face: usize,
    side: GridSide,
}

/// Two sides that meet, and whether the first point of one meets the last of the other.
struct Edge {
    sides: [FaceSide; 2],
    reversed: bool,
}

/// Completes the grid of the faces of a cube.
pub(super) fn completed(surface: &Surface) -> Result<CompletedGrid, SurfaceError> {
    if !surface.geometry().is_in_space() {
        return Err(GluingError::NoPositions { what: "a cube" }.into());
    }
    let faces = Faces::of(surface)?;
    let edges = faces.edges(surface)?;
    let added = edges.iter().flat_map(|edge| faces.between(edge)).chain(faces.corners(&edges));
    let runs = edges.iter().map(|edge| faces.runs(edge)).collect();
    let added = added.collect();
    Ok(CompletedGrid { rows: faces.rows, cols: faces.cols, added, gluing: Gluing::Runs(runs) })
}

impl Faces {
    fn of(surface: &Surface) -> Result<Self, GluingError> {
        let given @ Chart { rows, cols } = surface.chart();
        let axes = |[down, right]: [usize; 2], gap: usize| {
            let lines = (rows + gap).checked_div(down)?.checked_sub(gap)?;
            let axis = |blocks| Axis { blocks, lines, gap, margins: [0.5; 2] };
            let [of_rows, of_cols] = [axis(down), axis(right)];
            let fits = [of_rows.given(), of_cols.given()] == [rows, cols] && lines >= LEAST_TEXELS;
            fits.then_some((of_rows, of_cols))
        };
        let found = ARRANGEMENTS.into_iter().flat_map(|blocks| [0, 1].map(|gap| axes(blocks, gap)));
        let arranged = found.flatten().find_map(|(rows, cols)| {
            let completed = Chart { rows: rows.completed(), cols: cols.completed() };
            let mut faces = Self { rows, cols, given, completed, blocks: Vec::new() };
            let all =
                (0..rows.blocks).flat_map(|down| (0..cols.blocks).map(move |right| [down, right]));
            faces.blocks = all.filter(|&block| faces.is_there(surface, block)).collect();
            (faces.blocks.len() == FACES).then_some(faces)
        });
        arranged.ok_or(GluingError::NotCube { rows, cols })
    }

    /// Returns whether a face has points.
    fn is_there(&self, surface: &Surface, block: [usize; 2]) -> bool {
        let lines = self.rows.lines;
        let [row, col] = self.first(block);
        (0..lines * lines).any(|k| surface.has(row + k / lines, col + k % lines))
    }

    /// Returns row and column of a face's first texel on the given grid.
    fn first(&self, block: [usize; 2]) -> [usize; 2] {
        let pitch = self.rows.lines + self.rows.gap;
        block.map(|at| at * pitch)
    }

    /// Returns row and column in a face of the k-th texel along a side, `inwards` lines away from the side. Outside of
    /// the face, these are the row and column of an added point.
    fn along(&self, side: GridSide, k: isize, inwards: isize) -> [isize; 2] {
        let last = self.rows.lines as isize - 1;
        match side {
            GridSide::FirstRow => [inwards, k],
            GridSide::LastRow => [last - inwards, k],
            GridSide::FirstColumn => [k, inwards],
            GridSide::LastColumn => [k, last - inwards],
        }
    }

    /// Returns the index of a texel on the given grid.
    fn texel(&self, FaceSide { face, side }: FaceSide, k: isize, inwards: isize) -> usize {
        let [row, col] = self.first(self.blocks[face]);
        let [down, right] = self.along(side, k, inwards);
        self.given.index((row as isize + down) as usize, (col as isize + right) as usize)
    }

    /// Returns row and column on the completed grid of the point on a side beside its k-th texel. The points before the
    /// first and after the last texel are corners.
    fn on_side(&self, FaceSide { face, side }: FaceSide, k: isize) -> (usize, usize) {
        let ([down, right], [row, col]) = (self.blocks[face], self.along(side, k, -1));
        (self.rows.line(down, row), self.cols.line(right, col))
    }

    /// Returns pairs of texels that face each other across an edge, by their numbers along its two sides.
    fn facing(&self, reversed: bool) -> impl Iterator<Item = [isize; 2]> {
        let count = self.rows.lines as isize;
        (0..count).map(move |k| [k, if reversed { count - 1 - k } else { k }])
    }

    /// Finds the sides that meet.
    fn edges(&self, surface: &Surface) -> Result<Vec<Edge>, GluingError> {
        let sides: Vec<_> =
            (0..FACES).flat_map(|face| SIDES.map(|side| FaceSide { face, side })).collect();
        let position = |index: usize| {
            let (row, col) = self.given.position(index);
            surface.position(row, col)
        };
        let apart = |[a, b]: [FaceSide; 2], lines: [isize; 2], reversed: bool| {
            let distance = |[k, l]: [isize; 2]| {
                let [a, b] = [self.texel(a, k, lines[0]), self.texel(b, l, lines[1])].map(position);
                Some(a?.distance(b?))
            };
            mean(self.facing(reversed).filter_map(distance))
        };
        let nearest = |own: FaceSide| {
            let others = sides.iter().filter(|other| other.face != own.face);
            let ways = others.flat_map(|&other| [(other, false), (other, true)]);
            let ways = ways
                .map(|(other, reversed)| (apart([own, other], [0, 0], reversed), other, reversed));
            ways.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let mut edges = Vec::new();
        for &own in &sides {
            let Some((gap, other, reversed)) = nearest(own) else { continue };
            let step = apart([own, own], [0, 1], false);
            let is_mutual = nearest(other).is_some_and(|(_, back, _)| back == own);
            // The gap is not a number if a side has holes only.
            if !is_mutual || gap.is_nan() || gap > FARTHEST * step {
                let [row, col] = self.first(self.blocks[own.face]);
                return Err(GluingError::FaceSide { side: own.side, row, col, apart: gap, step });
            }
            if own.face < other.face {
                edges.push(Edge { sides: [own, other], reversed });
            }
        }
        Ok(edges)
    }

    /// Returns the points on an edge between its ends.
    fn between<'a>(
        &'a self,
        &Edge { sides: [a, b], reversed }: &'a Edge,
    ) -> impl Iterator<Item = Added> {
        self.facing(reversed).map(move |[k, l]| {
            let texels = |inwards| vec![self.texel(a, k, inwards), self.texel(b, l, inwards)];
            let points = [self.on_side(a, k), self.on_side(b, l)];
            let at = points.map(|(row, col)| self.completed.index(row, col)).to_vec();
            Added { at, near: texels(0), far: texels(1) }
        })
    }

    /// Returns the points at corners.
    fn corners(&self, edges: &[Edge]) -> impl Iterator<Item = Added> {
        let ends = [-1, self.rows.lines as isize];
        let corner = |side: FaceSide, k: isize| {
            let (row, col) = self.on_side(side, k);
            self.completed.index(row, col)
        };
        let pairs = edges.iter().flat_map(|&Edge { sides: [a, b], reversed }| {
            let others = if reversed { [ends[1], ends[0]] } else { ends };
            ends.into_iter().zip(others).map(move |(k, l)| [corner(a, k), corner(b, l)])
        });
        let groups = Groups::of(pairs);
        let groups: Vec<Vec<usize>> =
            groups.iter().map(|group| group.iter().map(|&at| at as usize).collect()).collect();
        groups.into_iter().map(|at| {
            let [near, far] = [0, 1].map(|by| at.iter().map(|&at| self.diagonal(at, by)).collect());
            Added { at, near, far }
        })
    }

    /// Returns the index on the given grid of a texel on the diagonal from a corner of the completed grid. The texel
    /// lies `by` texels farther than the one next to the corner.
    fn diagonal(&self, corner: usize, by: usize) -> usize {
        let (row, col) = self.completed.position(corner);
        // A corner is the first or the last line of its block, and the texels follow on the inner side.
        let inner = |axis: Axis, line: usize| {
            let is_first = axis.given_of(line + 1).is_some();
            let line = if is_first { line + 1 + by } else { line - 1 - by };
            axis.given_of(line).expect("texels lie inside of corners")
        };
        self.given.index(inner(self.rows, row), inner(self.cols, col))
    }

    /// Returns the two runs of points that coincide along an edge, corners included.
    fn runs(&self, &Edge { sides: [a, b], reversed }: &Edge) -> [Run; 2] {
        let last = self.rows.lines as isize;
        let run = |side: FaceSide, backwards: bool| {
            let to = match (side.side.is_row(), backwards) {
                (true, false) => Direction::East,
                (true, true) => Direction::West,
                (false, false) => Direction::South,
                (false, true) => Direction::North,
            };
            let from = self.on_side(side, if backwards { last } else { -1 });
            Run { from, to, points: self.rows.lines + 2 }
        };
        [run(a, false), run(b, reversed)]
    }
}
