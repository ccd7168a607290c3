//! Points of a surface and where they are stored.

use ash::vk;
use ash::vk::Handle;
use bytemuck::cast_slice;
use glam::DVec3;
use gpu_allocator::MemoryLocation;

use super::arguments::list;
use super::choices::{choices, choose};
use super::shared::Shared;
use super::status::Failure;
use geosweep::surface::{
    Chart, EdgeRule, Geometry, LONGEST_EDGE, MetricTensor, Spacing, Surface, SurfaceError,
};
use geosweep::vulkan::embed::{self, Buffer, BufferInfo, DeviceMemory};

/// Meaning of the floats of a grid point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepPointKind {
    /// Three coordinates, x, y and z.
    Positions = 0,
    /// A height. The point at row r and column c is (c dx, r dy, height).
    Heights = 1,
    /// A metric in index coordinates: rr, rc and cc. A step of dr rows and dc columns has the squared length
    /// rr dr^2 + 2 rc dr dc + cc dc^2. The metric is positive definite, and its entries are at most 1e12.
    Metric = 2,
}

choices! { GeosweepPointKind = GeosweepPointKind: Positions, Heights, Metric; }

/// Number of a `GeosweepPointKind`, not checked yet.
type PointKindNumber = i32;

/// Points of a surface, one for each grid point, row by row. They are in your own buffer or image on the
/// device, which recordings read when they measure edges, or in the program's memory, from which the call
/// copies them. Exactly one of `buffer`, `view` and `data` is not null.
///
/// On the device, a point is a hole if one of its floats is NaN, infinite or beyond 1e12, or if its slowness
/// is negative. In the program's memory, NaN, an infinite slowness and the mask make holes; other invalid
/// values are errors. Travel is free where the slowness is 0. On the device, a slowness below 1e-12 counts as
/// 1e-12.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPoints {
    /// Meaning of the first floats of a point.
    pub kind: PointKindNumber,
    /// Index, counted from 0, of that float of a point which is its slowness: time per length. Distances are
    /// then travel times. An index of 0 stands for a slowness of 1 everywhere.
    pub slowness: u32,
    /// Distance between columns, for heights.
    pub dx: f64,
    /// Distance between rows, for heights.
    pub dy: f64,
    /// A buffer with usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    pub buffer: vk::Buffer,
    /// A 2D view of an image with usage `VK_IMAGE_USAGE_SAMPLED_BIT`. Its texels are the points: x is the
    /// column, and y is the row.
    pub view: vk::ImageView,
    /// Layout of that image whenever it is read.
    pub layout: vk::ImageLayout,
    /// Array in the program's memory, which is not needed after the call.
    pub data: *const f32,
    /// Mask for `data`, or null: rows x cols bytes, 0 for a hole.
    pub mask: *const u8,
    /// Offset of the first point in `buffer` or `data` in bytes; a multiple of 4.
    pub offset: u64,
    /// Bytes from point to point in `buffer` or `data`; a multiple of 4.
    pub stride: u64,
}

/// Points as requested, by where they are stored.
#[derive(Clone, Copy)]
pub(super) enum Form {
    OnDevice(embed::Points),
    InProgram(Layout, Arrays),
}

/// Layout of points in an array of the program.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    kind: embed::PointKind,
    /// Index of the slowness among the floats of a point.
    slowness: Option<usize>,
    /// Offset of the first point, in floats.
    offset: usize,
    stride: usize,
}

/// Arrays of the program, valid during a call.
#[derive(Clone, Copy)]
pub(super) struct Arrays {
    pub(super) data: *const f32,
    pub(super) mask: *const u8,
}

impl Form {
    pub(super) fn of(given: &GeosweepPoints, name: &str) -> Result<Self, Failure> {
        let field = |field| format!("{name}.{field}");
        use GeosweepPointKind as K;
        let kind = match choose(given.kind, &field("kind"))? {
            K::Positions => embed::PointKind::Positions,
            K::Metric => embed::PointKind::Metric,
            K::Heights => {
                let spacing = Spacing { dx: given.dx, dy: given.dy };
                if !spacing.is_usable() {
                    let error = SurfaceError::Spacing { dx: given.dx, dy: given.dy };
                    return Err(Failure::argument(&field("dx"), format!("or dy: {error}")));
                }
                embed::PointKind::Heights(spacing)
            }
        };
        if !matches!(kind, embed::PointKind::Heights(_)) && (given.dx != 0.0 || given.dy != 0.0) {
            let reason = "or dy is not 0, and only heights have a distance between columns and rows: \
                          their kind is GEOSWEEP_POINT_KIND_HEIGHTS";
            return Err(Failure::argument(&field("dx"), reason));
        }
        let first = kind.floats();
        if given.slowness != 0 && given.slowness < first {
            let reason = format!(
                "is {}, but the first {first} floats of a point are its coordinates, height or metric",
                given.slowness
            );
            return Err(Failure::argument(&field("slowness"), reason));
        }
        let given_memory = [!given.buffer.is_null(), !given.view.is_null(), !given.data.is_null()];
        if given_memory.iter().filter(|&&is_there| is_there).count() != 1 {
            let reason = "must name exactly one of buffer, view and data";
            return Err(Failure::argument(name, reason));
        }
        if given.data.is_null() && !given.mask.is_null() {
            let reason = "is for points in data: in memory of the device, NaN makes a hole";
            return Err(Failure::argument(&field("mask"), reason));
        }
        let slowness = (given.slowness != 0).then_some(given.slowness);
        let on_device = |memory| Self::OnDevice(embed::Points { memory, kind, slowness });
        if !given.view.is_null() {
            let (view, layout) = (given.view, given.layout);
            if given.offset != 0 || given.stride != 0 {
                let reason = "or stride is not 0, and the points are the texels of view";
                return Err(Failure::argument(&field("offset"), reason));
            }
            if [vk::ImageLayout::UNDEFINED, vk::ImageLayout::PREINITIALIZED].contains(&layout) {
                let reason = format!("is {}, in which no image can be read", layout.as_raw());
                return Err(Failure::argument(&field("layout"), reason));
            }
            return Ok(on_device(embed::PointMemory::Image { view, layout }));
        }
        let GeosweepPoints { buffer, offset, stride, data, mask, .. } = *given;
        let needed = 4 * u64::from(first.max(given.slowness.saturating_add(1)));
        if !stride.is_multiple_of(4) || stride < needed {
            let reason =
                format!("is {stride}: it is a multiple of 4, and a point has {needed} bytes");
            return Err(Failure::argument(&field("stride"), reason));
        }
        if !offset.is_multiple_of(4) {
            let reason = format!("is {offset}, which is no multiple of 4");
            return Err(Failure::argument(&field("offset"), reason));
        }
        if !given.buffer.is_null() {
            return Ok(on_device(embed::PointMemory::Buffer { buffer, offset, stride }));
        }
        let floats = |bytes: u64| usize::try_from(bytes / 4).unwrap_or(usize::MAX);
        let (offset, stride) = (floats(offset), floats(stride));
        let slowness = slowness.map(|index| index as usize);
        Ok(Self::InProgram(Layout { kind, slowness, offset, stride }, Arrays { data, mask }))
    }
}

impl Layout {
    /// Reads and checks points. `prefix` comes before the arrays' names in messages.
    ///
    /// # Safety
    /// The pointers are null or point to arrays of the size that the layout requires.
    pub(super) unsafe fn read(
        &self,
        Arrays { data, mask }: Arrays,
        chart: Chart,
        edge_rule: EdgeRule,
        prefix: &str,
    ) -> Result<Surface, Failure> {
        let Chart { rows, cols } = chart;
        let (field, points) = (|field| format!("{prefix}{field}"), chart.points());
        let floats = (points - 1).checked_mul(self.stride);
        let floats = floats.and_then(|floats| floats.checked_add(self.offset + self.stride));
        let floats = floats.filter(|&floats| floats <= isize::MAX as usize / 4);
        if floats.is_none() {
            return Err(Failure::argument(&field("stride"), "is larger than memory"));
        }
        // SAFETY: the caller's promise. This checks for null and alignment, and looks at a single float,
        // since anything may lie between the others.
        unsafe { list(data, 1, 1, &field("data")) }?;
        // SAFETY: the index lies in the array, by the caller's promise.
        let float = |index: usize, at: usize| unsafe {
            f64::from(*data.add(self.offset + index * self.stride + at))
        };
        let three = |index| [0, 1, 2].map(|at| float(index, at));
        let surface = match self.kind {
            embed::PointKind::Positions => {
                let positions = (0..points).map(|index| DVec3::from_array(three(index)));
                Surface::from_positions(rows, cols, positions.collect())
            }
            embed::PointKind::Heights(spacing) => {
                let heights = (0..points).map(|index| float(index, 0));
                Surface::from_heights(rows, cols, heights.collect(), spacing)
            }
            embed::PointKind::Metric => {
                let too_large =
                    |index: &usize| three(*index).iter().any(|v| v.abs() > LONGEST_EDGE);
                if let Some(index) = (0..points).find(too_large) {
                    let (row, col) = chart.position(index);
                    let reason = format!("has an entry beyond 1e12 at row {row}, column {col}");
                    return Err(Failure::argument(&field("data"), reason));
                }
                let tensor = |index| {
                    let [rr, rc, cc] = three(index);
                    MetricTensor { rr, rc, cc }
                };
                Surface::from_metric(rows, cols, (0..points).map(tensor).collect())
            }
        };
        let mut surface = surface?.with_edge_rule(edge_rule);
        if !mask.is_null() {
            // SAFETY: the caller's promise.
            let mask = unsafe { std::slice::from_raw_parts(mask, points) };
            let mask: Vec<_> = mask.iter().map(|&keep| keep != 0).collect();
            surface = surface.with_mask(&mask)?;
        }
        if let Some(at) = self.slowness {
            surface = surface.with_slowness((0..points).map(|index| float(index, at)).collect())?;
        }
        surface.check_edges()?;
        Ok(surface)
    }

    /// Returns the number of floats of a point in this library's buffer. The slowness, if there is one, comes
    /// last.
    fn floats(&self) -> usize {
        self.kind.floats() as usize + usize::from(self.slowness.is_some())
    }

    /// Returns the parameters of this library's buffer for the points.
    pub(super) fn buffer(&self, chart: Chart) -> BufferInfo {
        let size = (4 * self.floats() * chart.points()) as u64;
        BufferInfo { name: "points", size, location: MemoryLocation::CpuToGpu }
    }
}

/// Points that were copied from the program's memory to a buffer of this library.
pub(super) struct Copied {
    pub(super) layout: Layout,
    buffer: Buffer,
}

impl Copied {
    pub(super) fn new(
        shared: &Shared,
        allocator: &mut dyn DeviceMemory,
        layout: Layout,
        surface: &Surface,
    ) -> Result<Self, Failure> {
        let buffer = Buffer::new(&shared.device, allocator, layout.buffer(surface.chart()))?;
        let mut new = Self { layout, buffer };
        new.write(surface);
        Ok(new)
    }

    /// Copies all points of the surface into the buffer. Holes become NaN.
    pub(super) fn write(&mut self, surface: &Surface) {
        let mapped = self.buffer.mapped();
        let (chart, bytes) = (surface.chart(), 4 * self.layout.floats());
        for (index, point) in mapped.chunks_exact_mut(bytes).take(chart.points()).enumerate() {
            let (row, col) = chart.position(index);
            if !surface.has(row, col) {
                // Holes are NaN, so that curves are never lifted to a stale value there.
                point.fill(0xFF);
                continue;
            }
            // Curves are lifted to these positions, so no origin is subtracted from them. The program's
            // numbers were in single precision, so the conversion does not change them.
            let floats = surface.point::<f32>(index, DVec3::ZERO);
            let floats = match surface.geometry() {
                Geometry::Heights { .. } => &floats[2..],
                Geometry::Positions(_) | Geometry::Metric(_) => &floats[..],
            };
            point.copy_from_slice(&cast_slice(floats)[..bytes]);
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffer.bytes()
    }

    /// Returns the points in the form that a surface's recordings read.
    pub(super) fn points(&self) -> embed::Points {
        let floats = self.layout.floats();
        let (buffer, stride) = (self.buffer.buffer, 4 * floats as u64);
        let memory = embed::PointMemory::Buffer { buffer, offset: 0, stride };
        let slowness = self.layout.slowness.map(|_| floats as u32 - 1);
        embed::Points { memory, kind: self.layout.kind, slowness }
    }

    pub(super) fn destroy(&mut self, shared: &Shared, allocator: &mut dyn DeviceMemory) {
        self.buffer.destroy(&shared.device, allocator);
    }
}
