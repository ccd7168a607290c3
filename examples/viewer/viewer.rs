//! The renderer: its parts, and the order of a frame's passes.

use std::time::{Duration, Instant};

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::glam::Vec2;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::vulkan::embed::Solver;
use geosweep::vulkan::{PipelineStore, Schedule};
use winit::window::Window;

use crate::Result;
use crate::agents::{self, Agents, WalkPasses};
use crate::draw::{self, Drawing};
use crate::frames::{self, Frame, Frames, IN_FLIGHT};
use crate::gpu::Gpu;
use crate::memory::Buffer;
use crate::options::Options;
use crate::pick::PickPass;
use crate::picture::Picture;
use crate::pipelines;
use crate::shaders::Layout;
use crate::shown::Shown;
use crate::stage::{PointPasses, Shared, Stage};
use crate::surfaces::{Model, Name};
use crate::swapchain::{Swapchain, Target};
use crate::timing::Timing;
use crate::view::{Driven, View};

/// Step of the time in the first frame, and in every frame if the number of frames is given.
const STEP: Duration = Duration::from_nanos(1_000_000_000 / 60);
/// Largest step of the time otherwise.
const LONGEST_STEP: Duration = Duration::from_millis(100);
/// Time to wait for an image of the window. Without one in this time, the window is not visible.
const PATIENCE: Duration = Duration::from_millis(200);

pub struct Viewer {
    options: Options,
    gpu: Gpu,
    layout: Layout,
    target: Target,
    /// Swapchain; `None` while the window has no size.
    swapchain: Option<Swapchain>,
    /// Whether the swapchain no longer fits the window.
    outdated: bool,
    frames: Frames,
    timing: Timing,
    point_passes: PointPasses,
    walk_passes: WalkPasses,
    picking: PickPass,
    drawing: Drawing,
    palette: Buffer,
    /// Views by frame in flight.
    views: Vec<Buffer>,
    solver: Solver,
    store: PipelineStore,
    /// Methods for which the solver has passes.
    methods: Vec<(Schedule, Wavefront)>,
    /// All surfaces, in the order in which they are shown.
    names: Vec<Name>,
    /// Stages of the first surfaces. Others follow when they are shown.
    stages: Vec<Stage>,
    current: usize,
    schedule: Schedule,
    wavefront: Wavefront,
    pointer: Vec2,
    /// Whether the source moves to the pointer.
    picks: bool,
    /// Whether a path starts at the pointer.
    traces: bool,
    shown: Shown,
    /// Whether a change has not been drawn yet.
    stale: bool,
    /// Time of the deformation, in seconds.
    phase: f32,
    last_frame: Option<Instant>,
    drawn: u64,
    picture: Option<Picture>,
}

impl Viewer {
    pub fn new(window: &Window, options: Options) -> Result<Self> {
        let model = options.model()?;
        let mut gpu = Gpu::new(window, options.device.as_deref(), options.validate)?;
        let layout = Layout::new(&gpu)?;
        let target = Target::new(&gpu)?;
        let frames = Frames::new(&gpu)?;
        let timing = Timing::new(&gpu)?;
        let point_passes = PointPasses::new(&gpu, &layout)?;
        let walk_passes = WalkPasses::new(&gpu, &layout)?;
        let picking = PickPass::new(&gpu, &layout)?;
        let drawing = Drawing::new(&gpu, &layout, &target)?;
        let palette = draw::palette();
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let palette = Buffer::filled(&mut gpu, "palette", bytemuck::cast_slice(&palette), storage)?;
        let views: Vec<_> = (0..IN_FLIGHT)
            .map(|_| {
                let bytes = size_of::<View>() as u64;
                let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
                Buffer::new(&mut gpu, "view", bytes, usage, MemoryLocation::CpuToGpu)
            })
            .collect::<Result<_>>()?;

        let (schedule, wavefront) = (Schedule::Raster, Wavefront::Curved);
        let passes = [(schedule, wavefront)];
        let (solver, store) = pipelines::solver(&gpu, &passes)?;
        let names = options.surface.all_from_here();
        let shown = Shown::new(&options);
        let mut viewer = Self {
            options,
            gpu,
            layout,
            target,
            swapchain: None,
            outdated: true,
            frames,
            timing,
            point_passes,
            walk_passes,
            picking,
            drawing,
            palette,
            views,
            solver,
            store,
            methods: passes.to_vec(),
            names,
            stages: Vec::new(),
            current: 0,
            schedule,
            wavefront,
            pointer: Vec2::ZERO,
            picks: false,
            traces: false,
            shown,
            stale: true,
            phase: 0.0,
            last_frame: None,
            drawn: 0,
            picture: None,
        };
        viewer.add_stage(&model)?;
        viewer.show()?;
        Ok(viewer)
    }

    /// Creates the stage of the next surface.
    fn add_stage(&mut self, model: &Model) -> Result<()> {
        let Self { gpu, layout, solver, picking, views, stages, frames, .. } = self;
        let palette = self.palette.handle;
        let shared = Shared { layout, solver, picking, palette, views };
        let stage = Stage::new(gpu, model, &shared)?;
        gpu.wait();
        frames.now(gpu, |commands| {
            stage.prepare(gpu, solver, commands);
            Ok(())
        })?;
        stages.push(stage);
        Ok(())
    }

    /// Returns whether a frame would show something new.
    pub fn wants_frame(&self) -> bool {
        let stage = &self.stages[self.current];
        let counts = self.options.frames.is_some();
        let walks = stage.agents.as_ref().is_some_and(Agents::are_shown);
        let moves = stage.look.deforms || walks;
        self.stale || self.outdated || counts || moves || stage.map.is_due()
    }

    /// Returns whether all requested frames have been drawn.
    pub fn is_done(&self) -> bool {
        self.options.frames.is_some_and(|frames| self.drawn >= frames)
    }

    /// Notes that the window has another size.
    pub fn resized(&mut self) {
        self.outdated = true;
    }

    /// Notes that the window must be drawn again.
    pub fn exposed(&mut self) {
        self.stale = true;
    }

    /// Moves the source to the pointer.
    pub fn pick(&mut self, pointer: Vec2) {
        (self.pointer, self.picks, self.stale) = (pointer, true, true);
    }

    /// Draws the path from under the pointer to the source. On a closed surface there is none.
    pub fn trace(&mut self, pointer: Vec2) -> Result<()> {
        if self.stages[self.current].is_closed() {
            self.shown.lacks_path = true;
            self.stale = true;
            return Ok(());
        }
        (self.pointer, self.traces, self.stale) = (pointer, true, true);
        let Stage { lines, map, .. } = &mut self.stages[self.current];
        lines.show_path(&mut self.gpu, &self.solver, map.surface())
    }

    /// Changes what is shown.
    pub fn change(&mut self, change: impl FnOnce(&mut Shown)) -> Result<()> {
        change(&mut self.shown);
        self.show()
    }

    fn show(&mut self) -> Result<()> {
        self.stale = true;
        self.stages[self.current].show(&mut self.gpu, &self.solver, &self.shown)
    }

    pub fn orbit(&mut self, by: Vec2) {
        self.stages[self.current].camera.orbit(by);
        self.stale = true;
    }

    pub fn zoom(&mut self, by: f32) {
        let Stage { camera, look, .. } = &mut self.stages[self.current];
        camera.zoom(by, look.camera.distance);
        self.stale = true;
    }

    pub fn next_surface(&mut self) -> Result<()> {
        self.current = (self.current + 1) % self.names.len();
        if self.current == self.stages.len() {
            let model = self.names[self.current].load()?;
            self.add_stage(&model)?;
        }
        self.shown.lacks_path = false;
        self.show()?;
        self.use_method(self.schedule, self.wavefront)
    }

    pub fn next_schedule(&mut self) -> Result<()> {
        self.use_method(after(&Schedule::ALL, self.schedule), self.wavefront)
    }

    pub fn next_wavefront(&mut self) -> Result<()> {
        self.use_method(self.schedule, after(&Wavefront::FOR_ANY_SURFACE, self.wavefront))
    }

    /// Uses a method on the current surface. Creates the method's pipelines when it is first used.
    fn use_method(&mut self, schedule: Schedule, wavefront: Wavefront) -> Result<()> {
        let Self { gpu, solver, stages, frames, .. } = self;
        (self.schedule, self.wavefront) = (schedule, wavefront);
        let method = (schedule, wavefront);
        if !self.methods.contains(&method) {
            gpu.wait();
            solver.add_passes(&gpu.device, schedule, wavefront)?;
            frames.now(gpu, |commands| {
                stages.iter().for_each(|stage| stage.map.prepare(gpu, solver, commands));
                Ok(())
            })?;
            // The images of all maps are then as new, so the maps must be measured again.
            stages.iter_mut().for_each(|stage| stage.map.moved_points());
            self.methods.push(method);
        }
        self.timing.forget();
        self.stages[self.current].map.use_method(&self.solver, schedule, wavefront)
    }

    /// Returns the title of the window.
    pub fn title(&self) -> String {
        let stage = &self.stages[self.current];
        let Stage { look, map, .. } = stage;
        let (rows, cols) = (look.chart.rows, look.chart.cols);
        let mut title = format!(
            "geosweep: {}, {rows} x {cols} points, {}, {} fronts",
            look.name, self.schedule, self.wavefront
        );
        title += &self.shown.title(stage.is_closed());
        if let Some(milliseconds) = self.timing.milliseconds() {
            title += &format!(", {milliseconds:.2} ms on {}", self.gpu.device_name());
        }
        if let Some(outcome) = map.outcome() {
            let unit = if self.schedule == Schedule::Tiles { "round" } else { "iteration" };
            let plural = if outcome.iterations == 1 { "" } else { "s" };
            title += &format!(", {} {unit}{plural}", outcome.iterations);
        }
        title
    }

    /// Draws a frame, if the window can be drawn. Never waits for the previous frame.
    pub fn frame(&mut self, window: [u32; 2]) -> Result<()> {
        if self.outdated && !self.rebuild(window)? {
            return Ok(());
        }
        let Some(swapchain) = &self.swapchain else { return Ok(()) };
        let frame = self.frames.wait(&self.gpu)?;
        self.timing.collect(&self.gpu, frame)?;
        for stage in &mut self.stages {
            stage.map.collect(frame)?;
        }
        // SAFETY: the submission whose fence was waited for has waited for the semaphore.
        let acquired = unsafe {
            let (patience, none) = (PATIENCE.as_nanos() as u64, vk::Fence::null());
            let semaphore = frame.acquired;
            self.gpu.swapchains.acquire_next_image(swapchain.handle, patience, semaphore, none)
        };
        let index = match acquired {
            Ok((index, suboptimal)) => {
                self.outdated |= suboptimal;
                index
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.outdated = true;
                return Ok(());
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(()),
            Err(error) => return Err(error.into()),
        };
        let drawn = swapchain.images[index as usize].drawn;
        frames::begin(&self.gpu, frame.commands)?;
        self.record(frame, index as usize)?;
        // SAFETY: the commands have been recorded.
        unsafe { self.gpu.device.end_command_buffer(frame.commands)? };
        self.frames.submit(&self.gpu, drawn)?;
        self.present(index, drawn)?;
        self.drawn += 1;
        self.stale = false;
        Ok(())
    }

    /// Creates the swapchain again. Returns whether there is an image to draw into.
    fn rebuild(&mut self, window: [u32; 2]) -> Result<bool> {
        self.gpu.wait();
        let old = self.swapchain.take();
        self.swapchain = Swapchain::new(&mut self.gpu, &self.target, window, old)?;
        self.outdated = self.swapchain.is_none();
        self.stale = true;
        Ok(!self.outdated)
    }

    fn present(&mut self, index: u32, drawn: vk::Semaphore) -> Result<()> {
        let Some(swapchain) = &self.swapchain else { return Ok(()) };
        let (swapchains, indices, semaphores) = ([swapchain.handle], [index], [drawn]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&semaphores)
            .swapchains(&swapchains)
            .image_indices(&indices);
        // SAFETY: the image has been acquired, and the commands that draw it have been submitted.
        match unsafe { self.gpu.swapchains.queue_present(self.gpu.queue, &info) } {
            Ok(suboptimal) => self.outdated |= suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.outdated = true,
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    /// Records all passes of a frame.
    fn record(&mut self, frame: Frame, image: usize) -> Result<()> {
        let pace = agents::PACE * self.step().as_secs_f32();
        let last = self.options.frames.is_some_and(|frames| self.drawn + 1 == frames);
        let Self { gpu, layout, timing, solver, .. } = self;
        let Some(swapchain) = &self.swapchain else { return Ok(()) };
        let stage = &mut self.stages[self.current];
        let (commands, number) = (frame.commands, frame.index);
        let size = Vec2::new(swapchain.size.width as f32, swapchain.size.height as f32);
        let spacing = stage.look.spacing;
        let driven = Driven {
            pointer: self.pointer,
            phase: self.phase,
            spacing: if self.shown.contours { -spacing } else { spacing },
            decal: stage.decal.look.radius * spacing,
            pace: pace * spacing,
        };
        let view = View::new(&stage.camera, &stage.look, size, &driven);
        self.views[number].bytes_mut()[..size_of::<View>()]
            .copy_from_slice(bytemuck::bytes_of(&view));

        stage.record_points(gpu, &self.point_passes, layout, commands, number);
        if std::mem::take(&mut self.picks) {
            self.picking.record(gpu, layout, (stage, &stage.pick), commands, number);
            stage.map.moved_source();
        }
        if std::mem::take(&mut self.traces) {
            self.picking.record(gpu, layout, (stage, &stage.lines.start), commands, number);
        }
        let changed = stage.map.records();
        if changed {
            timing.start(gpu, frame);
            stage.map.record(gpu, solver, frame)?;
            timing.stop(gpu, frame);
        }
        stage.record_outputs(gpu, solver, commands, changed)?;
        stage.record_agents(gpu, solver, (&self.walk_passes, layout), frame, changed)?;

        let far = vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 };
        let clear = [vk::ClearValue::default(), vk::ClearValue { depth_stencil: far }];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.target.pass)
            .framebuffer(swapchain.images[image].framebuffer)
            .render_area(swapchain.size.into())
            .clear_values(&clear);
        let viewport =
            vk::Viewport { width: size.x, height: size.y, max_depth: 1.0, ..Default::default() };
        // SAFETY: the commands are being recorded. All objects are alive.
        unsafe {
            let device = &gpu.device;
            device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
            device.cmd_set_scissor(commands, 0, &[swapchain.size.into()]);
            self.drawing.record(gpu, layout, stage, (commands, number), viewport);
            device.cmd_end_render_pass(commands);
        }
        if last && self.options.picture.is_some() {
            let (image, format) = (swapchain.images[image].handle, self.target.format.format);
            self.picture = Some(Picture::record(gpu, commands, swapchain, image, format)?);
        }
        Ok(())
    }

    /// Advances the time, and returns the step. All steps are the same if the number of frames is given, so that
    /// runs are alike.
    fn step(&mut self) -> Duration {
        let now = Instant::now();
        let last = self.last_frame.replace(now);
        let step = match self.options.frames {
            Some(_) => STEP,
            None => last.map_or(STEP, |last| now - last).min(LONGEST_STEP),
        };
        if self.stages[self.current].look.deforms {
            self.phase += step.as_secs_f32();
        }
        step
    }

    /// Writes the picture, if one was requested, and destroys everything.
    pub fn end(mut self) -> Result<()> {
        self.gpu.wait();
        let gpu = &mut self.gpu;
        let written = match (&mut self.picture, &self.options.picture) {
            (Some(picture), Some(file)) => {
                let written = picture.write(file);
                picture.destroy(gpu);
                written
            }
            (None, Some(_)) => Err("the window was closed before the last frame".into()),
            _ => Ok(()),
        };
        for stage in &mut self.stages {
            stage.destroy(gpu);
        }
        self.views.iter_mut().for_each(|view| view.destroy(gpu));
        self.palette.destroy(gpu);
        if let Some(swapchain) = &mut self.swapchain {
            swapchain.destroy(gpu);
        }
        self.drawing.destroy(gpu);
        self.picking.destroy(gpu);
        self.point_passes.destroy(gpu);
        self.walk_passes.destroy(gpu);
        self.timing.destroy(gpu);
        self.frames.destroy(gpu);
        self.target.destroy(gpu);
        self.layout.destroy(gpu);
        self.solver.destroy(&gpu.device);
        // Without the file, the next start takes longer.
        let _ = self.store.save(&gpu.device);
        self.store.destroy(&gpu.device);
        written.and(self.gpu.destroy())
    }
}

/// Returns the entry after another, cyclically.
fn after<T: Copy + PartialEq>(all: &[T], one: T) -> T {
    let place = all.iter().position(|&other| other == one).unwrap_or(0);
    all[(place + 1) % all.len()]
}
