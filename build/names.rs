//! Selection of the names that a module keeps.
#![cfg(feature = "shaderc")]

use rspirv::spirv::Op;

/// Returns a module without what the compiler adds for debuggers, but with the names of interfaces: those of
/// structures, members, global variables and specialization constants, which stand before the first function.
pub fn keep_those_of_interfaces(words: &[u32]) -> Vec<u8> {
    const HEADER: usize = 5;
    let mut instructions = Vec::new();
    let mut rest = &words[HEADER..];
    while let Some(first) = rest.first() {
        let (instruction, others) = rest.split_at((first >> 16) as usize);
        instructions.push((Op::from_u32(first & 0xffff), instruction));
        rest = others;
    }
    let of_functions = instructions.iter().position(|(op, _)| *op == Some(Op::Function));
    let globals = &instructions[..of_functions.unwrap_or(instructions.len())];
    // The id that is defined is the first operand of a type, and the second one of a variable or constant.
    let declared: Vec<u32> = globals
        .iter()
        .filter_map(|(op, words)| match (*op)? {
            Op::TypeStruct => Some(words[1]),
            Op::Variable | Op::SpecConstant => Some(words[2]),
            _ => None,
        })
        .collect();
    let is_kept = |(op, words): &&(Option<Op>, &[u32])| match op {
        Some(Op::Name | Op::MemberName) => declared.contains(&words[1]),
        Some(
            Op::Source
            | Op::SourceContinued
            | Op::SourceExtension
            | Op::String
            | Op::Line
            | Op::NoLine
            | Op::ModuleProcessed,
        ) => false,
        _ => true,
    };
    let kept = instructions.iter().filter(is_kept).flat_map(|(_, words)| *words);
    words[..HEADER].iter().chain(kept).flat_map(|word| word.to_le_bytes()).collect()
}
