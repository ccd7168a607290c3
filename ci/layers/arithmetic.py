#!/usr/bin/env python3
"""Rewrites shaders for the arithmetic of other GPUs, and for other orders of workgroups.

    arithmetic.py MODES SPIRV OUT

writes a module to the folder OUT for each module in the folder SPIRV. The new module computes as MODES say, and has
the file name by which the layer guise.c finds it (GUISE_MODULES). MODES are some of these, separated by commas:

    fma   a product in a sum is not rounded before the addition (every GPU), unless the shader forbids it; this is
          computed in double precision, so that only the last rounding may differ
    div   a / b is a * (1 / b), as on most GPUs
    ulp   as div, and reciprocals and roots are off by up to one unit in the last place unless they are exact
          (Vulkan allows 2.5 units for divisions, and 2 for inverse roots)
    cmp   comparisons with NaN are true, but != is false (as with compilers that assume that there are no NaNs)
    mm    the operands of min and max are exchanged, which may give the number instead of NaN or the reverse
    back  the workgroups of a dispatch run in reverse order
    mixed the workgroups run in a scattered order: each is about a thousand after the previous one, cyclically

Needs spirv-dis, spirv-as and spirv-val.
"""

import pathlib
import re
import subprocess
import sys

MODES = {"fma", "div", "ulp", "cmp", "mm", "back", "mixed"}
INSTRUCTION = re.compile(r"(%\d+) = (\w+)(.*)")


class Module:
    """A disassembled module, and the additions to it."""

    def __init__(self, path):
        text = run(["spirv-dis", "--raw-id", "--no-indent", path]).stdout
        self.lines = [line for line in text.split("\n") if not line.startswith(";")]
        self.last = int(re.search(r"; Bound: (\d+)", text).group(1))
        self.added = []  # types and constants
        self.made = {}  # ids of types and constants, by definition
        self.defined = {}
        for line in self.lines:
            if found := INSTRUCTION.match(line):
                self.defined[found[1]] = (found[2], found[3].split())
        # Results for which the shader forbids fused operations.
        self.precise = {line.split()[1] for line in self.lines if line.endswith(" NoContraction")}
        self.float = self.type_of("OpTypeFloat", "32")
        self.glsl = next(name for name, (op, _) in self.defined.items() if op == "OpExtInstImport")
        # Number of components of each type of floats.
        self.width = {self.float: 1}
        for name, (op, operands) in self.defined.items():
            if op == "OpTypeVector" and operands[0] == self.float:
                self.width[name] = int(operands[1])

    def new(self):
        self.last += 1
        return f"%{self.last}"

    def type_of(self, op, *operands):
        """Returns a type, which is added unless it exists."""
        key = (op, *operands)
        if key not in self.made:
            there = [name for name, what in self.defined.items() if what == (op, list(operands))]
            self.made[key] = there[0] if there else self.add(op, *operands)
        return self.made[key]

    def add(self, *instruction):
        name = self.new()
        self.added.append(f"{name} = {' '.join(instruction)}")
        return name

    def vector(self, of, width):
        return of if width == 1 else self.type_of("OpTypeVector", of, str(width))

    def constant(self, of, width, value):
        """Returns a constant with the same number in each component."""
        key = (of, width, value)
        if key not in self.made:
            if width == 1:
                self.made[key] = self.add("OpConstant", of, value)
            else:
                parts = [self.constant(of, 1, value)] * width
                self.made[key] = self.add("OpConstantComposite", self.vector(of, width), *parts)
        return self.made[key]

    def product_of(self, name, of):
        """Returns the factors of `name` if it is a product of the type `of`, and None otherwise."""
        op, operands = self.defined.get(name, ("", []))
        return operands[1:] if op == "OpFMul" and operands[0] == of else None


class Function:
    """Instructions that are inserted, or replace one instruction."""

    def __init__(self, module):
        self.module = module
        self.lines = []

    def emit(self, op, of, *operands, result=None):
        result = result or self.module.new()
        self.lines.append(" ".join([result, "=", op, of, *operands]))
        return result


def fused(module, result, op, operands, mode):
    """Replaces a sum that has a product as a term by a fused multiply-add."""
    if op not in ("OpFAdd", "OpFSub", "OpExtInst") or operands[0] not in module.width or result in module.precise:
        return None
    of = operands[0]
    if op == "OpExtInst" and operands[2] == "Fma":
        factors, added, sign = operands[3:5], operands[5], "OpFAdd"
    elif op in ("OpFAdd", "OpFSub"):
        first, second = operands[1:]
        sign = op
        if factors := module.product_of(first, of):
            added = second
        elif factors := module.product_of(second, of):
            added = first
        else:
            return None
    else:
        return None  # another function
    wide = module.vector(module.type_of("OpTypeFloat", "64"), module.width[of])
    code = Function(module)
    a, b, c = (code.emit("OpFConvert", wide, part) for part in (*factors, added))
    product = code.emit("OpFMul", wide, a, b)
    # In `added - product`, the product comes second.
    parts = (c, product) if op == "OpFSub" and added == operands[1] else (product, c)
    code.emit("OpFConvert", of, code.emit(sign, wide, *parts), result=result)
    return code.lines


def off_by_one(module, code, of, exact, is_inexact, result=None):
    """Changes an inexact result by -1, 0 or 1 units in the last place, chosen by its hash."""
    width = module.width[of]
    word = module.type_of("OpTypeInt", "32", "0")
    words = module.vector(word, width)

    def number(value):
        return module.constant(word, width, str(value))

    bits = code.emit("OpBitcast", words, exact)
    hashed = code.emit("OpIMul", words, bits, number(2654435761))
    # 0 and 3 are one unit less and more, 1 and 2 are no change.
    quarter = code.emit("OpShiftRightLogical", words, hashed, number(30))
    more = code.emit("OpShiftRightLogical", words, code.emit("OpIAdd", words, quarter, number(1)), number(2))
    less = code.emit("OpShiftRightLogical", words, code.emit("OpISub", words, number(4), quarter), number(2))
    by = code.emit("OpISub", words, more, less)
    by = code.emit("OpSelect", words, is_inexact, by, number(0))
    moved = code.emit("OpIAdd", words, bits, by)
    return code.emit("OpBitcast", of, moved, result=result)


def booleans(module, width):
    return module.vector(module.type_of("OpTypeBool"), width)


def divided(module, result, op, operands, mode):
    """Replaces a division by a product with the reciprocal."""
    if op != "OpFDiv" or operands[0] not in module.width:
        return None
    of, dividend, divisor = operands
    width = module.width[of]
    code = Function(module)
    inverse = code.emit("OpFDiv", of, module.constant(module.float, width, "1"), divisor)
    if "ulp" in mode:
        word = module.type_of("OpTypeInt", "32", "0")
        words = module.vector(word, width)
        # Reciprocals of powers of two are exact.
        bits = code.emit("OpBitcast", words, divisor)
        fraction = code.emit("OpBitwiseAnd", words, bits, module.constant(word, width, str(0x7FFFFF)))
        zero = module.constant(word, width, "0")
        is_inexact = code.emit("OpINotEqual", booleans(module, width), fraction, zero)
        inverse = off_by_one(module, code, of, inverse, is_inexact)
    code.emit("OpFMul", of, dividend, inverse, result=result)
    return code.lines


def root(module, result, op, operands, mode):
    """Replaces a root by an inexact one."""
    if op != "OpExtInst" or operands[2] not in ("Sqrt", "InverseSqrt") or operands[0] not in module.width:
        return None
    of, _, which, square = operands
    code = Function(module)
    exact = code.emit("OpExtInst", of, module.glsl, which, square)
    again = code.emit("OpFMul", of, exact, exact)
    is_inexact = code.emit("OpFUnordNotEqual", booleans(module, module.width[of]), again, square)
    off_by_one(module, code, of, exact, is_inexact, result=result)
    return code.lines


def compared(module, result, op, operands, mode):
    """Replaces a comparison by one that is true for NaN, or false for NaN if it is !=."""
    if op.startswith("OpFOrd"):
        return [" ".join([result, "=", op.replace("OpFOrd", "OpFUnord"), *operands])]
    if op == "OpFUnordNotEqual":
        return [" ".join([result, "=", "OpFOrdNotEqual", *operands])]
    return None


def swapped(module, result, op, operands, mode):
    """Exchanges the operands of a minimum or maximum."""
    if op != "OpExtInst" or operands[2] not in ("FMin", "FMax"):
        return None
    return [" ".join([result, "=", op, *operands[:3], operands[4], operands[3]])]


# Strides of a mixed order. At least one has no common divisor with the number of workgroups.
STRIDES = (1009, 1013, 1019, 1021)


def reordered(module, mode):
    """Reorders the ids of workgroups: the shader reads private variables in place of the device's inputs."""
    seen = {}
    for line in module.lines:
        if found := re.match(r"OpDecorate (%\d+) BuiltIn (WorkgroupId|GlobalInvocationId|NumWorkgroups|WorkgroupSize)", line):
            seen[found[2]] = found[1]
    numbers = [name for name in ("WorkgroupId", "GlobalInvocationId") if name in seen]
    if not numbers:
        return
    word = module.type_of("OpTypeInt", "32", "0")
    words = module.type_of("OpTypeVector", word, "3")
    own_words = module.type_of("OpTypePointer", "Private", words)
    own_word = module.type_of("OpTypePointer", "Private", word)
    given = module.type_of("OpTypePointer", "Input", words)
    inputs = {}
    for name in ("WorkgroupId", "NumWorkgroups"):
        inputs[name] = seen.get(name) or module.add("OpVariable", given, "Input")
    if "WorkgroupSize" in seen:
        size = seen["WorkgroupSize"]
    else:
        sides = next(line.split()[3:6] for line in module.lines if re.match(r"OpExecutionMode %\d+ LocalSize ", line))
        size = module.add("OpConstantComposite", words, *(module.constant(word, 1, side) for side in sides))
    own = {name: module.add("OpVariable", own_words, "Private") for name in numbers}

    code = Function(module)

    def number(value):
        return module.constant(word, 1, str(value))

    group = code.emit("OpLoad", words, inputs["WorkgroupId"])
    count = code.emit("OpLoad", words, inputs["NumWorkgroups"])
    at = [code.emit("OpCompositeExtract", word, group, str(i)) for i in range(3)]
    counts = [code.emit("OpCompositeExtract", word, count, str(i)) for i in range(3)]
    in_layer = code.emit("OpIMul", word, counts[0], counts[1])
    all_groups = code.emit("OpIMul", word, in_layer, counts[2])
    row = code.emit("OpIAdd", word, at[1], code.emit("OpIMul", word, at[2], counts[1]))
    place = code.emit("OpIAdd", word, at[0], code.emit("OpIMul", word, row, counts[0]))
    if "back" in mode:
        last = code.emit("OpISub", word, all_groups, number(1))
        place = code.emit("OpISub", word, last, place)
    else:
        stride = number(STRIDES[-1])
        boolean = module.type_of("OpTypeBool")
        for prime in STRIDES[-2::-1]:
            rest = code.emit("OpUMod", word, all_groups, number(prime))
            divides = code.emit("OpIEqual", boolean, rest, number(0))
            stride = code.emit("OpSelect", word, divides, stride, number(prime))
        place = code.emit("OpUMod", word, code.emit("OpIMul", word, place, stride), all_groups)
    in_place_layer = code.emit("OpUMod", word, place, in_layer)
    moved = code.emit(
        "OpCompositeConstruct",
        words,
        code.emit("OpUMod", word, in_place_layer, counts[0]),
        code.emit("OpUDiv", word, in_place_layer, counts[0]),
        code.emit("OpUDiv", word, place, in_layer),
    )
    entry = [] if "WorkgroupId" not in own else [f"OpStore {own['WorkgroupId']} {moved}"]
    if "GlobalInvocationId" in own:
        whole = code.emit("OpLoad", words, seen["GlobalInvocationId"])
        by = code.emit("OpIMul", words, code.emit("OpISub", words, moved, group), size)
        entry.append(f"OpStore {own['GlobalInvocationId']} {code.emit('OpIAdd', words, whole, by)}")
    code.lines += entry

    # Lets the shader read its private variables.
    main = next(line.split()[2] for line in module.lines if line.startswith("OpEntryPoint"))
    chains = set()
    lines = []
    in_main = False
    for line in module.lines:
        if line.startswith("OpEntryPoint"):
            line += "".join(f" {name}" for name in inputs.values() if name not in line.split())
        found = INSTRUCTION.match(line)
        if found and found[2] == "OpLoad" and found[3].split()[1] in (seen[name] for name in numbers):
            name = next(name for name in numbers if found[3].split()[1] == seen[name])
            line = f"{found[1]} = OpLoad {words} {own[name]}"
        if found and found[2] == "OpAccessChain" and found[3].split()[1] in (seen[name] for name in numbers):
            name = next(name for name in numbers if found[3].split()[1] == seen[name])
            line = f"{found[1]} = OpAccessChain {own_word} {own[name]} {found[3].split()[2]}"
            chains.add(found[1])
        in_main = in_main or (found is not None and found[1] == main and found[2] == "OpFunction")
        lines.append(line)
        if in_main and found and found[2] == "OpLabel":
            # The stores come after the variables of the function.
            in_main = False
            lines.append(None)
    at_entry = lines.index(None)
    after = at_entry + 1
    while " OpVariable " in lines[after]:
        after += 1
    lines[after:after] = code.lines
    del lines[at_entry]
    decorations = [f"OpDecorate {name} BuiltIn {what}" for what, name in inputs.items() if what not in seen]
    first = next(i for i, line in enumerate(lines) if line.startswith("OpDecorate"))
    lines[first:first] = decorations
    module.lines = lines


def rewritten(path, mode):
    """Returns the text of a module in the arithmetic and order of `mode`."""
    module = Module(path)
    if {"back", "mixed"} & mode:
        reordered(module, mode)
    ways = [
        way
        for way, asked in (
            (fused, {"fma"}),
            (divided, {"div", "ulp"}),
            (root, {"ulp"}),
            (compared, {"cmp"}),
            (swapped, {"mm"}),
        )
        if asked & mode
    ]
    lines = []
    start = None
    for line in module.lines:
        found = INSTRUCTION.match(line)
        if found and found[2] == "OpFunction" and start is None:
            start = len(lines)
        other = None
        if found and start is not None:
            operands = found[3].split()
            other = next((new for way in ways if (new := way(module, found[1], found[2], operands, mode))), None)
        lines += other or [line]
    lines[start:start] = module.added
    if any(line.endswith("OpTypeFloat 64") for line in module.added):
        lines.insert(0, "OpCapability Float64")
    return "\n".join(lines)


def fnv1a(content):
    hashed = 0xCBF29CE484222325
    for byte in content:
        hashed = ((hashed ^ byte) * 0x100000001B3) & (2**64 - 1)
    return hashed


def run(command, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    return done


def main():
    if len(sys.argv) != 4 or not set(sys.argv[1].split(",")) <= MODES:
        sys.exit(__doc__)
    mode, source, out = set(sys.argv[1].split(",")), pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    out.mkdir(parents=True, exist_ok=True)
    paths = sorted(source.glob("*.spv"))
    if not paths:
        sys.exit(f"no module in {source}")
    for path in paths:
        other = out / f"{fnv1a(path.read_bytes()):016x}.spv"
        assemble = ["spirv-as", "--target-env", "vulkan1.1", "-o", other, "-"]
        run(assemble, input=rewritten(path, mode))
        run(["spirv-val", "--target-env", "vulkan1.1", other])
    print(f"{len(paths)} modules with {','.join(sorted(mode))}")


if __name__ == "__main__":
    main()
