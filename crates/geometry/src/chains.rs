//! Joins the segments inside triangles into polylines.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Curve;

/// A directed segment between two nodes. Segments with the same `key` belong to the same set of curves.
/// Within such a set at most one segment starts at a node, and at most one ends there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Segment<K> {
    pub key: K,
    pub from: u64,
    pub to: u64,
}

/// The distance, in grid steps, up to which two vertices count as one.
const SAME: f64 = 1e-9;

/// Joins segments into curves of maximal length. The curves are sorted by key, open curves first.
pub(super) fn join<K: Copy + Ord + Send + Sync>(
    mut segments: Vec<Segment<K>>,
    place: impl Fn(K, u64) -> [f64; 2] + Sync,
) -> Vec<(K, Curve)> {
    segments.par_sort_unstable();
    let find = |key, from| segments.binary_search_by(|s| (s.key, s.from).cmp(&(key, from))).ok();
    let next: Vec<Option<usize>> = segments.par_iter().map(|s| find(s.key, s.to)).collect();
    let places: Vec<[f64; 2]> = segments.par_iter().map(|s| place(s.key, s.from)).collect();
    let mut continues = vec![false; segments.len()];
    next.iter().flatten().for_each(|&index| continues[index] = true);

    let mut taken = vec![false; segments.len()];
    let mut curves = Vec::new();
    let starts = (0..segments.len()).filter(|&index| !continues[index]);
    for start in starts.chain(0..segments.len()) {
        if taken[start] {
            continue;
        }
        let (mut vertices, mut index) = (Vec::new(), start);
        let closed = loop {
            taken[index] = true;
            vertices.push(places[index]);
            match next[index] {
                Some(first) if first == start => break true,
                Some(following) if !taken[following] => index = following,
                _ => {
                    vertices.push(place(segments[index].key, segments[index].to));
                    break false;
                }
            }
        };
        if let Some(curve) = without_repeated_vertices(vertices, closed) {
            curves.push((segments[start].key, curve));
        }
    }
    curves.sort_by(|(a, x), (b, y)| a.cmp(b).then(x.closed.cmp(&y.closed)));
    curves
}

/// Joins undirected segments into polylines of maximal length that pass only through nodes at which exactly
/// two segments meet. A closed polyline repeats its first node.
pub(super) fn ways(segments: &[[u64; 2]]) -> Vec<Vec<u64>> {
    let mut at: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (index, ends) in segments.iter().enumerate() {
        ends.iter().for_each(|end| at.entry(*end).or_default().push(index));
    }
    let mut taken = vec![false; segments.len()];
    let mut ways = Vec::new();
    let passes = |node: &u64| at[node].len() == 2;
    // Polylines with free ends or junctions come first, closed ones after them.
    let starts = at.keys().filter(|node| !passes(node)).chain(at.keys());
    for &start in starts {
        for &first in &at[&start] {
            let (mut way, mut next) = (vec![start], Some(first).filter(|&index| !taken[index]));
            while let Some(index) = next {
                taken[index] = true;
                let [a, b] = segments[index];
                let end = if way[way.len() - 1] == a { b } else { a };
                way.push(end);
                let onwards = at[&end].iter().copied().find(|&segment| !taken[segment]);
                next = onwards.filter(|_| passes(&end));
            }
            if way.len() > 1 {
                ways.push(way);
            }
        }
    }
    ways
}

/// Removes repeated vertices. Returns `None` if too few vertices are left.
fn without_repeated_vertices(mut vertices: Vec<[f64; 2]>, closed: bool) -> Option<Curve> {
    let same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= SAME;
    vertices.dedup_by(|a, b| same(*a, *b));
    while closed && vertices.len() > 1 && same(vertices[0], vertices[vertices.len() - 1]) {
        vertices.pop();
    }
    let least = if closed { 3 } else { 2 };
    (vertices.len() >= least).then_some(Curve { vertices, closed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_in_any_order_make_open_and_closed_curves() {
        let segment = |key, from, to| Segment { key, from, to };
        let segments = vec![
            segment('b', 5, 6),
            segment('a', 2, 3),
            segment('a', 7, 8),
            segment('b', 6, 4),
            segment('a', 1, 2),
            segment('b', 4, 5),
        ];
        let curves = join(segments, |_, node| [node as f64, 0.0]);
        let rows = |curve: &Curve| curve.vertices.iter().map(|v| v[0]).collect::<Vec<_>>();
        let found: Vec<_> = curves.iter().map(|(k, c)| (*k, rows(c), c.closed)).collect();
        let expected = [
            ('a', vec![1.0, 2.0, 3.0], false),
            ('a', vec![7.0, 8.0], false),
            ('b', vec![4.0, 5.0, 6.0], true),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn ways_end_at_ends_and_where_three_meet() {
        let found = ways(&[[1, 2], [3, 2], [3, 4], [3, 5], [8, 7], [9, 8], [7, 9]]);
        assert_eq!(found, [vec![1, 2, 3], vec![3, 4], vec![3, 5], vec![7, 8, 9, 7]]);
    }
}
