//! Chooses where the tool stores compiled pipelines of Vulkan drivers, so that the next call starts without delay.

use etcetera::BaseStrategy;
use geosweep::vulkan;

/// Makes Vulkan solvers store their pipelines in the user's cache folder.
pub fn keep() {
    let user = etcetera::choose_base_strategy().ok();
    vulkan::keep_pipelines_in(user.map(|user| user.cache_dir().join("geosweep")));
}
