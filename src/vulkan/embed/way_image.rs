//! Computes an image with two numbers for each grid point in a buffer, and copies it: directions and log maps.

use ash::vk;

use super::access::{Access, Reader};
use super::curves;
use super::inputs::SourceInput;
use super::outputs::{ImageKind, Output, OutputInfo};
use super::recording::Recording;
use super::starts::{MapPasses, Starts, WORD};
use super::surface::ResultImage;
use crate::constants::WAYS_HEADER;
use crate::surface::Chart;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{
    SHADER, SHADER_WRITE, TRANSFER, TRANSFER_READ, TRANSFER_WRITE,
};
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::ImageInfo;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;

/// Kind of an output with an image of this form.
pub trait WayKind: ImageKind {
    const WAYS: Ways;
}

/// Contents of the image, and their position in the buffer.
#[derive(Clone, Copy, Debug)]
pub struct Ways {
    pub(super) what: &'static str,
    pub(super) format: vk::Format,
    pub(super) pass: PassKind,
    /// Number of words of the buffer for each grid point, after the header.
    pub(super) point_words: u64,
    /// Number of these words that precede the words copied to the image.
    pub(super) words_before: u64,
}

impl Ways {
    pub(super) fn info(self, limits: &Limits, chart: Chart) -> Result<OutputInfo, VulkanError> {
        let Self { what: name, format, .. } = self;
        limits.texels(chart)?;
        let words = self.point_words.saturating_mul(chart.points() as u64);
        let size = WORD.saturating_mul(words.saturating_add(WAYS_HEADER.into()));
        let image = ImageInfo { name, format, extent: extent(chart), layers: 1, families: &[] };
        let (buffer, image) = (curves::buffer_info(name, limits, size)?, Some(image));
        Ok(OutputInfo { buffer, counts: None, image, curves: None, passes: 0 })
    }
}

fn extent(chart: Chart) -> vk::Extent3D {
    vk::Extent3D { width: chart.cols as u32, height: chart.rows as u32, depth: 1 }
}

impl<K: WayKind> Output<K> {
    /// Records the passes that find the sources beside each grid point. Returns a recorder for the passes that follow,
    /// and their constants. The sources were checked before.
    pub(super) fn start<'a>(
        &self,
        recording: &'a Recording<'a>,
        sources: SourceInput,
        before: Access,
        starts: Starts<Push>,
    ) -> Result<(MapPasses<'a>, Push), VulkanError> {
        let (stages, access) = before.side();
        let ours = (TRANSFER.0 | SHADER.0, TRANSFER.1 | SHADER.1);
        recording.recorder.barrier((stages | ours.0, access | ours.1), ours);
        let passes = self.begin(recording, (K::WAYS.pass, WAYS_HEADER), sources)?;
        let (grid, first_word, count) = passes.sources();
        let push = Push {
            grid,
            lattice: recording.surface.grid.lattice.codes(),
            first_word,
            count,
            turn: 0,
            radius: f32::INFINITY,
            unreached: 0.0,
            slowed: recording.surface.grid.is_slowed().into(),
        };
        passes.find_sources(starts, |turn| Push { turn, ..push });
        Ok((passes, push))
    }

    /// Records the copy to the image, for `reader`. These are the last commands of a recording.
    pub(super) fn copy(&self, passes: &MapPasses, reader: Reader) -> ResultImage {
        let Recording { recorder, .. } = passes.recording;
        let result = self.image(reader.layout);
        let points = self.chart.points() as u64;
        let start = WORD * (u64::from(WAYS_HEADER) + K::WAYS.words_before * points);
        let texel = if result.format == vk::Format::R16G16_SFLOAT { WORD } else { 2 * WORD };
        let pass = recorder.pass_moving(K::WAYS.pass, [Some(texel * points); 2]);
        recorder.barrier(SHADER_WRITE, TRANSFER_READ);
        let (stages, access) = reader.access.side();
        let before = (stages | TRANSFER_WRITE.0, access | TRANSFER_WRITE.1);
        let copied = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let layouts = (vk::ImageLayout::UNDEFINED, copied);
        recorder.image_barrier(result.image, before, TRANSFER_WRITE, layouts);
        let whole = (vk::Offset3D::default(), extent(self.chart));
        recorder.copy_to_image((self.buffer(), start), (result.image, copied), whole);
        let layouts = (copied, reader.layout);
        recorder.image_barrier(result.image, TRANSFER_WRITE, reader.access.side(), layouts);
        drop(pass);
        self.end(passes.recording);
        result
    }
}
