#!/usr/bin/env python3
"""Shaders in the arithmetic of other GPUs.

    arithmetic.py MODES SPIRV OUT

writes for each module in the folder SPIRV one into the folder OUT that computes as MODES say, under the name by
which the layer guise.c finds it (GUISE_MODULES). MODES are some of these, separated by commas:

    fma   products that are added to are not rounded before (every GPU), unless the shader forbids it; in double
          precision, of which the last rounding alone may differ
    div   a / b is a * (1 / b), as on most GPUs
    ulp   the same, and reciprocals and roots are off by up to one unit in the last place unless they are exact
          (Vulkan allows 2.5 units of divisions, and 2 of inverse roots)
    cmp   comparisons with what is no number are true (compilers that take it for granted that there is none)
    mm    the operands of min and max change places: of a number and none, the other one is taken

Needs spirv-dis, spirv-as and spirv-val.
"""

import pathlib
import re
import subprocess
import sys

MODES = {"fma", "div", "ulp", "cmp", "mm"}
INSTRUCTION = re.compile(r"(%\d+) = (\w+)(.*)")


class Module:
    """A disassembled module, with what is added to it."""

    def __init__(self, path):
        text = run(["spirv-dis", "--raw-id", "--no-indent", path]).stdout
        self.lines = [line for line in text.split("\n") if not line.startswith(";")]
        self.last = int(re.search(r"; Bound: (\d+)", text).group(1))
        self.added = []  # types and constants
        self.made = {}  # by what they are
        self.defined = {}
        for line in self.lines:
            if found := INSTRUCTION.match(line):
                self.defined[found[1]] = (found[2], found[3].split())
        # Results for which the shader asks that nothing be fused.
        self.precise = {line.split()[1] for line in self.lines if line.endswith(" NoContraction")}
        self.float = self.type_of("OpTypeFloat", "32")
        self.glsl = next(name for name, (op, _) in self.defined.items() if op == "OpExtInstImport")
        # How many numbers a type of floats holds.
        self.width = {self.float: 1}
        for name, (op, operands) in self.defined.items():
            if op == "OpTypeVector" and operands[0] == self.float:
                self.width[name] = int(operands[1])

    def new(self):
        self.last += 1
        return f"%{self.last}"

    def type_of(self, op, *operands):
        """A type, which is added unless it is there."""
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
        """The same number in each place."""
        key = (of, width, value)
        if key not in self.made:
            if width == 1:
                self.made[key] = self.add("OpConstant", of, value)
            else:
                parts = [self.constant(of, 1, value)] * width
                self.made[key] = self.add("OpConstantComposite", self.vector(of, width), *parts)
        return self.made[key]

    def product_of(self, name, of):
        """The factors of a product of a type; None if it is something else."""
        op, operands = self.defined.get(name, ("", []))
        return operands[1:] if op == "OpFMul" and operands[0] == of else None


class Function:
    """Instructions that take the place of one."""

    def __init__(self, module):
        self.module = module
        self.lines = []

    def emit(self, op, of, *operands, result=None):
        result = result or self.module.new()
        self.lines.append(" ".join([result, "=", op, of, *operands]))
        return result


def fused(module, result, op, operands, mode):
    """A sum of which one part is a product."""
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
    # Of `added - product` the product comes second.
    parts = (c, product) if op == "OpFSub" and added == operands[1] else (product, c)
    code.emit("OpFConvert", of, code.emit(sign, wide, *parts), result=result)
    return code.lines


def off_by_one(module, code, of, exact, is_inexact, result=None):
    """A result off by -1, 0 or 1 units in the last place, by a hash of it, where it is not exact."""
    width = module.width[of]
    word = module.type_of("OpTypeInt", "32", "0")
    words = module.vector(word, width)

    def number(value):
        return module.constant(word, width, str(value))

    bits = code.emit("OpBitcast", words, exact)
    hashed = code.emit("OpIMul", words, bits, number(2654435761))
    # 0 and 3 for one unit less and more, 1 and 2 for none.
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
    """A division as a product with the reciprocal."""
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
    """A root that is not exact."""
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
    """A comparison that takes it for granted that there are numbers."""
    if op.startswith("OpFOrd"):
        return [" ".join([result, "=", op.replace("OpFOrd", "OpFUnord"), *operands])]
    if op == "OpFUnordNotEqual":
        return [" ".join([result, "=", "OpFOrdNotEqual", *operands])]
    return None


def swapped(module, result, op, operands, mode):
    """The least or largest with its operands the other way round."""
    if op != "OpExtInst" or operands[2] not in ("FMin", "FMax"):
        return None
    return [" ".join([result, "=", op, *operands[:3], operands[4], operands[3]])]


def rewritten(path, mode):
    """The text of a module in this arithmetic."""
    module = Module(path)
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
