//! Compilation of a shader. The text of this file, names.rs and variants.rs is part of the fingerprint of the
//! committed SPIR-V.
#![cfg(feature = "shaderc")]

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};

use super::names;

/// First lines of every shader: the version of the language, its extensions, and the chart with the constants.
const PRELUDE: &str = "\
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle_relative : require
#include \"shared/chart.glsl\"
#line 1
";

/// Returns the SPIR-V of a shader named `name`, whose includes lie in the folder `includes`. It is compiled with
/// the macro of the given name and value, if there is one.
pub fn spirv(
    text: &str,
    name: &str,
    includes: &str,
    definition: Option<(&str, String)>,
) -> Vec<u8> {
    // A file is included once, however many others include it. So each file can include what it needs.
    let included = RefCell::new(BTreeSet::new());
    let compiler = Compiler::new().expect("glslang starts");
    let mut options = CompileOptions::new().expect("glslang starts");
    // Vulkan 1.1 is the oldest version that the engine runs on.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_1 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    // Without debug information the optimizer removes all names.
    options.set_generate_debug_info();
    if let Some((macro_name, value)) = definition {
        options.add_macro_definition(macro_name, Some(&value));
    }
    options.set_include_callback(|name, _, _, _| {
        let resolved_name = format!("{includes}/{name}");
        if !included.borrow_mut().insert(resolved_name.clone()) {
            return Ok(shaderc::ResolvedInclude { resolved_name, content: String::new() });
        }
        let content = fs::read_to_string(&resolved_name)
            .map_err(|error| format!("cannot read {resolved_name}: {error}"))?;
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    let artifact = compiler
        .compile_into_spirv(
            &format!("{PRELUDE}{text}"),
            ShaderKind::Compute,
            name,
            "main",
            Some(&options),
        )
        .unwrap_or_else(|error| panic!("{error}"));
    names::keep_those_of_interfaces(artifact.as_binary())
}
