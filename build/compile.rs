//! How a shader is compiled. What stands here and in names.rs is part of the fingerprint of the committed
//! SPIR-V.
#![cfg(feature = "shaderc")]

use std::fs;

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};

use crate::names;

/// The SPIR-V of a shader named `name`, whose includes lie in the folder `includes`.
pub fn spirv(text: &str, name: &str, includes: &str) -> Vec<u8> {
    let compiler = Compiler::new().expect("glslang starts");
    let mut options = CompileOptions::new().expect("glslang starts");
    // Vulkan 1.1 is the oldest version that the engine runs on.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_1 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    // Without it the optimizer takes all names out.
    options.set_generate_debug_info();
    options.set_include_callback(|name, _, _, _| {
        let resolved_name = format!("{includes}/{name}");
        let content = fs::read_to_string(&resolved_name)
            .map_err(|error| format!("cannot read {resolved_name}: {error}"))?;
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    let artifact = compiler
        .compile_into_spirv(text, ShaderKind::Compute, name, "main", Some(&options))
        .unwrap_or_else(|error| panic!("{error}"));
    names::keep_those_of_interfaces(artifact.as_binary())
}
