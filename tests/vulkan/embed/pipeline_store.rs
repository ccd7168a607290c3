//! Pipelines that a file keeps from one solver to the next.

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::vulkan::embed::{Solver, Tools};
use geosweep::vulkan::{PipelineStore, Schedule};

use crate::host::Host;

/// Returns the files of a folder and their contents.
fn files(folder: &std::path::Path) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn a_store_keeps_one_file_per_device_and_replaces_a_damaged_file() {
    let host = Host::new();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("not yet there");
    // SAFETY: the physical device is from this instance.
    let properties = unsafe { host.instance.get_physical_device_properties(host.physical_device) };
    let solve = || {
        let mut store = PipelineStore::open(&properties, &host.device, &folder).unwrap();
        assert_ne!(store.cache(), vk::PipelineCache::null());
        let passes = [(Schedule::Raster, Wavefront::Planar)];
        let (instance, physical_device) = (&host.instance, host.physical_device);
        let cache = store.cache();
        let tools = Tools::default();
        let mut solver =
            Solver::with_cache(instance, physical_device, &host.device, &passes, tools, cache);
        solver.as_mut().unwrap().destroy(&host.device);
        store.save(&host.device).unwrap();
        store.destroy(&host.device);
    };
    solve();
    let [(path, whole)] = &files(&folder)[..] else { panic!("one file") };
    solve();
    assert_eq!(files(&folder).len(), 1);
    for spoiled in [&whole[..whole.len() / 2], b"", &[&whole[..8], &[0; 64]].concat()] {
        std::fs::write(path, spoiled).unwrap();
        solve();
        let [(same, again)] = &files(&folder)[..] else { panic!("one file") };
        assert_eq!((same, again.len()), (path, whole.len()));
    }
    assert_eq!(host.messages(), Vec::<String>::new());
}
