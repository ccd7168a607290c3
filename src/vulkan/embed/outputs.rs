//! Images of the host's that distances are written to.

use ash::vk;

use super::host_sets::Content;
use super::recording::nth;
use super::surface::Surface;
use crate::vulkan::VulkanError;

/// An image of the host's for the distances of a slot, in place of one that the surface makes: so that a render
/// graph gives its memory to others while no one needs it.
///
/// Of format R32_SFLOAT, 2D, of N x M texels or more (width x height), a single sample and one level, with usage `STORAGE` and
/// that of its readers. [`super::Recording::result`] throws away what is there: in which layout the image is before, and whether
/// its memory was another's, is of no interest, but that the readers and writers of what was there are waited for, with
/// the stages of [`super::Recording::begin`] or by a barrier of the host's. A surface that is larger than the image writes
/// what has room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostImage {
    /// The image.
    pub image: vk::Image,
    /// A view of the level, as R32_SFLOAT.
    pub view: vk::ImageView,
}

impl HostImage {
    pub(super) fn check(&self) -> Result<(), VulkanError> {
        let refuse = |reason: &str| {
            Err(VulkanError::HostBuffer { what: "distances", reason: reason.into() })
        };
        if self.image == vk::Image::null() {
            return refuse("the image is the null handle");
        }
        if self.view == vk::ImageView::null() {
            return refuse("the view is the null handle");
        }
        Ok(())
    }
}

impl Surface {
    /// Replaces the host's image for the distances of a slot, for recordings from now on, as a render graph does whose
    /// transient images are others in each frame. Frames in flight go on with the one that they were recorded for.
    ///
    /// # Errors
    /// If there is no such slot, the surface has images of its own, or so many were given while frames are in flight
    /// that no descriptor set is left. Then nothing has changed.
    pub fn set_result(
        &mut self,
        device: &ash::Device,
        slot: usize,
        image: HostImage,
    ) -> Result<(), VulkanError> {
        nth(&self.sets.results, "slots", slot)?;
        self.state.check_there()?;
        if self.results.is_empty() {
            return Err(VulkanError::OwnResults);
        }
        image.check()?;
        let content = Content::Result(image.view);
        self.sets.results[slot].replace(device, &self.flight, ("distances", slot), content)?;
        self.results[slot] = image;
        Ok(())
    }
}
