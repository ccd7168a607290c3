//! Records a map's targets, and the pass that ends the map once they are reached.

use super::plan::Step;
use super::progress::offset;
use crate::constants::{SCANS_FOLLOW, TILES_FOLLOW};
use crate::vulkan::MapLimit;
use crate::vulkan::device::passes::TARGETS;
use crate::vulkan::device::shaders::targets;
use crate::vulkan::record::{Groups, PassKind, Recorder};

impl Recorder<'_> {
    /// Writes the targets of a map, if it has any. The caller records the barriers.
    pub(super) fn write_targets(&self, limit: MapLimit) {
        let MapLimit { targets, needed, .. } = limit;
        if targets.is_empty() {
            return;
        }
        let count = targets.len() as u32;
        let numbers = [count, needed.min(count)];
        let progress = self.grid.progress.buffer;
        self.update(progress, offset::TARGET_COUNT, bytemuck::cast_slice(&numbers));
        self.update(progress, offset::TARGETS, bytemuck::cast_slice(targets));
    }

    /// Records the pass that lowers the limit of a map to the time that its targets need, if a round or an
    /// iteration ends with the step `after`. Returns whether the pass has been recorded.
    pub(super) fn lower_limit(&self, after: Option<&Step>) -> bool {
        let follows = match after {
            Some(Step::Tiles { .. }) => TILES_FOLLOW,
            Some(Step::Count) => SCANS_FOLLOW,
            _ => return false,
        };
        let _pass = self.pass(PassKind::Targets);
        let texels = self.grid.texels.inner().map(|texels| texels as i32);
        let pipeline = self.pipelines.of(TARGETS);
        self.bind_writing(pipeline, 0);
        let tile_texels = self.tile() as i32 / 2;
        let push = targets::Push { texels, tile_texels, follows };
        self.dispatch(pipeline, &push, Groups::line(1));
        true
    }
}
