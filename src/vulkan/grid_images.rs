//! Allocates the images and buffers of a surface and its map on the device.

use std::ops::Range;

use super::device::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::copies::{Copies, CopyList};
use super::device::bands::{
    bands, distance_bytes, frame_bytes, source_bytes, staged_bytes, transfer_bytes, upload_bytes,
};
use super::device::descriptors::{Contents, GridContents, GridSets};
use super::device::labels::NameOf;
use super::device::memory::{Buffer, BufferInfo, FORMAT, Image, ImageInfo, RESULT_FORMAT};
use super::device::pipelines::Pipelines;
use super::device::staging::{HALVES, Staging};
use super::schedules::plan::Scan;
use super::schedules::progress;
use super::schedules::progress::Record;
use super::upload::{ANCHOR_BYTES, SOURCE_BYTES};
use super::{TexelChart, Tuning, VulkanError};
use crate::constants::LAYERS;
use crate::surface::{Chart, Lattice};

/// Number of words that are stored for each tile.
pub(crate) const TILE_WORDS: usize = 6;

/// Largest number of sources in a recording.
pub(crate) const INLINE_SOURCES: usize = 1024;

/// Source, target and size of a copy between buffers, each place with its offset.
pub(crate) type Copied = ((vk::Buffer, u64), (vk::Buffer, u64), u64);

/// Purpose of a grid's images.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Purpose<'a> {
    /// Whether the slowness of the surface is uneven. The device then stores it, 4 bytes a point.
    pub(crate) slowed: bool,
    /// Number of frames in flight if the surface is embedded in a renderer, where everything stays on the device.
    ///
    /// In headless solving there are none. Edges and sources come from the program's memory, and distances go back
    /// there. In each direction they pass through a buffer of 4 bytes a point, up to 16 MiB. The upload buffer has room
    /// for anchors after the edges. With [`Tuning::staged`] there are buffers in the host's memory too, of 12 bytes a
    /// point together.
    pub(crate) slots: Option<usize>,
    /// Number of images of distances.
    pub(crate) results: usize,
    /// Queue families that use images of distances and the map.
    pub(crate) families: &'a [u32],
    /// Continuation of the grid beyond its sides, if its points are measured on the device.
    pub(crate) lattice: Lattice,
    /// Name of the surface in debugging tools. It is empty in headless solving.
    pub(crate) owner: &'a str,
}

impl Purpose<'_> {
    /// Returns the purpose of headless solving.
    pub(crate) fn headless(slowed: bool) -> Self {
        Self {
            slowed,
            slots: None,
            results: 0,
            families: &[],
            lattice: Lattice::default(),
            owner: "",
        }
    }

    /// Returns whether what the program writes and reads passes through staging buffers. A renderer's frame
    /// reads and writes the renderer's own buffers.
    fn is_staged(self, tuning: Tuning) -> bool {
        self.slots.is_none() && tuning.staged
    }
}

/// Images and buffers of one surface. The images hold edge lengths (16 bytes a point), Gaussian curvature (4)
/// and twice the fronts (8 each: arrival time and curvature). The buffers hold the lists of tiles, and points
/// or edges. There is a buffer for read-back, or images of distances.
#[derive(Debug)]
pub(crate) struct GridImages {
    pub(crate) chart: Chart,
    pub(crate) texels: TexelChart,
    pub(crate) edges: Image,
    pub(crate) gaussian: Image,
    slowed: bool,
    /// Continuation of the grid beyond its sides, for a renderer's points.
    pub(crate) lattice: Lattice,
    /// Number of frames in flight.
    pub(crate) slots: usize,
    pub(crate) fronts: [Image; 2],
    pub(crate) results: Vec<Image>,
    pub(crate) progress: Buffer,
    pub(crate) outcome: Buffer,
    pub(crate) tiles: Buffer,
    pub(crate) blocks: Buffer,
    /// Points or sources, and anchors, for shaders. Unless there is staging, edges are copied from this
    /// buffer too.
    pub(crate) upload: Buffer,
    /// Buffer to which distances are unpacked, or which holds the sources that a recording contains.
    pub(crate) download: Buffer,
    /// Buffers in the host's memory through which everything passes to `upload` and from `download`, if the
    /// device has memory of its own.
    staging: Option<[Staging; 2]>,
    /// Whether anchors have been written.
    has_anchors: bool,
    pub(crate) sets: GridSets,
    /// Copies of points, if the surface is glued.
    pub(crate) copies: Option<Copies>,
    /// Name of the surface in debugging tools.
    pub(crate) owner: String,
}

impl GridImages {
    /// Allocates the images and buffers. The caller has checked the size against the device's limits.
    ///
    /// [`GridImages::destroy`] must be called before the device or the allocator is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        (chart, texels): (Chart, TexelChart),
        purpose: Purpose,
    ) -> Result<Self, VulkanError> {
        let mut images = Vec::new();
        let mut buffers = Vec::new();
        let mut staging = Vec::new();
        let is_staged = purpose.is_staged(pipelines.tuning);
        let created = (|| {
            for info in image_infos(chart, texels, purpose) {
                images.push(Image::new(device, allocator, info)?);
                pipelines.name_image(NameOf(info.name, purpose.owner), &images[images.len() - 1]);
            }
            for info in buffer_infos(chart, texels, pipelines.tuning, purpose) {
                buffers.push(Buffer::new(device, allocator, info)?);
                pipelines.name(NameOf(info.name, purpose.owner), buffers[buffers.len() - 1].buffer);
            }
            let ([edges, gaussian, fronts @ ..], [progress, _, tiles, blocks, points, distances]) =
                (&images[..4], &buffers[..])
            else {
                unreachable!("four images come before the results, and there are six buffers")
            };
            for (name, sizes) in staging_infos(chart).into_iter().filter(|_| is_staged) {
                staging.push(Staging::new(device, allocator, pipelines, name, sizes)?);
            }
            let contents = Contents {
                edges,
                gaussian,
                fronts: Some([&fronts[0], &fronts[1]]),
                points: Some(points),
                progress,
                tiles: Some(tiles),
                blocks,
                distances,
                owner: purpose.owner,
            };
            GridSets::new(device, pipelines, contents)
        })();
        let sets = match created {
            Ok(sets) => sets,
            Err(error) => {
                images.iter_mut().for_each(|image| image.destroy(device, allocator));
                buffers.iter_mut().for_each(|buffer| buffer.destroy(device, allocator));
                staging.iter_mut().for_each(|staging| staging.destroy(device, allocator));
                return Err(error);
            }
        };
        let results = images.split_off(4);
        let [edges, gaussian, fronts0, fronts1] =
            images.try_into().expect("four images come before the results");
        let [progress, mut outcome, tiles, blocks, upload, download] =
            buffers.try_into().expect("six buffers were created");
        // No recording has written a record yet.
        outcome.mapped().fill(0);
        Ok(Self {
            chart,
            texels,
            edges,
            gaussian,
            slowed: purpose.slowed,
            lattice: purpose.lattice,
            slots: purpose.slots.unwrap_or(0),
            fronts: [fronts0, fronts1],
            results,
            progress,
            outcome,
            tiles,
            blocks,
            upload,
            download,
            staging: staging.try_into().ok(),
            has_anchors: false,
            sets,
            copies: None,
            owner: purpose.owner.to_owned(),
        })
    }

    /// Allocates what the maps of a glued surface need in addition.
    pub(crate) fn glue(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        list: CopyList,
    ) -> Result<(), VulkanError> {
        let of_grid = GridContents {
            sets: &self.sets,
            edges: &self.edges,
            gaussian: &self.gaussian,
            fronts: self.fronts.each_ref(),
            progress: &self.progress,
            owner: &self.owner,
        };
        self.copies = Some(Copies::new(device, allocator, pipelines, list, of_grid)?);
        Ok(())
    }

    /// Returns the bytes that [`GridImages::new`] would take from the allocator.
    pub(crate) fn bytes_for(
        device: &ash::Device,
        tuning: Tuning,
        (chart, texels): (Chart, TexelChart),
        purpose: Purpose,
    ) -> Result<u64, VulkanError> {
        let mut bytes = 0;
        for info in image_infos(chart, texels, purpose) {
            bytes += info.bytes(device)?;
        }
        for info in buffer_infos(chart, texels, tuning, purpose) {
            bytes += info.bytes(device)?;
        }
        Ok(bytes)
    }

    /// Returns the record with this number, as the last recording that has run wrote it.
    pub(crate) fn record(&self, number: usize) -> Record {
        let bytes = &self.outcome.read()[number * size_of::<Record>()..];
        let record: *const Record = bytemuck::from_bytes(&bytes[..size_of::<Record>()]);
        // SAFETY: the buffer has this record. The device may be writing it; the caller compares the serial, which
        // shows whether the record is complete.
        unsafe { record.read_volatile() }
    }

    /// Returns all records, in mapped memory. An embedded grid has one for each frame in flight, and a last
    /// one of which only the serial is written.
    pub(crate) fn records(&self) -> &[Record] {
        let count = self.slots + 1;
        bytemuck::cast_slice(&self.outcome.read()[..count * size_of::<Record>()])
    }

    /// Returns whether the images have space for a slowness in addition to the Gaussian curvature.
    pub(crate) fn is_slowed(&self) -> bool {
        self.slowed
    }

    /// Returns the number of bands that may be transferred at the same time, each in a half of its own.
    pub(crate) fn halves(&self) -> usize {
        if self.staging.is_some() { HALVES } else { 1 }
    }

    /// Returns the halves that successive bands use alternately, without end.
    pub(crate) fn halves_in_turn(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.halves()).cycle()
    }

    /// Returns the bands of rows in which values of `point_bytes` bytes a point are uploaded.
    pub(crate) fn upload_bands(&self, point_bytes: usize) -> Vec<Range<usize>> {
        bands(self.chart, point_bytes, transfer_bytes(self.chart)).collect()
    }

    /// Returns the bands of rows in which distances are read back.
    pub(crate) fn read_back_bands(&self) -> Vec<Range<usize>> {
        let most = match self.staging.is_some() {
            true => staged_bytes(self.chart),
            false => transfer_bytes(self.chart),
        };
        bands(self.chart, size_of::<f32>(), most).collect()
    }

    /// Returns the memory to which edges and sources of a headless surface are written.
    pub(crate) fn upload_half(&mut self, half: usize) -> &mut [u8] {
        let bytes = upload_bytes(self.chart, transfer_bytes(self.chart));
        match &mut self.staging {
            Some([upload, _]) => upload.write(half),
            None => &mut self.upload.mapped()[..bytes],
        }
    }

    /// Returns the buffer and the offset of the bytes written to [`GridImages::upload_half`].
    pub(crate) fn upload_at(&self, half: usize) -> (vk::Buffer, u64) {
        self.staging.as_ref().map_or((self.upload.buffer, 0), |[upload, _]| upload.at(half))
    }

    /// Returns the largest number of bytes of sources at a time.
    pub(crate) fn source_room(&self) -> usize {
        source_bytes(self.chart, self.staging.is_some())
    }

    /// Returns the memory to which the anchors of a headless floor plan are written.
    pub(crate) fn anchors(&mut self) -> &mut [u8] {
        let bytes = self.source_room();
        self.has_anchors = true;
        match &mut self.staging {
            Some([upload, _]) => upload.write_further(),
            None => &mut self.upload.mapped()[bytes..][..ANCHOR_BYTES],
        }
    }

    /// Returns the copies of `sources` bytes of the first half, and of the anchors, to the buffers that shaders read;
    /// `None` if shaders read the memory that the program writes.
    pub(crate) fn inputs(&self, sources: u64) -> Option<[Copied; 2]> {
        let [upload, _] = self.staging.as_ref()?;
        let (to, room) = (self.upload.buffer, self.source_room() as u64);
        let anchors = if self.has_anchors { ANCHOR_BYTES as u64 } else { 0 };
        Some([(upload.at(0), (to, 0), sources), (upload.further_at(), (to, room), anchors)])
    }

    /// Returns the buffer and the offset to which distances are copied for the host; `None` if the host reads the
    /// buffer that shaders write.
    pub(crate) fn read_back_at(&self, half: usize) -> Option<(vk::Buffer, u64)> {
        self.staging.as_ref().map(|[_, read_back]| read_back.at(half))
    }

    /// Returns the memory in which the host finds distances that were read back.
    pub(crate) fn read_back(&self, half: usize) -> &[u8] {
        match &self.staging {
            Some([_, read_back]) => read_back.read(half),
            None => self.download.read(),
        }
    }

    /// Returns the bytes of device and staging memory held.
    pub(crate) fn bytes(&self) -> u64 {
        let images = [&self.edges, &self.gaussian, &self.fronts[0], &self.fronts[1]];
        let images = images.into_iter().chain(&self.results);
        let Self { progress, outcome, tiles, blocks, upload, download, .. } = self;
        let buffers = [progress, outcome, tiles, blocks, upload, download];
        images.map(|image| image.bytes()).sum::<u64>()
            + buffers.iter().map(|buffer| buffer.bytes()).sum::<u64>()
            + self.staging.iter().flatten().map(Staging::bytes).sum::<u64>()
            + self.copies.as_ref().map_or(0, Copies::bytes)
    }

    /// Frees everything. No submitted work may still use it.
    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        if let Some(copies) = &mut self.copies {
            copies.destroy(device, allocator);
        }
        self.sets.destroy(device);
        let [fronts0, fronts1] = &mut self.fronts;
        let images = [&mut self.edges, &mut self.gaussian, fronts0, fronts1];
        for image in images.into_iter().chain(&mut self.results) {
            image.destroy(device, allocator);
        }
        let Self { progress, outcome, tiles, blocks, upload, download, .. } = self;
        for buffer in [progress, outcome, tiles, blocks, upload, download] {
            buffer.destroy(device, allocator);
        }
        self.staging.iter_mut().flatten().for_each(|staging| staging.destroy(device, allocator));
    }
}

fn image_infos(
    chart: Chart,
    texels: TexelChart,
    purpose: Purpose<'_>,
) -> impl Iterator<Item = ImageInfo<'_>> {
    let grid =
        |name, extent, layers| ImageInfo { name, format: FORMAT, extent, layers, families: &[] };
    let Purpose { slowed, results, families, .. } = purpose;
    let mut gaussian = texels.fronts_extent();
    if slowed {
        gaussian.width *= 2;
    }
    let extent = vk::Extent3D { width: chart.cols as u32, height: chart.rows as u32, depth: 1 };
    let result =
        ImageInfo { name: "distances", format: RESULT_FORMAT, extent, layers: 1, families };
    [
        grid("edge lengths", texels.edges_extent(), 1),
        grid("Gaussian curvature", gaussian, 1),
        ImageInfo { families, ..grid("fronts 0", texels.fronts_extent(), LAYERS) },
        grid("fronts 1", texels.fronts_extent(), LAYERS),
    ]
    .into_iter()
    .chain(std::iter::repeat_n(result, results))
}

fn buffer_infos(
    chart: Chart,
    texels: TexelChart,
    tuning: Tuning,
    purpose: Purpose,
) -> [BufferInfo; 6] {
    use MemoryLocation::{CpuToGpu, GpuOnly, GpuToCpu};
    let is_staged = purpose.is_staged(tuning);
    let (upload, upload_location, outcomes, last) = match purpose.slots {
        None => {
            let upload = source_bytes(chart, is_staged) + ANCHOR_BYTES;
            let (most, locations) = match is_staged {
                true => (staged_bytes(chart), [GpuOnly; 2]),
                false => (transfer_bytes(chart), [CpuToGpu, GpuToCpu]),
            };
            (upload, locations[0], 1, ("read-back", distance_bytes(chart, most), locations[1]))
        }
        Some(slots) => {
            let upload = upload_bytes(purpose.lattice.with_halo(chart), frame_bytes(chart));
            // The additional record says how far the device has come.
            (upload, GpuOnly, slots + 1, ("sources", INLINE_SOURCES * SOURCE_BYTES, GpuOnly))
        }
    };
    [
        ("progress", progress::BYTES as usize, GpuOnly),
        ("outcome", outcomes * size_of::<Record>(), GpuToCpu),
        ("tiles", tiles_bytes(texels, tuning.on_grid(texels).tile), GpuOnly),
        ("blocks", blocks_bytes(texels, tuning.scan_lines), GpuOnly),
        ("upload", upload, upload_location),
        last,
    ]
    .map(|(name, size, location)| BufferInfo { name, size: size as u64, location })
}

/// Returns the names and sizes of the staging buffers: the size of a half, and the size of the bytes after both halves.
fn staging_infos(chart: Chart) -> [(&'static str, (usize, usize)); 2] {
    let upload = upload_bytes(chart, transfer_bytes(chart));
    let read_back = distance_bytes(chart, staged_bytes(chart));
    [("staging of uploads", (upload, ANCHOR_BYTES)), ("staging of distances", (read_back, 0))]
}

/// Returns the bytes stored for tiles. A tile has its state, the round that it waits for, an entry on each of two
/// lists, and its urgency in even and in odd rounds.
fn tiles_bytes(texels: TexelChart, tile: u32) -> usize {
    let [cols, rows] = texels.tiles(tile);
    TILE_WORDS * size_of::<u32>() * cols as usize * rows as usize
}

/// Returns the bytes of the dispatch arguments of all blocks in all scans.
fn blocks_bytes(texels: TexelChart, lines: u32) -> usize {
    Scan::ALL.len() * texels.block_pitch(lines) as usize * size_of::<[u32; 3]>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts what shaders read and write in the host's memory, beyond the bus of a device with memory of its
    /// own: distances, sources and anchors.
    #[test]
    fn shaders_of_staged_maps_leave_the_memory_of_the_host_alone() {
        for (side, written) in [(1200, 5_760_000), (4096, 67_108_864)] {
            let chart = Chart { rows: side, cols: side };
            let texels = TexelChart::new(chart).unwrap();
            for staged in [false, true] {
                let tuning = Tuning { staged, ..Tuning::ON_CPU };
                let all = buffer_infos(chart, texels, tuning, Purpose::headless(false));
                let beyond: Vec<_> = all
                    .into_iter()
                    .filter(|info| info.location != MemoryLocation::GpuOnly)
                    // Copies write the outcome.
                    .filter(|info| info.name != "outcome")
                    .collect();
                let distances = beyond.iter().find(|info| info.name == "read-back");
                let bytes = distances.map_or(0, |info| {
                    bands(chart, 4, info.size as usize)
                        .map(|rows| 4 * (rows.len() * side) as u64)
                        .sum()
                });
                println!("{side} x {side}, staged {staged}: {bytes} bytes of distances");
                assert_eq!(bytes, if staged { 0 } else { written });
                assert_eq!(beyond.len(), if staged { 0 } else { 2 });
                let host: usize =
                    staging_infos(chart).iter().map(|(_, (half, more))| HALVES * half + more).sum();
                assert!(host < (12 << 20) + 13 * chart.points(), "{host}");
            }
        }
    }
}
