//! Allocates the images and buffers of a surface and its map on the device.

use std::ops::Range;

use super::device::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::anchors::ANCHOR_BYTES;
use super::device::descriptors::{Contents, GridSets};
use super::device::memory::{Buffer, BufferInfo, FORMAT, Image, ImageInfo, RESULT_FORMAT};
use super::device::pipelines::Pipelines;
use super::schedules::plan::Scan;
use super::schedules::progress;
use super::schedules::progress::Record;
use super::upload::SOURCE_BYTES;
use super::{TexelChart, Tuning, VulkanError};
use crate::constants::LAYERS;
use crate::surface::Chart;

/// Largest number of bytes of a band of rows. Edges are uploaded, points measured and distances read back in
/// bands.
const BAND_BYTES: usize = 16 << 20;
/// Smallest size of the upload buffer in bytes: room for the sources on a small grid.
const LEAST_UPLOAD_BYTES: usize = 64 << 10;
/// Largest number of bytes of a point: position and slowness, or its edges.
pub(crate) const POINT_BYTES: usize = 16;

/// Numbers that are kept for a tile.
pub(crate) const TILE_WORDS: usize = 6;

/// Largest number of sources in a recording.
pub(crate) const INLINE_SOURCES: usize = 1024;

/// Purpose of a grid's images.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose<'a> {
    /// Headless solving. Edges and sources come from the program's memory, and distances go back there. Both
    /// pass through buffers of 4 bytes a point, up to 16 MiB each. The upload buffer has room for anchors
    /// after the edges. If the slowness of the surface is uneven, it is on the device too, 4 bytes a point.
    Headless { slowed: bool },
    /// Embedding in a renderer. Everything stays on the device. `slots` is the number of frames in flight,
    /// `results` the number of images of distances, and `families` are the queue families that use these
    /// images.
    Embedded { slots: usize, results: usize, families: &'a [u32], slowed: bool },
}

impl Purpose<'_> {
    fn slots(self) -> usize {
        match self {
            Self::Headless { .. } => 0,
            Self::Embedded { slots, .. } => slots,
        }
    }

    /// Returns whether there is a slowness beside the Gaussian curvature.
    fn is_slowed(self) -> bool {
        match self {
            Self::Headless { slowed } | Self::Embedded { slowed, .. } => slowed,
        }
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
    /// Number of frames in flight.
    pub(crate) slots: usize,
    pub(crate) fronts: [Image; 2],
    pub(crate) results: Vec<Image>,
    pub(crate) progress: Buffer,
    pub(crate) outcome: Buffer,
    pub(crate) tiles: Buffer,
    pub(crate) blocks: Buffer,
    pub(crate) upload: Buffer,
    /// Buffer of distances to read back, or of sources that a recording contains.
    pub(crate) download: Buffer,
    pub(crate) sets: GridSets,
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
        let created = (|| {
            for info in image_infos(chart, texels, purpose) {
                images.push(Image::new(device, allocator, info)?);
                pipelines.name_image(info.name, &images[images.len() - 1]);
            }
            for info in buffer_infos(chart, texels, pipelines.tuning, purpose) {
                buffers.push(Buffer::new(device, allocator, info)?);
                pipelines.name(info.name, buffers[buffers.len() - 1].buffer);
            }
            let ([edges, gaussian, fronts @ ..], [progress, _, tiles, blocks, points, distances]) =
                (&images[..4], &buffers[..])
            else {
                unreachable!("four images come before the results, and there are six buffers")
            };
            let contents = Contents {
                edges,
                gaussian,
                fronts: Some([&fronts[0], &fronts[1]]),
                points: Some(points),
                progress,
                tiles: Some(tiles),
                blocks,
                distances,
            };
            GridSets::new(device, pipelines, contents)
        })();
        let sets = match created {
            Ok(sets) => sets,
            Err(error) => {
                images.iter_mut().for_each(|image| image.destroy(device, allocator));
                buffers.iter_mut().for_each(|buffer| buffer.destroy(device, allocator));
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
            slowed: purpose.is_slowed(),
            slots: purpose.slots(),
            fronts: [fronts0, fronts1],
            results,
            progress,
            outcome,
            tiles,
            blocks,
            upload,
            download,
            sets,
        })
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
        // SAFETY: the record is there. The device may be writing it; whoever reads it too early learns that
        // from its serial.
        unsafe { record.read_volatile() }
    }

    /// Returns all records, in mapped memory. An embedded grid has one for each frame in flight, and a last
    /// one of which only the serial is written.
    pub(crate) fn records(&self) -> &[Record] {
        let count = self.slots + 1;
        bytemuck::cast_slice(&self.outcome.read()[..count * size_of::<Record>()])
    }

    /// Returns whether there is room for a slowness beside the Gaussian curvature.
    pub(crate) fn is_slowed(&self) -> bool {
        self.slowed
    }

    /// Returns the memory to which edges and sources of a headless surface are written.
    pub(crate) fn staging(&mut self) -> &mut [u8] {
        let bytes = upload_bytes(self.chart, transfer_bytes(self.chart));
        &mut self.upload.mapped()[..bytes]
    }

    /// Returns the memory in which shaders find the anchors of a headless floor plan.
    pub(crate) fn anchors(&mut self) -> &mut [u8] {
        let bytes = upload_bytes(self.chart, transfer_bytes(self.chart));
        &mut self.upload.mapped()[bytes..][..ANCHOR_BYTES]
    }

    /// Returns the bytes of device and staging memory held.
    pub(crate) fn bytes(&self) -> u64 {
        let images = [&self.edges, &self.gaussian, &self.fronts[0], &self.fronts[1]];
        let images = images.into_iter().chain(&self.results);
        let Self { progress, outcome, tiles, blocks, upload, download, .. } = self;
        let buffers = [progress, outcome, tiles, blocks, upload, download];
        images.map(|image| image.bytes()).sum::<u64>()
            + buffers.iter().map(|buffer| buffer.bytes()).sum::<u64>()
    }

    /// Frees everything. No submitted work may still use it.
    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
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
    }
}

fn image_infos(
    chart: Chart,
    texels: TexelChart,
    purpose: Purpose<'_>,
) -> impl Iterator<Item = ImageInfo<'_>> {
    let grid =
        |name, extent, layers| ImageInfo { name, format: FORMAT, extent, layers, families: &[] };
    let (results, families) = match purpose {
        Purpose::Headless { .. } => (0, &[][..]),
        Purpose::Embedded { results, families, .. } => (results, families),
    };
    let mut gaussian = texels.fronts_extent();
    if purpose.is_slowed() {
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
    let most = match purpose {
        Purpose::Headless { .. } => transfer_bytes(chart),
        Purpose::Embedded { .. } => frame_bytes(chart),
    };
    let (upload_location, outcomes, last) = match purpose {
        Purpose::Headless { .. } => {
            let bytes = band_rows(chart, size_of::<f32>(), most) * chart.cols * size_of::<f32>();
            (CpuToGpu, 1, ("read-back", bytes, GpuToCpu))
        }
        Purpose::Embedded { slots, .. } => {
            // The additional record says how far the device has come.
            (GpuOnly, slots + 1, ("sources", INLINE_SOURCES * SOURCE_BYTES, GpuOnly))
        }
    };
    let anchors = if matches!(purpose, Purpose::Headless { .. }) { ANCHOR_BYTES } else { 0 };
    let upload = upload_bytes(chart, most) + anchors;
    [
        ("progress", progress::BYTES as usize, GpuOnly),
        ("outcome", outcomes * size_of::<Record>(), GpuToCpu),
        ("tiles", tiles_bytes(texels, tuning.tile), GpuOnly),
        ("blocks", blocks_bytes(texels, tuning.scan_lines), GpuOnly),
        ("upload", upload, upload_location),
        last,
    ]
    .map(|(name, size, location)| BufferInfo { name, size: size as u64, location })
}

/// Returns the bytes of the upload buffer, for points in bands of at most `most` bytes, and for sources.
pub(crate) fn upload_bytes(chart: Chart, most: usize) -> usize {
    let points = (band_rows(chart, POINT_BYTES, most) + HALO) * chart.cols * POINT_BYTES;
    points.max(LEAST_UPLOAD_BYTES)
}

/// Returns the bytes kept for tiles. For each tile they are its state, the round that it waits for, a place
/// on each of two lists, and its urgency in even and in odd rounds.
fn tiles_bytes(texels: TexelChart, tile: u32) -> usize {
    let [cols, rows] = texels.tiles(tile);
    TILE_WORDS * size_of::<u32>() * cols as usize * rows as usize
}

/// Returns the bytes of the dispatch arguments of each block in each scan.
fn blocks_bytes(texels: TexelChart, lines: u32) -> usize {
    Scan::ALL.len() * texels.block_pitch(lines) as usize * size_of::<[u32; 3]>()
}

/// Returns the bytes of a band that is transferred between the program's memory and the device: 4 for each
/// point of the grid. The buffers then take a sixth of the memory of the map. Bands of small grids are
/// larger, since another submission would take longer than it is worth.
pub(crate) fn transfer_bytes(chart: Chart) -> usize {
    (4 * chart.points()).clamp(256 << 10, BAND_BYTES)
}

/// Returns the bytes of a band of a host's points: 6 for each point of the grid, which gives three bands.
/// Points are measured band by band in each frame in which they change. Grids of up to 512 x 512 points are
/// measured at once: there the time of two more passes would outweigh the memory that they save.
pub(crate) fn frame_bytes(chart: Chart) -> usize {
    (6 * chart.points()).clamp(4 << 20, BAND_BYTES)
}

/// Returns the rows of a band of at most `most` bytes. The number is even, so that a texel lies in one band.
fn band_rows(chart: Chart, point_bytes: usize, most: usize) -> usize {
    let rows = most / (chart.cols * point_bytes);
    (rows / 2 * 2).clamp(2, chart.rows.next_multiple_of(2))
}

/// Returns the grid's rows in bands of at most `most` bytes.
pub(crate) fn bands(
    chart: Chart,
    point_bytes: usize,
    most: usize,
) -> impl Iterator<Item = Range<usize>> {
    let step = band_rows(chart, point_bytes, most);
    (0..chart.rows).step_by(step).map(move |row| row..(row + step).min(chart.rows))
}

/// Returns the rows whose points are needed to measure the edges of a band. An edge to the north also depends
/// on how the surface bends at its other end. At an end where the line ends, it depends on the next two
/// points inwards.
pub(crate) fn rows_around(band: &Range<usize>, chart: Chart) -> Range<usize> {
    band.start.saturating_sub(BEFORE)..(band.end + AFTER).min(chart.rows)
}

const BEFORE: usize = 3;
const AFTER: usize = 2;
/// Largest number of rows around a band.
const HALO: usize = BEFORE + AFTER;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once() {
        let chart = Chart { rows: 4099, cols: 3000 };
        let bands: Vec<_> = bands(chart, POINT_BYTES, BAND_BYTES).collect();
        assert!(bands.len() > 2);
        assert!(bands.iter().all(|band| band.start.is_multiple_of(2)));
        assert_eq!(bands.iter().map(|band| band.len()).sum::<usize>(), chart.rows);
        assert!(bands.windows(2).all(|pair| pair[0].end == pair[1].start));
    }
}
