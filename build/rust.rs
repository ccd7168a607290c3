//! Writes the interfaces of all shaders as Rust.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::interface::{Block, Interface, Kind};

/// A shader, with the names of its SPIR-V modules and the interface of all of them.
pub struct Shader {
    pub name: String,
    pub modules: Vec<String>,
    pub interface: Interface,
}

/// Returns a module for each set of descriptors with its bindings, an enumeration of all specialization
/// constants, and a module for each shader with its blocks.
pub fn shaders(shaders: &[Shader]) -> String {
    let mut rust = String::new();
    sets(shaders, &mut rust);
    constants(shaders, &mut rust);
    let mut blocks = Vec::new();
    for of in shaders {
        shader(of, &mut blocks, &mut rust);
    }
    rust
}

/// Writes the sets. Asserts that shaders agree on the type of each descriptor, and that each name has one
/// place.
fn sets(shaders: &[Shader], rust: &mut String) {
    let mut kinds = BTreeMap::<(u32, u32), Kind>::new();
    let mut places = BTreeMap::<(u32, &str), u32>::new();
    for Shader { name: shader, interface, .. } in shaders {
        for binding in &interface.bindings {
            let (set, number, name) = (binding.set, binding.number, binding.name.as_str());
            let kind = *kinds.entry((set, number)).or_insert(binding.kind);
            assert!(
                kind == binding.kind,
                "{shader}.comp: {name}, binding {number} of set {set}, is a {:?}, and elsewhere a {kind:?}",
                binding.kind
            );
            let place = *places.entry((set, name)).or_insert(number);
            assert!(
                place == number,
                "{shader}.comp: {name} is binding {number} of set {set}, and elsewhere binding {place}: \
                 what shaders share has one name"
            );
        }
    }
    let last = kinds.keys().map(|(set, _)| *set).max().unwrap_or(0);
    for set in 0..=last {
        writeln!(rust, "pub(crate) mod set_{set} {{").unwrap();
        let of_set = kinds.iter().filter(|((of, _), _)| *of == set);
        let list: Vec<_> = of_set.map(|((_, number), kind)| (*number, *kind)).collect();
        assert!(
            list.iter().map(|(number, _)| *number).eq(0..list.len() as u32),
            "set {set} has gaps: {list:?}"
        );
        let kinds: Vec<_> =
            list.iter().map(|(_, kind)| format!("super::{}", kind_name(*kind))).collect();
        writeln!(
            rust,
            "pub(crate) const KINDS: [ash::vk::DescriptorType; {}] = [{}];",
            kinds.len(),
            kinds.join(", ")
        )
        .unwrap();
        for ((_, name), number) in places.iter().filter(|((of, _), _)| *of == set) {
            let name = constant_case(name);
            writeln!(rust, "pub(crate) const {name}: u32 = {number};").unwrap();
        }
        rust.push_str("}\n");
    }
}

fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::StorageBuffer => "STORAGE_BUFFER",
        Kind::StorageImage => "STORAGE_IMAGE",
        Kind::SampledImage => "SAMPLED_IMAGE",
    }
}

fn constants(shaders: &[Shader], rust: &mut String) {
    let all = shaders.iter().flat_map(|shader| &shader.interface.constants);
    let mut names: Vec<_> = all.map(|(_, name)| camel_case(name)).collect();
    names.sort();
    names.dedup();
    let names = names.join(", ");
    writeln!(
        rust,
        "/// The specialization constants of all shaders.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub(crate) enum Constant {{ {names} }}"
    )
    .unwrap();
}

/// Writes a shader's module in Rust. `blocks` are the blocks of earlier shaders; equal blocks are not written again.
fn shader<'a>(
    Shader { name, modules, interface }: &'a Shader,
    blocks: &mut Vec<(&'a str, String, &'a Block)>,
    rust: &mut String,
) {
    writeln!(rust, "pub(crate) mod {name} {{").unwrap();
    let bindings: Vec<_> = interface
        .bindings
        .iter()
        .map(|binding| format!("({}, {})", binding.set, binding.number))
        .collect();
    let constants: Vec<_> = interface
        .constants
        .iter()
        .map(|(number, name)| format!("({number}, super::Constant::{})", camel_case(name)))
        .collect();
    let modules: Vec<_> = modules
        .iter()
        .map(|module| format!("include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{module}.spv\"))"))
        .collect();
    let sees_host = interface.bindings.iter().any(|binding| binding.set == 1);
    let size = interface.push_constants.as_ref().map_or(0, |block| block.size);
    writeln!(
        rust,
        "pub(crate) const SHADER: super::Shader = super::Shader {{\n\
         name: \"{name}\",\n\
         modules: &[{}],\n\
         bindings: &[{}],\n\
         sees_host: {sees_host},\n\
         constants: &[{}],\n\
         push_constant_bytes: {size},\n}};",
        modules.join(", "),
        bindings.join(", "),
        constants.join(", ")
    )
    .unwrap();
    match &interface.push_constants {
        None => rust.push_str("pub(crate) type Push = [u32; 0];\n"),
        Some(push) => structure("Push", name, push, blocks, rust),
    }
    for block in &interface.buffers {
        structure(&block.name, name, block, blocks, rust);
    }
    rust.push_str("}\n");
}

/// Writes a block as a structure, or as an alias of an existing one.
fn structure<'a>(
    name: &str,
    shader: &'a str,
    block: &'a Block,
    blocks: &mut Vec<(&'a str, String, &'a Block)>,
    rust: &mut String,
) {
    if let Some((module, _, _)) = blocks.iter().find(|(_, of, other)| of == name && *other == block)
    {
        writeln!(rust, "pub(crate) type {name} = super::{module}::{name};").unwrap();
        return;
    }
    blocks.push((shader, name.to_owned(), block));
    writeln!(
        rust,
        "/// `{}` in glsl/{shader}.comp or what it includes.\n\
         #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[repr(C)]\n\
         pub(crate) struct {name} {{",
        block.name
    )
    .unwrap();
    let mut end = 0;
    for member in &block.members {
        // Where GLSL aligns a member, the shader must declare the padding before it.
        assert!(
            member.offset == end,
            "{shader}.comp: {}.{} starts at byte {}, and what is before it ends at {end}",
            block.name,
            member.name,
            member.offset
        );
        writeln!(rust, "pub(crate) {}: {},", member.name, member.kind).unwrap();
        end += member.size;
    }
    rust.push_str("}\n");
    for member in &block.members {
        writeln!(
            rust,
            "const _: () = assert!(core::mem::offset_of!({name}, {}) == {});",
            member.name, member.offset
        )
        .unwrap();
    }
}

/// Converts a name in snake_case or CamelCase to the case of Rust constants.
fn constant_case(name: &str) -> String {
    let mut constant = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !constant.is_empty() {
            constant.push('_');
        }
        constant.push(letter.to_ascii_uppercase());
    }
    constant
}

fn camel_case(name: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        first
            .into_iter()
            .chain(letters.map(|letter| letter.to_ascii_lowercase()))
            .collect::<String>()
    };
    name.split('_').map(word).collect()
}
