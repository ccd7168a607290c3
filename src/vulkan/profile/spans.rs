//! Emits passes as spans of the crate `tracing`.

use super::pass::PassRecord;

/// Emits a span for each pass, one after another, at level `DEBUG` with the target `geosweep::gpu`, for subscribers
/// that collect the costs of a frame. The passes have already ended, so the device's times are fields of the span:
/// `begin_ns` since the start of the recording, and `gpu_ns`. Fields with unknown values are empty.
pub fn emit(passes: &[PassRecord]) {
    for pass in passes {
        let work = &pass.work;
        let span = tracing::debug_span!(
            target: "geosweep::gpu",
            "pass",
            kind = pass.kind.name(),
            iteration = pass.iteration,
            begin_ns = pass.begin,
            gpu_ns = pass.nanoseconds,
            groups = pass.groups.map(|groups| groups.iter().product::<u32>()),
            texels = work.texels,
            skipped = work.skipped,
            bytes_read = work.bytes_read,
            bytes_written = work.bytes_written,
            triangles = work.triangles,
            invocations = pass.invocations,
        );
        span.in_scope(|| {});
    }
}
