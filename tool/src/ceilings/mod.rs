//! Reports the peak rates of devices and processors, and compares a map's time with them.

mod shares;

use geosweep::{Wavefront, cpu, vulkan};
use serde::Serialize;

pub use shares::{Shares, Work};

/// The peak rates of a device, in bytes and triangles per second, and the durations of its commands, in
/// seconds.
#[derive(Clone, Copy, Serialize)]
pub struct DeviceCeilings {
    copy: f64,
    triangles: Triangles,
    dispatch: f64,
    indirect_dispatch: f64,
    skipped_dispatch: f64,
    barrier: f64,
    timestamp: Option<f64>,
    submission: f64,
    read_back: f64,
}

/// The peak rates of a number of threads.
#[derive(Clone, Copy, Serialize)]
pub struct CpuCeilings {
    threads: usize,
    copy: f64,
    triangles: Triangles,
}

/// The peak number of updates from one triangle per second, by wavefront.
#[derive(Clone, Copy, Serialize)]
struct Triangles {
    planar: f64,
    circular: f64,
    curved: f64,
}

impl From<[f64; 3]> for Triangles {
    fn from([planar, circular, curved]: [f64; 3]) -> Self {
        Self { planar, circular, curved }
    }
}

impl From<vulkan::DeviceCeilings> for DeviceCeilings {
    fn from(ceilings: vulkan::DeviceCeilings) -> Self {
        Self {
            copy: ceilings.copy,
            triangles: ceilings.triangles.into(),
            dispatch: ceilings.dispatch.as_secs_f64(),
            indirect_dispatch: ceilings.indirect_dispatch.as_secs_f64(),
            skipped_dispatch: ceilings.skipped_dispatch.as_secs_f64(),
            barrier: ceilings.barrier.as_secs_f64(),
            timestamp: ceilings.timestamp.map(|time| time.as_secs_f64()),
            submission: ceilings.submission.as_secs_f64(),
            read_back: ceilings.read_back,
        }
    }
}

impl From<cpu::CpuCeilings> for CpuCeilings {
    fn from(ceilings: cpu::CpuCeilings) -> Self {
        let cpu::CpuCeilings { threads, copy, triangles } = ceilings;
        Self { threads, copy, triangles: triangles.into() }
    }
}

impl std::fmt::Display for DeviceCeilings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { copy, triangles, read_back, .. } = self;
        let [dispatch, indirect, skipped, barrier, submission] = [
            self.dispatch,
            self.indirect_dispatch,
            self.skipped_dispatch,
            self.barrier,
            self.submission,
        ]
        .map(|seconds| 1e6 * seconds);
        write!(
            f,
            "copies {:.1} GB/s; {triangles}; dispatch of one group {dispatch:.2} us, indirect \
             {indirect:.2} us, of none {skipped:.2} us, barrier {barrier:.2} us, ",
            copy / 1e9,
        )?;
        if let Some(timestamp) = self.timestamp {
            write!(f, "timestamp {:.2} us, ", 1e6 * timestamp)?;
        }
        write!(f, "submission {submission:.0} us; reads back {:.1} GB/s", read_back / 1e9)
    }
}

impl std::fmt::Display for CpuCeilings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { threads, copy, triangles } = self;
        let s = if *threads == 1 { "" } else { "s" };
        write!(f, "{threads} thread{s}: copies {:.1} GB/s; {triangles}", copy / 1e9)
    }
}

impl std::fmt::Display for Triangles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { planar, circular, curved } = self;
        f.write_str("triangles a second:")?;
        for (wavefront, rate) in
            Wavefront::FOR_ANY_SURFACE.into_iter().zip([planar, circular, curved])
        {
            let comma = if wavefront == Wavefront::FOR_ANY_SURFACE[0] { "" } else { "," };
            write!(f, "{comma} {} {:.0} M", wavefront.name(), rate / 1e6)?;
        }
        Ok(())
    }
}
