//! Reads a shader's interface from a SPIR-V module: its bindings, the constants that are set when a
//! pipeline is created, and the layout of its blocks.

use std::collections::BTreeMap;

use rspirv::binary::{Consumer, ParseAction, parse_bytes};
use rspirv::dr::{Instruction, ModuleHeader, Operand};
use rspirv::spirv::{BuiltIn, Decoration, Dim, Op, StorageClass};

/// The interface of a shader.
#[derive(Debug, Default)]
pub struct Interface {
    /// Bindings in the order of sets and numbers.
    pub bindings: Vec<Binding>,
    /// Specialization constants: number and name.
    pub constants: Vec<(u32, String)>,
    /// Block of push constants.
    pub push_constants: Option<Block>,
    /// For each storage buffer up to two blocks: one of the members whose sizes are known, and the structure of which
    /// an array of any length consists.
    pub buffers: Vec<Block>,
}

/// A descriptor that a shader uses.
#[derive(Debug)]
pub struct Binding {
    pub set: u32,
    pub number: u32,
    pub kind: Kind,
    /// Name of the image or of the buffer's block.
    pub name: String,
}

/// Type of a descriptor, by the name of the enumerant in ash's `DescriptorType`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    StorageBuffer,
    StorageImage,
    SampledImage,
}

/// A structure that shaders and Rust share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    pub name: String,
    pub members: Vec<Member>,
    pub size: u32,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    pub name: String,
    pub offset: u32,
    /// Type in Rust.
    pub kind: String,
    pub size: u32,
}

impl Interface {
    /// Reads the interface from a module.
    pub fn of(spirv: &[u8]) -> Result<Self, String> {
        let mut module = Declarations::default();
        parse_bytes(spirv, &mut module).map_err(|error| error.to_string()).or_else(|error| {
            // The parser also returns an error where it is stopped, at the first function.
            if module.is_whole { Ok(()) } else { Err(error) }
        })?;
        module.interface()
    }

    /// Adds what another module of the same shader has and this interface lacks.
    pub fn add(&mut self, other: Self) {
        for binding in other.bindings {
            if self
                .bindings
                .iter()
                .all(|own| (own.set, own.number) != (binding.set, binding.number))
            {
                self.bindings.push(binding);
            }
        }
        self.bindings.sort_by_key(|binding| (binding.set, binding.number));
        for (number, name) in other.constants {
            self.add_constant((number, &name));
        }
        self.push_constants = self.push_constants.take().or(other.push_constants);
        for block in other.buffers {
            if !self.buffers.contains(&block) {
                self.buffers.push(block);
            }
        }
    }

    pub fn add_constant(&mut self, (number, name): (u32, &str)) {
        if self.constants.iter().all(|(own, _)| *own != number) {
            self.constants.push((number, name.to_owned()));
            self.constants.sort();
        }
    }
}

/// Declarations before the functions of a module, by their ids.
#[derive(Default)]
struct Declarations {
    names: BTreeMap<u32, String>,
    member_names: BTreeMap<(u32, u32), String>,
    decorations: BTreeMap<(u32, Decoration), u32>,
    offsets: BTreeMap<(u32, u32), u32>,
    instructions: BTreeMap<u32, Instruction>,
    is_whole: bool,
}

impl Consumer for Declarations {
    fn initialize(&mut self) -> ParseAction {
        ParseAction::Continue
    }

    fn finalize(&mut self) -> ParseAction {
        self.is_whole = true;
        ParseAction::Continue
    }

    fn consume_header(&mut self, _: ModuleHeader) -> ParseAction {
        ParseAction::Continue
    }

    fn consume_instruction(&mut self, instruction: Instruction) -> ParseAction {
        let operands = &instruction.operands;
        let number = |place: usize| match operands.get(place) {
            Some(Operand::BuiltIn(built_in)) => *built_in as u32,
            Some(other) => other.id_ref_any().unwrap_or_else(|| literal(Some(other))),
            None => 0,
        };
        match instruction.class.opcode {
            Op::Function => {
                self.is_whole = true;
                return ParseAction::Stop;
            }
            Op::Name => drop(self.names.insert(number(0), text(&operands[1]))),
            Op::MemberName => {
                self.member_names.insert((number(0), number(1)), text(&operands[2]));
            }
            Op::Decorate => {
                if let Operand::Decoration(decoration) = operands[1] {
                    self.decorations.insert((number(0), decoration), number(2));
                }
            }
            Op::MemberDecorate => {
                if let Operand::Decoration(Decoration::Offset) = operands[2] {
                    self.offsets.insert((number(0), number(1)), number(3));
                }
            }
            _ => {
                if let Some(id) = instruction.result_id {
                    self.instructions.insert(id, instruction);
                }
            }
        }
        ParseAction::Continue
    }
}

impl Declarations {
    fn interface(&self) -> Result<Interface, String> {
        let mut bindings = Vec::new();
        let mut constants = Vec::new();
        let mut push_constants = None;
        let mut buffers = Vec::new();
        for (&id, instruction) in &self.instructions {
            if let Some(&number) = self.decorations.get(&(id, Decoration::SpecId)) {
                constants.push((number, self.constant_name(id)?));
            }
            if instruction.class.opcode != Op::Variable {
                continue;
            }
            let of = self.target(instruction.result_type.expect("variables have a type"));
            let set = self.decorations.get(&(id, Decoration::DescriptorSet));
            let number = self.decorations.get(&(id, Decoration::Binding));
            if let (Some(&set), Some(&number)) = (set, number) {
                let kind = self.kind(of)?;
                // Buffers have the name of their block.
                let name = if kind == Kind::StorageBuffer { self.name(of) } else { self.name(id) }?;
                if kind == Kind::StorageBuffer {
                    self.buffer_blocks(of, &mut buffers)?;
                }
                bindings.push(Binding { set, number, kind, name });
            } else if instruction.operands[0] == Operand::StorageClass(StorageClass::PushConstant) {
                push_constants = Some(self.block(of)?);
            }
        }
        bindings.sort_by_key(|binding| (binding.set, binding.number));
        constants.sort();
        Ok(Interface { bindings, constants, push_constants, buffers })
    }

    fn name(&self, id: u32) -> Result<String, String> {
        let name = self.names.get(&id).filter(|name| !name.is_empty());
        name.cloned().ok_or_else(|| format!("%{id} has no name"))
    }

    /// Returns the name of a constant. The sizes of workgroups have no names of their own.
    fn constant_name(&self, id: u32) -> Result<String, String> {
        let is_size = |of: &&u32| {
            let built_in = self.decorations.get(&(**of, Decoration::BuiltIn));
            built_in == Some(&(BuiltIn::WorkgroupSize as u32))
        };
        if let Some(size) = self.instructions.keys().find(is_size) {
            let parts = &self.instructions[size].operands;
            if let Some(axis) = parts.iter().position(|part| *part == Operand::IdRef(id)) {
                return Ok(["LOCAL_SIZE_X", "LOCAL_SIZE_Y", "LOCAL_SIZE_Z"][axis].to_owned());
            }
        }
        self.name(id)
    }

    /// Returns the type to which a pointer points.
    fn target(&self, pointer: u32) -> u32 {
        literal_or_id(&self.instructions[&pointer].operands[1])
    }

    fn kind(&self, of: u32) -> Result<Kind, String> {
        let instruction = &self.instructions[&of];
        match instruction.class.opcode {
            Op::TypeStruct => Ok(Kind::StorageBuffer),
            Op::TypeImage if instruction.operands[1] == Operand::Dim(Dim::Dim2D) => {
                const STORAGE: u32 = 2;
                let is_storage = literal(instruction.operands.get(5)) == STORAGE;
                Ok(if is_storage { Kind::StorageImage } else { Kind::SampledImage })
            }
            other => Err(format!("a descriptor of {other:?}, which no set layout here has")),
        }
    }

    /// Collects the members of a buffer's block that have a size, as one block, and the structure of which its array
    /// of any length consists.
    fn buffer_blocks(&self, of: u32, into: &mut Vec<Block>) -> Result<(), String> {
        let mut members = Vec::new();
        for (place, part) in (0..).zip(&self.instructions[&of].operands) {
            let part = literal_or_id(part);
            let instruction = &self.instructions[&part];
            if instruction.class.opcode == Op::TypeRuntimeArray {
                let element = literal_or_id(&instruction.operands[0]);
                if self.instructions[&element].class.opcode == Op::TypeStruct {
                    into.push(self.block(element)?);
                }
            } else {
                members.push(self.member(of, place, part)?);
            }
        }
        if !members.is_empty() {
            into.push(block(self.name(of)?, members));
        }
        Ok(())
    }

    fn block(&self, of: u32) -> Result<Block, String> {
        let parts = (0..).zip(&self.instructions[&of].operands);
        let members = parts.map(|(place, part)| self.member(of, place, literal_or_id(part)));
        Ok(block(self.name(of)?, members.collect::<Result<_, _>>()?))
    }

    fn member(&self, of: u32, place: u32, part: u32) -> Result<Member, String> {
        let name = self.member_names.get(&(of, place)).cloned();
        let name = name.ok_or_else(|| format!("member {place} of %{of} has no name"))?;
        let offset = self.offsets.get(&(of, place)).copied();
        let offset = offset.ok_or_else(|| format!("member {name} has no offset"))?;
        let (kind, size) = self.rust(part).ok_or_else(|| format!("{name}: no type in Rust"))?;
        Ok(Member { name, offset, kind, size })
    }

    /// Returns the Rust type of a SPIR-V type, and its size in bytes.
    fn rust(&self, of: u32) -> Option<(String, u32)> {
        let instruction = &self.instructions[&of];
        let operand = |place: usize| instruction.operands.get(place).map(literal_or_id);
        match instruction.class.opcode {
            Op::TypeFloat if operand(0)? == 32 => Some(("f32".into(), 4)),
            Op::TypeInt if operand(0)? == 32 => {
                Some((if operand(1)? == 0 { "u32" } else { "i32" }.into(), 4))
            }
            Op::TypeVector => {
                let ((of, size), count) = (self.rust(operand(0)?)?, operand(1)?);
                Some((format!("[{of}; {count}]"), count * size))
            }
            Op::TypeArray => {
                let (of, size) = self.rust(operand(0)?)?;
                let count = literal(self.instructions[&operand(1)?].operands.first());
                let stride =
                    *self.decorations.get(&(instruction.result_id?, Decoration::ArrayStride))?;
                (stride == size).then(|| (format!("[{of}; {count}]"), count * size))
            }
            _ => None,
        }
    }
}

fn block(name: String, members: Vec<Member>) -> Block {
    let size = members.last().map_or(0, |last| last.offset + last.size);
    Block { name, members, size }
}

fn text(operand: &Operand) -> String {
    match operand {
        Operand::LiteralString(text) => text.clone(),
        other => panic!("{other} is no name"),
    }
}

fn literal(operand: Option<&Operand>) -> u32 {
    match operand {
        Some(Operand::LiteralBit32(number)) => *number,
        _ => 0,
    }
}

fn literal_or_id(operand: &Operand) -> u32 {
    operand.id_ref_any().unwrap_or_else(|| literal(Some(operand)))
}
