"""A bound of the stack that a function of a linked image takes, from its instructions.

All instructions that a function can reach are followed, with how far the stack pointer is below its
place at the entry; a call takes what the function takes that is called. So the C library is in the
bound, whose sources say nothing of its stack. What has no bound, as recursion, a call of what a
register holds, or memory of a size found at run time, is an error.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

DISASSEMBLER = "arm-none-eabi-objdump"

MOST_DEPTH = 1 << 20
"""A stack beyond this many bytes grows in a loop."""

SYMBOL = re.compile(r"^([0-9a-f]+) <(.+)>:$")
LINE = re.compile(r"^\s*([0-9a-f]+):\t([^\t]+)(?:\t([^@;]*))?")
CONDITION = "(?:eq|ne|cs|cc|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)"
JUMP = re.compile(rf"^b({CONDITION})?(?:\.[nw])?$")
INTO_A_FUNCTION = re.compile(r"^([0-9a-f]+) <")


class NoBound(Exception):
    """Instructions of which nobody can say how much stack they take."""


@dataclass(frozen=True)
class Instruction:
    """An instruction: where it is, what it does, to what, and where the next one is."""

    address: int
    what: str
    operands: str
    after: int

    @property
    def is_conditional(self) -> bool:
        """Whether it does nothing in some cases."""
        return re.search(rf"{CONDITION}(?:\.[nw])?$", self.what) is not None and not re.match(
            r"(?:b|vpush|teq|movs|muls|lsls|bics)(?:\.[nw])?$", self.what
        )


@dataclass
class Image:
    """The instructions of an image by address, the addresses of its functions, and its data."""

    instructions: dict[int, Instruction] = field(default_factory=dict)
    symbols: dict[str, int] = field(default_factory=dict)
    data: dict[int, tuple[int, int]] = field(default_factory=dict)
    bounds: dict[int, int] = field(default_factory=dict)
    open: list[int] = field(default_factory=list)

    def bound(self, name: str) -> int:
        """Return the most bytes of stack that a function takes with all that it calls.

        Raises
        ------
        NoBound
            If there is none.
        """
        return self._bound(self.symbols[name])

    def own(self, name: str) -> int:
        """Return the most bytes of stack that a function takes without what it calls."""
        entry = self.symbols[name]
        end = min((at for at in self.symbols.values() if at > entry), default=entry + MOST_DEPTH)
        depths = self._depths(entry).items()
        return max(depth for address, depth in depths if entry <= address < end)

    def _bound(self, entry: int) -> int:
        if entry in self.open:
            raise NoBound(f"{self._name(entry)} calls itself")
        if entry not in self.bounds:
            self.open.append(entry)
            most = max(self._depths(entry).values())
            for depth, called in self._calls(entry):
                most = max(most, depth + self._bound(called))
            self.open.pop()
            self.bounds[entry] = most
        return self.bounds[entry]

    def _calls(self, entry: int) -> Iterator[tuple[int, int]]:
        """Yield depth and entry of all calls that a function can reach."""
        for address, depth in self._depths(entry).items():
            one = self.instructions[address]
            if one.what in ("bl", "bl.n", "bl.w"):
                yield depth, _target(one)
            elif one.what.startswith("blx"):
                raise NoBound(f"{self._name(entry)} calls what a register holds")

    def _depths(self, entry: int) -> dict[int, int]:
        """Return the most bytes between the stack pointer and its place at the entry.

        Before and after each instruction that can be reached, the larger of both.
        """
        before, most, waiting = {entry: 0}, {}, [entry]
        while waiting:
            one = self.instructions[waiting.pop()]
            depth = before[one.address]
            behind = depth + _moved(one)
            most[one.address] = max(depth, behind)
            if behind > MOST_DEPTH:
                raise NoBound(f"{self._name(entry)} takes more and more stack in a loop")
            if one.is_conditional:
                behind = max(depth, behind)
            for address in self._next(one):
                if behind > before.get(address, -1):
                    before[address] = behind
                    waiting.append(address)
        return most

    def _next(self, one: Instruction) -> list[int]:
        """Return the addresses of the instructions that can follow one."""
        jump = JUMP.match(one.what)
        if jump:
            return [_target(one), *([one.after] if jump[1] else [])]
        if one.what in ("cbz", "cbnz"):
            return [_target(one), one.after]
        if one.what in ("tbb", "tbh"):
            return self._of_a_table(one)
        returns = one.what.startswith("bx") or re.search(r"\bpc\}|^pc\b", one.operands)
        if returns and one.what.startswith("bx") and one.operands.strip() != "lr":
            raise NoBound(f"{one.address:x}: it goes where {one.operands} says")
        if returns and "pop" not in one.what and not one.what.startswith(("bx", "ldmia", "ldr")):
            raise NoBound(f"{one.address:x}: {one.what} {one.operands}")
        return [] if returns and not one.is_conditional else [one.after]

    def _of_a_table(self, one: Instruction) -> list[int]:
        """Return where a jump by a table of bytes or halves goes: the data behind it."""
        width, address, found = 1 if one.what == "tbb" else 2, one.address + 4, []
        numbers = bytearray()
        while address + len(numbers) in self.data:
            number, size = self.data[address + len(numbers)]
            numbers += number.to_bytes(size, "little")
        for start in range(0, len(numbers) - width + 1, width):
            steps = int.from_bytes(numbers[start : start + width], "little")
            found.append(address + 2 * steps)
        # Behind the last entry may be a byte that fills up.
        return [target for target in found if target in self.instructions]

    def _name(self, entry: int) -> str:
        return next(name for name, address in self.symbols.items() if address == entry)


def read(image: Path) -> Image:
    """Return the instructions of an image."""
    said = subprocess.run(
        [DISASSEMBLER, "-d", "--no-show-raw-insn", str(image)],
        capture_output=True,
        encoding="utf-8",
        check=True,
    ).stdout
    found, lines = Image(), []
    for line in said.splitlines():
        if symbol := SYMBOL.match(line):
            found.symbols[symbol[2]] = int(symbol[1], 16)
        elif match := LINE.match(line):
            lines.append((int(match[1], 16), match[2].strip(), (match[3] or "").strip()))
    sizes = {".byte": 1, ".short": 2, ".word": 4}
    for (address, what, operands), after in zip(lines, [*lines[1:], lines[-1]], strict=True):
        if what in sizes:
            found.data[address] = int(operands, 0), sizes[what]
        else:
            found.instructions[address] = Instruction(address, what, operands, after[0])
    return found


def _target(one: Instruction) -> int:
    """Return the address that a jump or a call goes to, the last of its operands."""
    match = INTO_A_FUNCTION.match(one.operands.rpartition(", ")[2])
    if match is None:
        raise NoBound(f"{one.address:x}: {one.what} {one.operands}")
    return int(match[1], 16)


def _moved(one: Instruction) -> int:
    """Return by how many bytes an instruction moves the stack pointer down."""
    what, operands = one.what, one.operands
    if re.match(r"v?push", what):
        return _bytes(operands)
    if re.match(r"v?pop", what):
        return -_bytes(operands)
    if match := re.match(r"sp!, (\{.*\})", operands):
        return _bytes(match[1]) * (1 if "db" in what else -1)
    if match := re.search(r"\[sp, #-(\d+)\]!", operands):
        return int(match[1])
    if match := re.search(r"\[sp\], #(\d+)", operands):
        return -int(match[1])
    match = re.match(r"sp, (?:sp, )?#(\d+)$", operands)
    if match and what.startswith(("add", "sub")):
        return int(match[1]) * (1 if what.startswith("sub") else -1)
    if re.match(r"sp\b", operands) and not what.startswith(("cmp", "cmn", "tst")):
        raise NoBound(f"{one.address:x}: {what} {operands}")
    return 0


def _bytes(registers: str) -> int:
    """Return the bytes of a list of registers, {r4, r5, lr} or {d8-d11}."""
    total = 0
    for part in registers.strip("{} ").split(", "):
        first, _, last = part.partition("-")
        count = int(last[1:]) - int(first[1:]) + 1 if last else 1
        total += count * (8 if part[0] == "d" else 4)
    return total
