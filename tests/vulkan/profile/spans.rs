//! Records as spans of the crate `tracing`.

use std::sync::Mutex;

use geosweep::Wavefront;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::profile::Detail;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

use crate::profile::bench::{Bench, method};

#[derive(Default)]
struct Spans(Mutex<Vec<Vec<(&'static str, String)>>>);

struct Fields<'a>(&'a mut Vec<(&'static str, String)>);

impl Visit for Fields<'_> {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        self.0.push((field.name(), format!("{value:?}")));
    }
}

impl Subscriber for Spans {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == "geosweep::gpu"
    }
    fn new_span(&self, span: &Attributes<'_>) -> Id {
        let mut fields = Vec::new();
        span.record(&mut Fields(&mut fields));
        let mut all = self.0.lock().unwrap();
        all.push(fields);
        Id::from_u64(all.len() as u64)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event<'_>) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// Each pass is a span with its numbers.
#[test]
fn passes_are_spans() {
    let mut bench = Bench::new(30, 30);
    let profile = bench.profile(method(Wavefront::Planar, Schedule::Raster), Detail::default());
    let passes: Vec<_> = profile.passes().copied().collect();
    let spans = std::sync::Arc::new(Spans::default());
    tracing::subscriber::with_default(std::sync::Arc::clone(&spans), || {
        geosweep::vulkan::profile::emit(&passes);
    });
    let spans = spans.0.lock().unwrap();
    assert_eq!(spans.len(), passes.len());
    for (span, pass) in spans.iter().zip(&passes) {
        let field = |name: &str| span.iter().find(|(field, _)| *field == name).map(|f| &f.1);
        let number = |value: Option<u64>| value.map(|value| value.to_string());
        assert_eq!(field("kind"), Some(&format!("{:?}", pass.kind.name())));
        assert_eq!(field("gpu_ns").cloned(), number(pass.nanoseconds));
        assert_eq!(field("texels").cloned(), number(pass.work.texels));
        assert_eq!(field("invocations").cloned(), number(pass.invocations));
    }
}
