//! The solver. Its pipelines stay in the user's cache folder from one start to the next.

use etcetera::BaseStrategy;
use geosweep::Wavefront;
use geosweep::vulkan::embed::{Solver, Tools};
use geosweep::vulkan::{PipelineStore, Schedule};

use crate::Result;
use crate::gpu::Gpu;

pub fn solver(gpu: &Gpu, passes: &[(Schedule, Wavefront)]) -> Result<(Solver, PipelineStore)> {
    let folder = etcetera::choose_base_strategy()?.cache_dir().join("geosweep");
    // SAFETY: the physical device is from this instance.
    let properties = unsafe { gpu.instance.get_physical_device_properties(gpu.physical_device) };
    let store = PipelineStore::open(&properties, &gpu.device, &folder)?;
    let (instance, physical_device) = (&gpu.instance, gpu.physical_device);
    let (tools, cache) = (Tools::default(), store.cache());
    let solver = Solver::with_cache(instance, physical_device, &gpu.device, passes, tools, cache)?;
    Ok((solver, store))
}
