//! Generates the Vulkan engine's parts that come from glsl/ (`build/shaders.rs`).

#[cfg(feature = "vulkan")]
#[path = "build/shaders.rs"]
mod shaders;

fn main() {
    #[cfg(feature = "vulkan")]
    shaders::build();
}
