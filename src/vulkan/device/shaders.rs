//! Contains the shaders with their interfaces, which the build reads from the SPIR-V. Each shader has a
//! module with its bindings, its specialization constants, and its blocks as structures. A Rust side that
//! does not match a shader does not compile.

#![allow(dead_code, reason = "the build writes all that shaders have, and not all is for Rust")]

use ash::vk;

use crate::update::Wavefront;

/// Compiled shader with its interface.
#[derive(Debug)]
pub(crate) struct Shader {
    /// Name of the shader's file in glsl/.
    pub(crate) name: &'static str,
    /// SPIR-V for each wavefront, or one module for all.
    pub(crate) modules: &'static [&'static [u8]],
    /// Set and number of each descriptor that the shader uses.
    pub(crate) bindings: &'static [(u32, u32)],
    /// Whether the shader uses the set of the host's own images and buffers. It then uses no set of maps.
    pub(crate) sees_host: bool,
    /// Specialization constants, by their numbers.
    pub(crate) constants: &'static [(u32, Constant)],
    pub(crate) push_constant_bytes: u32,
}

impl Shader {
    /// Returns the SPIR-V from which pipelines for a wavefront are made.
    pub(crate) fn spirv(&self, wavefront: Wavefront) -> &'static [u8] {
        match self.modules {
            [all] => all,
            modules => modules[wavefront as usize],
        }
    }

    /// Returns whether another shader has equal numbers of bindings, specialization constants and pushed bytes.
    pub(crate) const fn is_like(&self, other: &Self) -> bool {
        self.bindings.len() == other.bindings.len()
            && self.sees_host == other.sees_host
            && self.constants.len() == other.constants.len()
            && self.push_constant_bytes == other.push_constant_bytes
    }

    /// Returns whether a constant specializes the shader.
    pub(crate) const fn depends_on(&self, wanted: Constant) -> bool {
        let mut place = 0;
        while place < self.constants.len() {
            if self.constants[place].1 as u32 == wanted as u32 {
                return true;
            }
            place += 1;
        }
        false
    }
}

/// Returns the number of descriptors of a kind among `kinds`.
pub(crate) const fn count_of(kind: vk::DescriptorType, kinds: &[vk::DescriptorType]) -> u32 {
    let (mut count, mut place) = (0, 0);
    while place < kinds.len() {
        if kinds[place].as_raw() == kind.as_raw() {
            count += 1;
        }
        place += 1;
    }
    count
}

const STORAGE_BUFFER: vk::DescriptorType = vk::DescriptorType::STORAGE_BUFFER;
const STORAGE_IMAGE: vk::DescriptorType = vk::DescriptorType::STORAGE_IMAGE;
const SAMPLED_IMAGE: vk::DescriptorType = vk::DescriptorType::SAMPLED_IMAGE;

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
