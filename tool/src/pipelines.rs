//! Chooses where the tool keeps compiled pipelines of Vulkan drivers, so that the next call starts without
//! delay.

use std::env;
use std::path::PathBuf;

use etcetera::BaseStrategy;
use geosweep::vulkan;

/// The environment variable that names another folder; 0 stands for none.
const VARIABLE: &str = "GEOSWEEP_PIPELINES";

/// Makes Vulkan solvers keep their pipelines in the user's cache folder.
pub fn keep() {
    let folder = match env::var_os(VARIABLE) {
        Some(none) if none.is_empty() || none == "0" => None,
        Some(folder) => Some(PathBuf::from(folder)),
        None => etcetera::choose_base_strategy().ok().map(|user| user.cache_dir().join("geosweep")),
    };
    vulkan::keep_pipelines_in(folder);
}
