//! A host with a solver and a surface of ours, and what tests do with them.

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, Frame, PointSource, Reader, ResultImage, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};

use crate::host::{Host, HostBuffer};

pub const STOP: Stop = Stop { tolerance: 1e-6, iterations: 400 };

/// All wavefronts by raster scans.
pub const RASTER: [(Schedule, Wavefront); 3] = [
    (Schedule::Raster, Wavefront::Planar),
    (Schedule::Raster, Wavefront::PointSource),
    (Schedule::Raster, Wavefront::Curved),
];

/// A prepared surface. [`Stage::end`] takes it down.
pub struct Stage {
    pub host: Host,
    pub solver: embed::Solver,
    pub surface: embed::Surface,
    download: HostBuffer,
}

impl Stage {
    pub fn new(mut host: Host, passes: &[(Schedule, Wavefront)], info: &SurfaceInfo) -> Self {
        let solver =
            embed::Solver::new(&host.instance, host.physical_device, &host.device, passes).unwrap();
        let device = host.device.clone();
        let surface = solver.surface(&device, host.allocator(), info).unwrap();
        let download = host.buffer(4 * info.chart.points() as u64, true);
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { host, solver, surface, download }
    }

    pub fn plan(&self, schedule: Schedule, wavefront: Wavefront, iterations: u32) -> embed::Plan {
        let method = Method { wavefront, schedule: Some(schedule), stop: STOP };
        self.solver.plan(self.surface.chart(), method, iterations).unwrap()
    }

    /// Runs a frame, then as many recordings more as it takes to converge.
    pub fn map(&self, points: usize, sources: SourceInput, plan: &embed::Plan) -> Vec<f32> {
        self.run(|recording| {
            recording.frame(&Frame {
                before: Access::NONE,
                points: Some(points),
                sources,
                plan,
                slot: 0,
                reader: Reader::COPY,
                unreached: f32::INFINITY,
            })
        });
        self.finish(plan);
        self.read()
    }

    /// Resumes the plan until it has converged.
    pub fn finish(&self, plan: &embed::Plan) {
        while !self.surface.outcome(0).unwrap().converged {
            let before = self.surface.outcome(0).unwrap();
            self.run(|recording| {
                recording.begin(Access::NONE);
                recording.resume(plan).unwrap();
                recording.outcome(0).unwrap();
                recording.result(0, Reader::COPY, f32::INFINITY)
            });
            let after = self.surface.outcome(0).unwrap();
            assert!(after.iterations > before.iterations, "{before:?} {after:?}");
        }
    }

    /// Records, submits, waits, and copies the image of distances.
    pub fn run(
        &self,
        record: impl FnOnce(embed::Recording) -> Result<ResultImage, geosweep::vulkan::VulkanError>,
    ) {
        let device = &self.host.device;
        self.host.run(|commands| {
            let image = record(self.solver.record(device, commands, &self.surface)).unwrap();
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .layer_count(1);
            let copy = vk::BufferImageCopy::default()
                .image_subresource(layers)
                .image_extent(image.extent.into());
            unsafe {
                let to = self.download.handle;
                device.cmd_copy_image_to_buffer(commands, image.image, image.layout, to, &[copy]);
            }
            self.host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
        });
    }

    /// The distances that [`Stage::run`] has copied.
    pub fn read(&self) -> Vec<f32> {
        self.download.floats()[..self.surface.chart().points()].to_vec()
    }

    /// Destroys everything; nothing is left in the allocator, and the validation layers have said
    /// nothing.
    pub fn end(self, buffers: impl IntoIterator<Item = HostBuffer>) {
        assert_eq!(self.host.messages(), Vec::<String>::new());
        assert_eq!(self.take_down(buffers), Vec::<String>::new());
    }

    /// Destroys everything; nothing is left in the allocator. What the validation layers have said.
    pub fn take_down(self, buffers: impl IntoIterator<Item = HostBuffer>) -> Vec<String> {
        let Self { mut host, mut solver, mut surface, download } = self;
        let device = host.device.clone();
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
        host.free(download);
        buffers.into_iter().for_each(|buffer| host.free(buffer));
        assert_eq!(host.allocations(), 0);
        host.messages()
    }
}

/// A point source.
pub fn source(row: f32, col: f32) -> [PointSource; 1] {
    [PointSource::at(row, col)]
}

/// Positions of a wavy surface, eight floats a point like vertices that hold more than a position.
pub fn vertices(chart: Chart, phase: f32) -> Vec<f32> {
    (0..chart.points())
        .flat_map(|index| {
            let (row, col) = chart.position(index);
            let (x, y) = (col as f32, 1.2 * row as f32);
            let z = 2.0 * (0.3 * x + phase).sin() * (0.2 * y).cos();
            [x, y, z, 0.5, 0.5, 0.0, 0.0, 1.0]
        })
        .collect()
}
