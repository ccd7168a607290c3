//! Curves in the parameter domain.

/// A polyline in the parameter domain, its vertices anywhere between grid points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Row and column of each vertex, fractional, in order.
    pub vertices: Vec<[f64; 2]>,
    /// Whether the last vertex is joined to the first, which is not repeated.
    pub closed: bool,
}
