//! Writes the descriptor sets of the host's images and buffers, and of images of distances.

use ash::vk;

use super::inputs::{PointMemory, Points, SourceBuffer};
use crate::constants::WORKGROUP;
use crate::surface::Chart;
use crate::vulkan::VulkanError;
use crate::vulkan::copies::Copies;
use crate::vulkan::device::descriptors::{self, HOST, write_part, write_view};
use crate::vulkan::device::labels::NameOf;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::pipelines::Pipelines;
use crate::vulkan::device::shaders::set_1;
use crate::vulkan::grid_images::{GridImages, INLINE_SOURCES};
use crate::vulkan::upload::SOURCE_BYTES;

/// Alignment of storage buffer offsets in bytes that satisfies every device.
const ALIGNMENT: u64 = 256;
/// Largest number of sources or places in a buffer. Every device can dispatch one invocation for each of
/// them.
const MOST_ENTRIES: u32 = 65_535 * WORKGROUP;
pub(super) const WORD: u64 = size_of::<f32>() as u64;

/// Part of a buffer: the range that its descriptor covers, and the position of its first word in that range.
#[derive(Clone, Copy, Debug)]
pub(super) struct BufferRange {
    buffer: vk::Buffer,
    start: u64,
    range: u64,
    first_word: i32,
    /// Number of bytes after the part that the part's descriptor also covers.
    room: u64,
}

impl BufferRange {
    pub(super) fn new(
        (device, limits): (&ash::Device, &Limits),
        what: &'static str,
        buffer: vk::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Self, VulkanError> {
        let refuse = |reason: String| VulkanError::HostBuffer { what, reason };
        if bytes == 0 {
            return Err(refuse("its count is 0".into()));
        }
        let start = offset / ALIGNMENT * ALIGNMENT;
        let range = offset - start + bytes;
        let most = limits.storage_range.min(i32::MAX as u64);
        if range > most {
            return Err(refuse(format!("it spans {bytes} bytes, and shaders see {most} at most")));
        }
        check_copied(device, what, (buffer, offset), bytes)?;
        let first_word = ((offset - start) / WORD) as i32;
        Ok(Self { buffer, start, range, first_word, room: 0 })
    }

    /// Returns the part with a descriptor that also covers the rest of the buffer, if shaders can access all
    /// of it.
    fn with_rest(self, (device, limits): (&ash::Device, &Limits)) -> Self {
        // SAFETY: the buffer is alive, by the host's promise.
        let holds = unsafe { device.get_buffer_memory_requirements(self.buffer) }.size;
        let rest = holds - self.start;
        match rest <= limits.storage_range.min(i32::MAX as u64) {
            true => Self { range: vk::WHOLE_SIZE, room: rest - self.range, ..self },
            false => self,
        }
    }
}

/// Returns an error if a part extends beyond its buffer. Vulkan does not report the size of a buffer. The
/// check uses the size in the buffer's memory requirements instead, which some drivers round up.
pub(super) fn check_extent(
    device: &ash::Device,
    what: &'static str,
    buffer: vk::Buffer,
    offset: u64,
    bytes: u64,
) -> Result<(), VulkanError> {
    // SAFETY: the buffer is alive, by the host's promise.
    let holds = unsafe { device.get_buffer_memory_requirements(buffer) }.size;
    let end = offset.saturating_add(bytes);
    if end > holds {
        let reason = format!("it must have {end} bytes, but has {holds} at most");
        return Err(VulkanError::HostBuffer { what, reason });
    }
    Ok(())
}

/// Returns an error if a part of a host's buffer cannot be the source or destination of a copy.
pub(super) fn check_copied(
    device: &ash::Device,
    what: &'static str,
    (buffer, offset): (vk::Buffer, u64),
    bytes: u64,
) -> Result<(), VulkanError> {
    let refuse = |reason: String| Err(VulkanError::HostBuffer { what, reason });
    if buffer == vk::Buffer::null() {
        return refuse("it is the null handle".into());
    }
    if !offset.is_multiple_of(WORD) {
        return refuse(format!("its offset {offset} is no multiple of 4 bytes"));
    }
    check_extent(device, what, buffer, offset, bytes)
}

/// Descriptor set, and the positions of the first words in its buffers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HostSet {
    pub(super) set: vk::DescriptorSet,
    pub(super) first_word: i32,
    pub(super) first_output: i32,
    /// Number of bytes by which the start of the input may be moved.
    pub(super) room: u64,
}

impl HostSet {
    /// Returns the set with the start of the input moved by `offset` bytes.
    pub(super) fn at(self, what: &'static str, offset: u64) -> Result<Self, VulkanError> {
        let refuse = |reason| Err(VulkanError::HostBuffer { what, reason });
        if !offset.is_multiple_of(WORD) {
            return refuse(format!("the frame's offset {offset} is no multiple of 4 bytes"));
        }
        if offset > self.room {
            return refuse(format!(
                "the frame's offset {offset} is beyond the {} bytes that can be reached from where the surface \
                 has them: replace the input by set_points or set_sources",
                self.room
            ));
        }
        Ok(Self { first_word: self.first_word + (offset / WORD) as i32, ..self })
    }
}

/// Content of a descriptor set: an image or an input buffer, and perhaps an output buffer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Content {
    /// Binding, view and layout of the image.
    image: Option<(u32, vk::ImageView, vk::ImageLayout)>,
    input: Option<BufferRange>,
    output: Option<BufferRange>,
}

impl Content {
    /// Returns the content for an image of distances.
    pub(super) fn result(view: vk::ImageView) -> Self {
        Self { image: Some((set_1::DISTANCES, view, vk::ImageLayout::GENERAL)), ..Self::default() }
    }

    fn texture(view: vk::ImageView, layout: vk::ImageLayout) -> Self {
        Self { image: Some((set_1::IMAGE, view, layout)), ..Self::default() }
    }

    pub(super) fn input(part: BufferRange) -> Self {
        Self { input: Some(part), ..Self::default() }
    }

    /// Returns the content with an output buffer added.
    pub(super) fn and_output(self, output: BufferRange) -> Self {
        Self { output: Some(output), ..self }
    }

    /// Returns the name of the set in debugging tools.
    fn name(self) -> &'static str {
        match (self.image, self.output) {
            (Some((set_1::DISTANCES, ..)), _) => "writes distances",
            (Some(_), None) => "reads an image of the host's",
            (Some(_), Some(_)) => "reads an image of the host's, writes what it draws",
            (None, None) => "reads a buffer",
            (None, Some(_)) => "reads a buffer, writes another",
        }
    }
}

/// Creates a pool with a descriptor set for each of the contents, in their order.
pub(super) fn describe(
    device: &ash::Device,
    pipelines: &Pipelines,
    contents: &[Content],
    owner: &str,
) -> Result<(vk::DescriptorPool, Vec<HostSet>), VulkanError> {
    let (pool, sets) = descriptors::allocate(device, pipelines, &vec![HOST; contents.len()])?;
    let filled = sets.into_iter().zip(contents).map(|(set, &content)| {
        pipelines.name(NameOf(content.name(), owner), set);
        fill(device, set, content)
    });
    Ok((pool, filled.collect()))
}

/// Returns the content for the sources that a recording contains itself.
pub(super) fn inline_sources_content(
    on: (&ash::Device, &Limits),
    grid: &GridImages,
) -> Result<Content, VulkanError> {
    let bytes = (INLINE_SOURCES * SOURCE_BYTES) as u64;
    Ok(Content::input(BufferRange::new(on, "the inline sources", grid.download.buffer, 0, bytes)?))
}

/// Returns the contents for the inline sources and for each source buffer.
pub(super) fn all_sources(
    on: (&ash::Device, &Limits),
    grid: &GridImages,
    buffers: &[SourceBuffer],
) -> Result<Vec<Content>, VulkanError> {
    let inline = inline_sources_content(on, grid);
    std::iter::once(inline).chain(buffers.iter().map(|of| sources_content(on, of))).collect()
}

pub(super) fn sources_content(
    on: (&ash::Device, &Limits),
    sources: &SourceBuffer,
) -> Result<Content, VulkanError> {
    let SourceBuffer { buffer, offset, count } = *sources;
    check_count("sources", count)?;
    let bytes = u64::from(count) * SOURCE_BYTES as u64;
    Ok(Content::input(BufferRange::new(on, "sources", buffer, offset, bytes)?.with_rest(on)))
}

pub(super) fn check_count(what: &'static str, count: u32) -> Result<(), VulkanError> {
    if count > MOST_ENTRIES {
        let reason =
            format!("{count} entries are more than the {MOST_ENTRIES} that a buffer may hold");
        return Err(VulkanError::HostBuffer { what, reason });
    }
    Ok(())
}

pub(super) fn points_content(
    on: (&ash::Device, &Limits),
    points: &Points,
    chart: Chart,
) -> Result<Content, VulkanError> {
    let refuse = |reason: String| Err(VulkanError::HostBuffer { what: "points", reason });
    match points.memory {
        PointMemory::Image { .. } if points.floats() > 4 => {
            refuse("an image has four components, and the slowness is beyond them".into())
        }
        PointMemory::Image { view, .. } if view == vk::ImageView::null() => {
            refuse("the view is the null handle".into())
        }
        PointMemory::Image { view, layout } => Ok(Content::texture(view, layout)),
        PointMemory::Buffer { buffer, offset, stride } => {
            let bytes = WORD * points.floats();
            if !stride.is_multiple_of(WORD) || stride == 0 {
                return refuse(format!("a stride of {stride} bytes is no positive multiple of 4"));
            }
            let bytes = (chart.points() as u64 - 1).saturating_mul(stride).saturating_add(bytes);
            Ok(Content::input(BufferRange::new(on, "points", buffer, offset, bytes)?.with_rest(on)))
        }
    }
}

/// Returns the content for points that are measured. On a glued surface it includes the list of copies.
pub(super) fn measured_content(
    on: (&ash::Device, &Limits),
    points: &Points,
    grid: &GridImages,
) -> Result<Content, VulkanError> {
    let content = points_content(on, points, grid.chart)?;
    let Some((buffer, at, bytes)) = grid.copies.as_ref().and_then(Copies::by_rows) else {
        return Ok(content);
    };
    Ok(content.and_output(BufferRange::new(on, "copies", buffer, at, bytes)?))
}

/// Writes the content to a descriptor set that no submitted work uses.
pub(super) fn fill(device: &ash::Device, set: vk::DescriptorSet, content: Content) -> HostSet {
    let Content { image, input, output } = content;
    if let Some((index, view, layout)) = image {
        write_view(device, (set, index, set_1::KINDS[index as usize]), view, layout);
    }
    for (index, part) in [(set_1::INPUT, input), (set_1::OUTPUT, output)] {
        if let Some(part) = part {
            write_part(device, set, index, (part.buffer, part.start, part.range));
        }
    }
    let first_word = |part: Option<BufferRange>| part.map_or(0, |part| part.first_word);
    let room = input.map_or(0, |part| part.room);
    HostSet { set, first_word: first_word(input), first_output: first_word(output), room }
}
