//! Defines the queries and buffers of the host that a profile may use.

use ash::vk;

use super::decisions;

/// Range of a query pool of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueryRange {
    /// Query pool.
    pub pool: vk::QueryPool,
    /// First query of the range.
    pub first: u32,
    /// Number of queries.
    pub count: u32,
}

/// Queries and buffers of the host that a profile may use. Each is optional: without it, records lack its values.
///
/// The sizes are for `passes` passes in a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Slots {
    /// `passes + 1` queries of a pool of type `TIMESTAMP`. The first is written at the start of the
    /// recording, and the following ones at the end of each pass in turn. With [`super::Grain::Portions`] the last
    /// ones stay unused.
    pub timestamps: Option<QueryRange>,
    /// `passes` queries, one for each pass, of a pool of type `PIPELINE_STATISTICS` with the single statistic
    /// `COMPUTE_SHADER_INVOCATIONS`. The device feature `pipelineStatisticsQuery` must be enabled. These
    /// queries may make passes slower, so count invocations in other frames than those that you time.
    pub statistics: Option<QueryRange>,
    /// Buffer for the device's decisions, such as the tiles that it has visited. The buffer must have the
    /// usage `TRANSFER_DST` and be readable by the host. It has [`Slots::DECISION_BYTES`] for each call of
    /// [`super::super::embed::Recording::solve`], `add` or `resume` in a recording, from an offset that is a
    /// multiple of 4.
    pub decisions: Option<Decided>,
    /// Buffer, and offset in it, for the numbers of the tiles that each round has visited, row by row of tiles. Leave
    /// it `None` unless you want to draw the tiles, since the copies take time. The buffer must be like that of
    /// `decisions`, with four bytes for each tile of the grid and each round of the plan. It keeps the last portion
    /// only.
    pub tile_lists: Option<(vk::Buffer, u64)>,
}

/// Buffer for the device's decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// Buffer.
    pub buffer: vk::Buffer,
    /// Offset in the buffer, in bytes.
    pub offset: u64,
    /// Number of portions for which the buffer has room.
    pub portions: u32,
}

impl Slots {
    /// Bytes of a portion of steps in [`Slots::decisions`].
    pub const DECISION_BYTES: u64 = decisions::BYTES;

    /// Sets [`Slots::timestamps`].
    pub fn with_timestamps(self, range: QueryRange) -> Self {
        Self { timestamps: Some(range), ..self }
    }

    /// Sets [`Slots::statistics`].
    pub fn with_statistics(self, range: QueryRange) -> Self {
        Self { statistics: Some(range), ..self }
    }

    /// Sets [`Slots::decisions`].
    pub fn with_decisions(self, decided: Decided) -> Self {
        Self { decisions: Some(decided), ..self }
    }

    /// Sets [`Slots::tile_lists`].
    pub fn with_tile_lists(self, buffer: vk::Buffer, offset: u64) -> Self {
        Self { tile_lists: Some((buffer, offset)), ..self }
    }
}
