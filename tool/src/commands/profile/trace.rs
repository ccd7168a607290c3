//! Writes a map as a trace in the Chrome format, which Perfetto opens.
//!
//! The format is "Trace Event Format", Google, "JSON Object Format", with complete events (`X`) and metadata
//! (`M`). Times are in microseconds.
//!
//! Perfetto is stricter than the format. Some versions truncate times to whole nanoseconds (`CoerceToTs` in
//! `src/trace_processor/importers/json`). All versions drop events that partly overlap others of their track,
//! even by one nanosecond (`slice_drop_overlapping_complete_event`).

use std::io::{self, Write};

use geosweep::vulkan::profile::{PassRecord, SolveProfile, SubmissionRecord};
use serde_json::{Value, json};

use super::measure::Measured;

const PROCESS: u32 = 1;
/// The track of the host. `DEVICE` is the track of the device.
const HOST: u32 = 1;
const DEVICE: u32 = 2;

pub fn write(writer: &mut impl Write, measured: &Measured, run: &SolveProfile) -> io::Result<()> {
    let calibrated = run.submissions.iter().any(|submission| submission.begin.is_some());
    let timed = run.submissions.iter().any(|submission| submission.nanoseconds.is_some());
    let mut events = vec![
        named("process_name", None, "geosweep profile"),
        named("thread_name", Some(HOST), "host: submissions"),
    ];
    if timed {
        events.push(named("thread_name", Some(DEVICE), &format!("device: {}", measured.device)));
    }
    for (number, submission) in run.submissions.iter().enumerate() {
        let (begin, end) = (submission.submitted.as_nanos(), submission.ended.as_nanos());
        let name = format!("submission {number}");
        events.push(span(HOST, "submission", &name, [begin as i64, end as i64], json!({})));
    }
    let mut last = 0;
    for (number, submission) in run.submissions.iter().enumerate() {
        last = device_events(&mut events, number, submission, last);
    }
    let alignment = match (timed, calibrated) {
        (true, true) => "calibrated timestamps",
        (true, false) => {
            "each submission begins on the device when it is submitted: the device \
                          has no calibrated timestamps"
        }
        (false, _) => "none: the device has no timestamps",
    };
    let trace = json!({
        "displayTimeUnit": "ns",
        "otherData": {
            "device": measured.device,
            "driver": measured.driver,
            "rows": measured.chart.rows,
            "cols": measured.chart.cols,
            "schedule": measured.solved.schedule(),
            "wavefront": measured.wavefront.name(),
            "iterations": measured.iterations,
            "alignment": alignment,
        },
        "traceEvents": events,
    });
    serde_json::to_writer(&mut *writer, &trace)?;
    writer.write_all(b"\n")
}

/// Adds the events of a submission on the device. They start no earlier than `last`, the end of the previous
/// submission. Returns the end of this submission.
fn device_events(
    events: &mut Vec<Value>,
    number: usize,
    submission: &SubmissionRecord,
    last: i64,
) -> i64 {
    let (Some(taken), Some(lead)) = (submission.nanoseconds, submission.lead) else { return last };
    let placed = submission.begin.unwrap_or(submission.submitted.as_nanos() as f64);
    let begin = (placed.round() as i64).max(last);
    let end = begin + taken as i64;
    let name = format!("submission {number}");
    events.push(span(DEVICE, "submission", &name, [begin, end], json!({})));
    let first = begin + lead as i64;
    let times = |pass: &PassRecord| {
        let begin = first + pass.begin.unwrap_or(0) as i64;
        [begin, begin + pass.nanoseconds.unwrap_or(0) as i64]
    };
    for passes in submission.passes.chunk_by(|a, b| a.iteration == b.iteration) {
        if let Some(iteration) = passes[0].iteration {
            let ends = [times(&passes[0])[0], times(&passes[passes.len() - 1])[1]];
            let name = format!("iteration {}", iteration + 1);
            events.push(span(DEVICE, "iteration", &name, ends, json!({})));
        }
        for pass in passes {
            events.push(span(DEVICE, "pass", pass.kind.name(), times(pass), details(pass)));
        }
    }
    end
}

/// Returns the known properties of a pass.
fn details(pass: &PassRecord) -> Value {
    let work = &pass.work;
    let numbers = [
        ("dispatches", Some(pass.dispatches.into())),
        ("groups", pass.groups.map(|groups| groups.iter().map(|&n| u64::from(n)).product())),
        ("first_row", pass.area.map(|area| area.rows[0].into())),
        ("end_row", pass.area.map(|area| area.rows[1].into())),
        ("first_col", pass.area.map(|area| area.cols[0].into())),
        ("end_col", pass.area.map(|area| area.cols[1].into())),
        ("texels", work.texels),
        ("skipped", work.skipped),
        ("bytes_read", work.bytes_read),
        ("bytes_written", work.bytes_written),
        ("triangles", work.triangles),
    ];
    let known =
        numbers.into_iter().filter_map(|(name, number)| Some((name.into(), number?.into())));
    Value::Object(known.collect())
}

fn named(what: &str, thread: Option<u32>, name: &str) -> Value {
    let mut event = json!({ "ph": "M", "pid": PROCESS, "name": what, "args": { "name": name } });
    if let Some(thread) = thread {
        event["tid"] = thread.into();
    }
    event
}

/// Returns a complete event between two times in nanoseconds.
fn span(thread: u32, category: &str, name: &str, [begin, end]: [i64; 2], args: Value) -> Value {
    json!({
        "ph": "X",
        "pid": PROCESS,
        "tid": thread,
        "cat": category,
        "name": name,
        "ts": microseconds(begin),
        "dur": microseconds(end - begin),
        "args": args,
    })
}

/// Converts nanoseconds to microseconds. A hundredth of a nanosecond is added, so that readers that round and
/// then truncate get the right nanosecond. The result is exact to the nanosecond for times up to two hours.
fn microseconds(nanoseconds: i64) -> f64 {
    (nanoseconds as f64 + 0.01) / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader may keep a number or replace it by the next floating-point number above or below. Truncated,
    /// each of the three must give the same nanosecond.
    #[test]
    fn nanoseconds_survive_being_cut_off() {
        // The floating-point number nearest to 1.001 is smaller than 1.001.
        assert_eq!((1e3 * 1.001) as i64, 1000);
        const HOURS: i64 = 7_200_000_000_000;
        for nanoseconds in (0..5000).chain((0..5000).map(|k| HOURS - 987_654_321 * k)) {
            let written = microseconds(nanoseconds);
            for read in [written.next_down(), written, written.next_up()] {
                assert_eq!((1e3 * read) as i64, nanoseconds);
            }
        }
    }
}
