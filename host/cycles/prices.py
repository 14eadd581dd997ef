"""What an instruction of the intermediate code costs on a C28x with FPU (TMS320F28335), in cycles.

After the C28x CPU and instruction set guide (SPRU430), the FPU's (SPRUEO2) and its fast run-time library's
(SPRCA75), with program and data in internal RAM without wait states:

* A float addition or multiplication takes two pipeline cycles (2p); both are counted. There is no instruction
  for a division or a root: the library's take about 24 and 28 cycles.
* The integer unit works through an accumulator: an operation and the move of an operand, two cycles. 64 bits
  take two words: ADDUL with ADDCL, IMPYL with QMPYL for 32 × 32 bits; shifts go 16 bits at a time.
* A branch empties the pipeline: 4 cycles (SBF, BF); a call with its return 8.

An address costs a cycle: the indices of an array need no 64 bits there, whatever the intermediate code says.
What no price tells: moves when the eight FPU registers do not suffice, and instructions that a good compiler
pairs (a multiplication beside a load). They go in opposite directions; the sum is good to perhaps a third.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

ASSIGNED = re.compile(r"^(%[\w.$-]+|%\"[^\"]+\") = (.*)$")
NAMES = re.compile(r'%[\w.$-]+|%"[^"]+"')
TYPE = re.compile(r"\b(i1|i8|i16|i32|i64|float|double|ptr)\b")
WORDS_BEFORE = {"tail", "musttail", "notail"}

FLOAT, DIVISION, INTEGER, WIDE = "float", "division and root", "integer", "64-bit integer"
MEMORY, BRANCH, DOUBLE = "memory and addresses", "branches and calls", "double"
KINDS = (FLOAT, DIVISION, INTEGER, WIDE, MEMORY, BRANCH, DOUBLE)

FLOAT_DIVISION, FLOAT_ROOT = 24, 28
INTEGER_DIVISION, WIDE_DIVISION = 40, 220
WIDE_PRODUCT, LONG_PRODUCT = 14, 5
SOFT_DOUBLE = 100
"""An operation in software; no profile that flies has any."""

FREE = frozenset(
    (
        "phi",
        "bitcast",
        "inttoptr",
        "ptrtoint",
        "unreachable",
        "freeze",
        "extractvalue",
        "insertvalue",
        "alloca",
    )
)
BRANCHES = {"br": 4, "ret": 4, "switch": 8}
WIDE_PRICES = {"add": 4, "sub": 4, "and": 4, "or": 4, "xor": 4, "icmp": 3, "select": 5, "mul": WIDE_PRODUCT,
               "sext": 2, "zext": 2, "trunc": 1, "sdiv": WIDE_DIVISION, "udiv": WIDE_DIVISION,
               "srem": WIDE_DIVISION, "urem": WIDE_DIVISION}  # fmt: skip
INTEGER_PRICES = {"sdiv": INTEGER_DIVISION, "udiv": INTEGER_DIVISION, "srem": INTEGER_DIVISION,
                  "urem": INTEGER_DIVISION, "mul": 3, "sext": 1, "zext": 1, "trunc": 1}  # fmt: skip
INTRINSICS = {"llvm.smax": 1, "llvm.smin": 1, "llvm.umax": 1, "llvm.umin": 1, "llvm.abs": 1,
              "llvm.fshl": 4, "llvm.fshr": 4, "llvm.ctlz": 2, "llvm.cttz": 4}  # fmt: skip
"""In operations of their width."""
NOTHING_CALLED = ("llvm.lifetime", "llvm.assume", "llvm.dbg", "llvm.experimental")


@dataclass(frozen=True, slots=True)
class Price:
    """Cycles of one instruction, and of which kind."""

    kind: str
    cycles: float


class Pricing:
    """Prices of the instructions of one function."""

    def __init__(self, instructions: Sequence[str]) -> None:
        self._addresses = _addresses(instructions)
        self._long = _extended(instructions)

    def price(self, instruction: str) -> Price:
        """Of one instruction of the function."""
        name, action = _split(instruction)
        words = [word for word in action.split() if word not in WORDS_BEFORE]
        operation = words[0] if words else ""
        if operation in FREE or not re.match(r"[a-z]", operation):
            return Price(INTEGER, 0)
        if operation in BRANCHES:
            return Price(BRANCH, BRANCHES[operation])
        if operation == "call":
            return _call(action)
        if operation == "getelementptr" or name in self._addresses:
            return Price(MEMORY, 1)
        kind = _type(operation, action)
        if operation in ("load", "store"):
            return Price(MEMORY, 2 if kind in ("i64", "double") else 1)
        if kind == "double":
            return Price(DOUBLE, SOFT_DOUBLE)
        if kind == "float" or operation in ("fptosi", "fptoui"):
            return Price(DIVISION, FLOAT_DIVISION) if operation == "fdiv" else Price(FLOAT, 2)
        if kind == "i64":
            return Price(WIDE, self._wide(operation, action))
        return Price(INTEGER, INTEGER_PRICES.get(operation, 2))

    def _wide(self, operation: str, action: str) -> float:
        if operation in ("shl", "ashr", "lshr"):
            amount = action.rsplit(",", 1)[-1].strip()
            return 1 + -(-int(amount) // 16) if amount.isdigit() else 3
        if operation == "mul":
            return LONG_PRODUCT if all(map(self._is_long, _operands(action))) else WIDE_PRODUCT
        return WIDE_PRICES.get(operation, 4)

    def _is_long(self, operand: str) -> bool:
        """Whether a value of 64 bits holds but 32."""
        if operand.lstrip("-").isdigit():
            return -(1 << 31) <= int(operand) < 1 << 31
        return operand in self._long


def _call(action: str) -> Price:
    match = re.search(r'@("[^"]+"|[\w.$-]+)\(', action)
    called = match[1].strip('"') if match else ""
    if called.startswith(NOTHING_CALLED):
        return Price(INTEGER, 0)
    if called in ("sqrtf", "llvm.sqrt.f32"):
        return Price(DIVISION, FLOAT_ROOT)
    if called in ("sqrt", "llvm.sqrt.f64"):
        return Price(DOUBLE, SOFT_DOUBLE)
    if called.startswith(("llvm.fabs", "llvm.copysign", "llvm.minnum", "llvm.maxnum")):
        return Price(FLOAT, 2) if called.endswith("f32") else Price(DOUBLE, SOFT_DOUBLE)
    for name, operations in INTRINSICS.items():
        if called.startswith(name):
            wide = ".i64" in called
            return Price(WIDE if wide else INTEGER, operations * (5 if wide else 2))
    return Price(BRANCH, 8)


def _split(instruction: str) -> tuple[str, str]:
    match = ASSIGNED.match(instruction)
    return (match[1], match[2]) if match else ("", instruction)


def _type(operation: str, action: str) -> str:
    """Of the operands; of a conversion, the wider type."""
    found = TYPE.findall(action)
    if operation in ("sext", "zext", "trunc", "fpext", "fptrunc", "sitofp", "uitofp", "fptosi", "fptoui"):
        order = ("double", "i64", "float", "i32", "i16", "i8", "i1")
        return next((kind for kind in order if kind in found), "i32")
    if operation == "select":  # of the values, behind the condition
        return found[1] if len(found) > 1 else "i32"
    return found[0] if found else "i32"


def _operands(action: str) -> list[str]:
    """The two of `mul nsw i64 %a, %b`."""
    first, _, second = action.rpartition(",")
    return [first.split()[-1], second.strip().split(",")[0]]


def _extended(instructions: Iterable[str]) -> set[str]:
    """Values of 64 bits that came from 32, or were shifted down to them."""
    found = set()
    for one in instructions:
        name, action = _split(one)
        if re.match(r"(sext|zext)\b.* to i64", action):
            found.add(name)
        shifted = re.match(r"(?:ashr|lshr)\b.*\bi64 .*, (\d+)", action)
        if shifted and int(shifted[1]) >= 32:
            found.add(name)
    return found


def _addresses(instructions: Sequence[str]) -> set[str]:
    """Values of 64 bits that nothing but addresses are made of."""
    made = re.compile(r"(sext|zext|add|sub|mul|shl|or|phi)\b.*\bi64\b")
    split = [_split(one) for one in instructions]
    candidates = {name for name, action in split if name and made.match(action)}
    while True:
        outside: set[str] = set()
        for name, action in split:
            if action.startswith("getelementptr") or name in candidates:
                continue
            outside |= candidates & set(NAMES.findall(action))
        if not outside:
            return candidates
        candidates -= outside
