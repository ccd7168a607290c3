//! A cloth in a storage buffer. A compute pass moves it, and a render pass draws it in the colours of its
//! map.

use geosweep_wgpu::geosweep::surface::Chart;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Rows and columns of vertices.
pub const CHART: Chart = Chart { rows: 60, cols: 72 };
/// Bytes from one vertex to the next: a position and an unused word.
pub const STRIDE: u64 = 16;
/// Width and height of the picture.
pub const PICTURE: [u32; 2] = [960, 640];
/// Format of the picture.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

const MOVE: &str = "
    @group(0) @binding(0) var<uniform> time: vec4<f32>;
    @group(0) @binding(1) var<storage, read_write> points: array<vec4<f32>>;

    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= 60u * 72u) { return; }
        let x = f32(id.x % 72u) - 35.5;
        let y = f32(id.x / 72u) - 29.5;
        let wave = sin(0.21 * x + time.x) * cos(0.17 * y - 0.7 * time.x);
        points[id.x] = vec4<f32>(x, y, 4.0 * wave + 0.008 * (x * x - y * y), 0.0);
    }";

const DRAW: &str = "
    @group(0) @binding(0) var<storage, read> points: array<vec4<f32>>;
    @group(0) @binding(1) var distances: texture_2d<f32>;

    struct Varying { @builtin(position) clip: vec4<f32>, @location(0) place: vec2<f32> }

    @vertex
    fn vertex(@builtin(vertex_index) index: u32) -> Varying {
        var corners = array<vec2<u32>, 6>(vec2<u32>(0u, 0u), vec2<u32>(1u, 0u), vec2<u32>(0u, 1u),
                                          vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), vec2<u32>(1u, 1u));
        let cell = index / 6u;
        let at = vec2<u32>(cell % 71u, cell / 71u) + corners[index % 6u];
        let p = points[at.y * 72u + at.x].xyz;
        // Seen from above, at a slant.
        let clip = vec4<f32>(p.x / 44.0, (-0.8 * p.y + 0.6 * p.z) / 32.0,
                             0.5 - (0.6 * p.y + 0.8 * p.z) / 100.0, 1.0);
        return Varying(clip, vec2<f32>(at));
    }

    // The format need not be filterable.
    fn distance_at(place: vec2<f32>) -> f32 {
        let low = clamp(vec2<i32>(place), vec2<i32>(0), vec2<i32>(70, 58));
        let part = place - vec2<f32>(low);
        let a = textureLoad(distances, low, 0).r;
        let b = textureLoad(distances, low + vec2<i32>(1, 0), 0).r;
        let c = textureLoad(distances, low + vec2<i32>(0, 1), 0).r;
        let d = textureLoad(distances, low + vec2<i32>(1, 1), 0).r;
        return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
    }

    @fragment
    fn fragment(in: Varying) -> @location(0) vec4<f32> {
        let d = distance_at(in.place);
        let near = vec3<f32>(1.0, 0.93, 0.72);
        let far = vec3<f32>(0.30, 0.12, 0.42);
        let band = select(0.82, 1.0, fract(d / 8.0) < 0.5);
        return vec4<f32>(band * mix(near, far, clamp(d / 60.0, 0.0, 1.0)), 1.0);
    }";

/// The cloth, and the passes that move and draw it.
pub struct Cloth {
    /// Positions, row by row.
    pub vertices: wgpu::Buffer,
    time: wgpu::Buffer,
    moving: (wgpu::ComputePipeline, wgpu::BindGroup),
    drawing: wgpu::RenderPipeline,
    depths: wgpu::TextureView,
}

impl Cloth {
    /// Creates buffers and pipelines.
    pub fn new(device: &wgpu::Device) -> Self {
        let vertices = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vertices"),
            size: STRIDE * CHART.points() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let time = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("time"),
            contents: bytemuck::bytes_of(&[0f32; 4]),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let module = shader(device, MOVE);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("move"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let resources = [time.as_entire_binding(), vertices.as_entire_binding()];
        let group = bind_group(device, &pipeline.get_bind_group_layout(0), resources);
        let depth = wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        };
        let drawing = render_pipeline(device, DRAW, PICTURE_FORMAT, Some(depth));
        let depths = target(device, wgpu::TextureFormat::Depth32Float, PICTURE);
        let depths = depths.create_view(&Default::default());
        Self { vertices, time, moving: (pipeline, group), drawing, depths }
    }

    /// Moves the cloth to its position at a time.
    pub fn move_to(&self, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, time: f32) {
        queue.write_buffer(&self.time, 0, bytemuck::bytes_of(&[time, 0.0, 0.0, 0.0]));
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.moving.0);
        pass.set_bind_group(0, &self.moving.1, &[]);
        pass.dispatch_workgroups((CHART.points() as u32).div_ceil(64), 1, 1);
    }

    /// Returns the bindings for drawing the cloth with an image of distances.
    pub fn colours(&self, device: &wgpu::Device, distances: &wgpu::Texture) -> wgpu::BindGroup {
        let view = distances.create_view(&Default::default());
        let resources =
            [self.vertices.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
        bind_group(device, &self.drawing.get_bind_group_layout(0), resources)
    }

    /// Draws the cloth.
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        colours: &wgpu::BindGroup,
        picture: &wgpu::TextureView,
    ) {
        let clear = wgpu::Color { r: 0.93, g: 0.92, b: 0.90, a: 1.0 };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment(picture, clear))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depths,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.drawing);
        pass.set_bind_group(0, colours, &[]);
        let cells = (CHART.rows - 1) * (CHART.cols - 1);
        pass.draw(0..6 * cells as u32, 0..1);
    }
}

/// Creates a pipeline of a `vertex` and a `fragment` shader.
pub fn render_pipeline(
    device: &wgpu::Device,
    source: &str,
    format: wgpu::TextureFormat,
    depth_stencil: Option<wgpu::DepthStencilState>,
) -> wgpu::RenderPipeline {
    let module = shader(device, source);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Creates a texture for rendering. If it has colours, it can be copied from.
pub fn target(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    [width, height]: [u32; 2],
) -> wgpu::Texture {
    let mut usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    usage.set(wgpu::TextureUsages::COPY_SRC, !format.is_depth_stencil_format());
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Returns an attachment for a target that is cleared.
pub fn attachment(
    view: &wgpu::TextureView,
    clear: wgpu::Color,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
    }
}

/// Binds the resources as bindings 0, 1 and so on.
pub fn bind_group<const COUNT: usize>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource<'_>; COUNT],
) -> wgpu::BindGroup {
    let mut binding = 0..;
    let entries = resources.map(|resource| wgpu::BindGroupEntry {
        binding: binding.next().expect("numbers do not run out"),
        resource,
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

fn shader(device: &wgpu::Device, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}
