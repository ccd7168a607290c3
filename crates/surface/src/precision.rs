//! Calls functions that are compiled once for each precision.
//!
//! A function that is generic in the precision is compiled again in every crate that calls it. Long ones are called
//! through statics that hold the function in both precisions, since statics are compiled in this crate alone.

use std::any::Any;

use super::edges::EdgeLengths;
use super::real::Real;

/// A function of edges in both precisions.
pub(super) type OfEdges<S, D> = (fn(&EdgeLengths<f32>) -> S, fn(&EdgeLengths<f64>) -> D);

/// Calls the function in the precision of the edges.
pub(super) fn of_edges<R: Real, T: Any, S: Any, D: Any>(
    edges: &EdgeLengths<R>,
    (single, double): OfEdges<S, D>,
) -> T {
    let edges: &dyn Any = edges;
    match (edges.downcast_ref(), edges.downcast_ref()) {
        (Some(edges), _) => same(single(edges)),
        (_, Some(edges)) => same(double(edges)),
        _ => unreachable!("there are two precisions"),
    }
}

/// Returns a value whose type has another name where the precision is not known.
pub(super) fn same<A: Any, B: Any>(value: A) -> B {
    let mut value = Some(value);
    let value = (&mut value as &mut dyn Any).downcast_mut::<Option<B>>().and_then(Option::take);
    value.expect("both names are of one type")
}
