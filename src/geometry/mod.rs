//! What people do with a distance map.

mod curve;

pub use curve::Curve;
