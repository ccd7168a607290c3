//! Describes the host's own images of distances.

use ash::vk;

use crate::vulkan::VulkanError;

/// Image of the host for the distances of a slot, in place of one that the surface allocates. A render graph
/// can then use its memory for other resources while the distances are not needed.
///
/// The image is 2D, of format R32_SFLOAT, with at least N x M texels (width x height), one sample and one mip
/// level. Its usage is `STORAGE` and whatever its readers need. If the image is smaller than the surface, the
/// distances outside it are not written. For directions and log maps, the function that takes the image states its
/// format and usage.
///
/// [`super::Recording::result`] discards the previous contents. The previous layout does not matter, nor does
/// it matter whether the memory belonged to another resource. Earlier readers and writers of the memory must
/// have finished: name their stages in [`super::Recording::begin`], or record a barrier.
///
/// The host keeps the image and the view alive until all recordings that write them have run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostImage {
    /// Image handle.
    pub image: vk::Image,
    /// View of the image's mip level, in the format of the image.
    pub view: vk::ImageView,
}

impl HostImage {
    pub(super) fn check(&self, what: &'static str) -> Result<(), VulkanError> {
        let refuse = |reason: &str| Err(VulkanError::HostBuffer { what, reason: reason.into() });
        if self.image == vk::Image::null() {
            return refuse("the image is the null handle");
        }
        if self.view == vk::ImageView::null() {
            return refuse("the view is the null handle");
        }
        Ok(())
    }
}
