//! Keeps compiled pipelines in a file, so that the next process starts without compiling them.

use std::ffi::{OsStr, OsString};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{PoisonError, RwLock};
use std::{env, fs, io, process};

use ash::vk;

use super::passes::TABLE;
use crate::vulkan::VulkanError;

/// Vulkan pipeline cache backed by a file. The file is named after the device, its driver and the shaders of
/// this build.
///
/// A file that is incomplete or belongs to another driver counts as empty.
#[derive(Debug)]
pub struct PipelineStore {
    cache: vk::PipelineCache,
    file: PathBuf,
    /// Digest of the file's contents, if they were usable.
    digest: Option<u64>,
}

/// Environment variable with a folder that replaces the one that the program has set.
const VARIABLE: &str = "GEOSWEEP_PIPELINES";

/// Folder that the program has set for the pipelines of headless solvers.
static FOLDER: RwLock<Option<PathBuf>> = RwLock::new(None);

/// Sets the folder in which headless solvers of this process keep their pipelines. It applies to every solver
/// that is opened afterwards ([`crate::vulkan::HeadlessSolver::new`]). The folder is created if necessary.
/// With `None`, as at the start, nothing is kept. The environment variable `GEOSWEEP_PIPELINES` takes
/// precedence: it names another folder, or none if it is 0 or empty.
///
/// A folder that cannot be read or written is not an error: pipelines are then compiled as without a folder.
///
/// ```no_run
/// use geosweep::{DeviceChoice, vulkan};
/// vulkan::keep_pipelines_in(Some("/home/me/.cache/geosweep".into()));
/// let solver = vulkan::HeadlessSolver::new(&DeviceChoice::Any)?;
/// # Ok::<(), vulkan::VulkanError>(())
/// ```
pub fn keep_pipelines_in(folder: Option<PathBuf>) {
    *FOLDER.write().unwrap_or_else(PoisonError::into_inner) = folder;
}

/// Returns whether headless solvers of this process keep their pipelines in files.
pub(crate) fn are_pipelines_kept() -> bool {
    folder(env::var_os(VARIABLE)).is_some()
}

/// Returns the folder, given the value of the environment variable.
fn folder(variable: Option<OsString>) -> Option<PathBuf> {
    match variable {
        Some(none) if none.is_empty() || none == "0" => None,
        Some(folder) => Some(folder.into()),
        None => FOLDER.read().unwrap_or_else(PoisonError::into_inner).clone(),
    }
}

/// Number of newest files kept for a device, so that as many drivers and builds can alternate without
/// compiling again.
const FILES_KEPT: usize = 4;

/// Largest size of a file that is read, in bytes. A larger file cannot come from this crate.
const MOST_BYTES: u64 = 1 << 28;

const EXTENSION: &str = "pipelines";

/// Number of files that this process has written.
static SAVES: AtomicU32 = AtomicU32::new(0);

impl PipelineStore {
    /// Opens a store in the folder of this process, if it has one.
    pub(in crate::vulkan) fn of_process(
        properties: &vk::PhysicalDeviceProperties,
        device: &ash::Device,
    ) -> Result<Option<Self>, VulkanError> {
        let folder = folder(env::var_os(VARIABLE));
        folder.map(|folder| Self::open(properties, device, &folder)).transpose()
    }

    /// Creates the pipeline cache, from the file if there is one. [`PipelineStore::destroy`] must be called
    /// before the device is destroyed.
    ///
    /// # Errors
    /// If `vkCreatePipelineCache` fails.
    pub fn open(
        properties: &vk::PhysicalDeviceProperties,
        device: &ash::Device,
        folder: &Path,
    ) -> Result<Self, VulkanError> {
        let file = folder.join(file_name(properties));
        let found = read(&file).filter(|data| is_of(data, properties));
        let data = found.as_deref().unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
        // SAFETY: the data are complete, and their header says that this driver wrote them.
        let cache = unsafe { device.create_pipeline_cache(&info, None) }
            .map_err(VulkanError::from_call("vkCreatePipelineCache"))?;
        Ok(Self { cache, file, digest: found.as_deref().map(digest) })
    }

    /// Returns the pipeline cache, which the creation of pipelines takes.
    pub fn cache(&self) -> vk::PipelineCache {
        self.cache
    }

    /// Rewrites the file if the cache has new pipelines. Other processes find either the old file or the new
    /// one, never a part.
    ///
    /// # Errors
    /// If the driver does not return the data, or the file cannot be written.
    pub fn save(&mut self, device: &ash::Device) -> io::Result<()> {
        // SAFETY: the cache is alive until it is destroyed.
        let data = unsafe { device.get_pipeline_cache_data(self.cache) };
        let data = data.map_err(|result| io::Error::other(format!("no data: {result}")))?;
        let digest = digest(&data);
        if self.digest == Some(digest) {
            return Ok(());
        }
        if let Some(folder) = self.file.parent() {
            fs::create_dir_all(folder)?;
            remove_old(folder, &self.file);
        }
        // Two stores of this process may be saved at the same time.
        let number = SAVES.fetch_add(1, Ordering::Relaxed);
        let part = self.file.with_extension(format!("{}-{number}.part", process::id()));
        let all = [&digest.to_le_bytes(), &*data].concat();
        let written = fs::write(&part, all).and_then(|()| fs::rename(&part, &self.file));
        if written.is_err() {
            let _ = fs::remove_file(&part);
        }
        self.digest = Some(digest);
        written
    }

    /// Destroys the pipeline cache. Pipelines created with it do not need it any more.
    pub fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: no pipeline is being created with it, since the caller has exclusive access to the store;
        // null is allowed.
        unsafe { device.destroy_pipeline_cache(std::mem::take(&mut self.cache), None) };
    }
}

/// Returns the common prefix of the names of a device's files.
fn device_name(properties: &vk::PhysicalDeviceProperties) -> String {
    format!("{:04x}-{:04x}-", properties.vendor_id, properties.device_id)
}

fn file_name(properties: &vk::PhysicalDeviceProperties) -> String {
    let mut shaders = DefaultHasher::new();
    for row in &TABLE {
        row.shader.modules.hash(&mut shaders);
        row.of_points.iter().flatten().for_each(|shader| shader.modules.hash(&mut shaders));
    }
    let mut driver = DefaultHasher::new();
    (properties.driver_version, properties.pipeline_cache_uuid).hash(&mut driver);
    let (device, driver, shaders) = (device_name(properties), driver.finish(), shaders.finish());
    format!("{device}{driver:016x}-{shaders:016x}.{EXTENSION}")
}

/// Returns the data of a file if it is complete.
fn read(file: &Path) -> Option<Vec<u8>> {
    if fs::metadata(file).ok()?.len() > MOST_BYTES {
        return None;
    }
    let all = fs::read(file).ok()?;
    let (written, data) = all.split_first_chunk()?;
    (u64::from_le_bytes(*written) == digest(data)).then(|| data.to_vec())
}

/// Returns whether `data` begin with the header of this device's driver (`VkPipelineCacheHeaderVersionOne`). Some
/// drivers do not check the header.
fn is_of(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let words = [32, 1, properties.vendor_id, properties.device_id];
    let header = words.iter().flat_map(|word: &u32| word.to_le_bytes());
    let header = header.chain(properties.pipeline_cache_uuid);
    data.len() >= 32 && data.iter().copied().zip(header).all(|(found, expected)| found == expected)
}

fn digest(data: &[u8]) -> u64 {
    let mut digest = DefaultHasher::new();
    data.hash(&mut digest);
    digest.finish()
}

/// Removes the oldest files of a device, so that at most [`FILES_KEPT`] remain, including `file`. Files that
/// cannot be removed stay.
fn remove_old(folder: &Path, file: &Path) {
    let name = file.file_name().and_then(OsStr::to_str).unwrap_or_default();
    // The first two parts of the name are the vendor and the device.
    let of_device = name.splitn(3, '-').take(2).collect::<Vec<_>>().join("-");
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut others: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
            path != file && name.starts_with(&of_device) && name.ends_with(EXTENSION)
        })
        .filter_map(|path| Some((fs::metadata(&path).ok()?.modified().ok()?, path)))
        .collect();
    others.sort();
    let most = others.len().saturating_sub(FILES_KEPT - 1);
    for (_, path) in &others[..most] {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties(device_id: u32) -> vk::PhysicalDeviceProperties {
        let pipeline_cache_uuid = [7; 16];
        vk::PhysicalDeviceProperties { device_id, pipeline_cache_uuid, ..Default::default() }
    }

    fn header(device_id: u32) -> Vec<u8> {
        let words = [32u32, 1, 0, device_id].map(u32::to_le_bytes);
        [words.as_flattened(), &[7; 16], b"pipelines"].concat()
    }

    #[test]
    fn data_of_another_device_or_version_are_not_taken() {
        assert!(is_of(&header(5), &properties(5)));
        assert!(!is_of(&header(5), &properties(6)));
        assert!(!is_of(&header(5)[..31], &properties(5)));
        for byte in [0, 4, 8, 12, 16, 31] {
            let mut other = header(5);
            other[byte] ^= 1;
            assert!(!is_of(&other, &properties(5)), "byte {byte}");
        }
    }

    #[test]
    fn the_variable_takes_precedence() {
        let of = |variable: &str| folder(Some(variable.into()));
        assert_eq!([of("0"), of("")], [None, None]);
        assert_eq!(of("some/folder"), Some("some/folder".into()));
        assert_eq!(folder(None), None, "only a program sets a folder");
    }

    #[test]
    fn a_file_that_is_not_whole_counts_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("one.pipelines");
        assert_eq!(read(&file), None);
        let data = header(5);
        let whole = [&digest(&data).to_le_bytes(), &*data].concat();
        fs::write(&file, &whole).unwrap();
        assert_eq!(read(&file), Some(data));
        for length in [0, 3, 8, whole.len() - 1] {
            fs::write(&file, &whole[..length]).unwrap();
            assert_eq!(read(&file), None, "{length} bytes");
        }
    }

    #[test]
    fn the_newest_files_of_a_device_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let names: Vec<_> = (0..6).map(|number| format!("0000-0005-{number}.pipelines")).collect();
        for (age, name) in (0..).zip(&names) {
            let file = fs::File::create(path(name)).unwrap();
            let time = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(age);
            file.set_modified(time).unwrap();
        }
        fs::write(path("0000-0006-0.pipelines"), "").unwrap();
        fs::write(path("notes.txt"), "").unwrap();
        remove_old(folder.path(), &path(&file_name(&properties(5))));
        let left: Vec<_> = names.iter().filter(|name| path(name).exists()).collect();
        assert_eq!(left, names[3..].iter().collect::<Vec<_>>());
        assert!(path("0000-0006-0.pipelines").exists() && path("notes.txt").exists());
    }
}
