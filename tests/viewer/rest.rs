//! Whether processes are idle, by the kernel's account of their threads.
//!
//! A picture that has not changed for a while shows little: on a loaded machine, the next frame may still be
//! pending. But if all threads of the viewer and of the X server sleep, and none has run since the previous
//! look, no thread is left that could wake another.

use std::fs;
use std::thread::sleep;
use std::time::Duration;

/// Number of consecutive looks that must agree.
const LOOKS: usize = 6;
/// Time between two looks. All looks together take longer than the timers involved: the viewer's longest wait
/// for an image of the window, and the clock of a server without a screen.
const PAUSE: Duration = Duration::from_millis(50);

/// Returns whether processes that wait only for one another and for this test have nothing left to do.
pub fn are_done(processes: &[u32]) -> bool {
    let look = || processes.iter().map(|&process| asleep(process)).collect::<Option<Vec<_>>>();
    let first = look();
    first.is_some()
        && (1..LOOKS).all(|_| {
            sleep(PAUSE);
            look() == first
        })
}

/// Returns how often each thread of a process has yielded, if all of them sleep.
fn asleep(process: u32) -> Option<Vec<(String, u64)>> {
    let threads = fs::read_dir(format!("/proc/{process}/task")).ok()?;
    threads
        .map(|thread| {
            let status = fs::read_to_string(thread.ok()?.path().join("status")).ok()?;
            let field = |name: &str| {
                let line = status.lines().find_map(|line| line.strip_prefix(name))?;
                line.strip_prefix(':')?.split_whitespace().next()
            };
            if field("State")? != "S" {
                return None;
            }
            let switches = ["voluntary_ctxt_switches", "nonvoluntary_ctxt_switches"];
            let [willing, other] = switches.map(|name| field(name)?.parse::<u64>().ok());
            Some((field("Pid")?.to_owned(), willing? + other?))
        })
        .collect()
}
