"""Files whose bytes are changed at random, whatever they hold."""

from __future__ import annotations

import numpy as np

from tests.hostile.mutant import Mutant


def damaged(content: bytes, rng: np.random.Generator, claim: str = "") -> Mutant:
    """Return a file with bytes changed, lost, doubled or added."""
    size = len(content)
    begin, end = sorted(int(one) for one in rng.integers(size + 1, size=2))
    short = min(end, begin + int(rng.integers(1, 40)))
    junk = rng.integers(256, size=int(rng.integers(1, 9)), dtype=np.uint8).tobytes()
    changes = {
        "bits": _flipped(content, rng),
        "bytes": _replaced(content, rng),
        "cut": content[:begin],
        "begun late": content[begin:],
        "hole": content[:begin] + content[short:],
        "doubled": content[:short] + content[begin:],
        "junk": content[:begin] + junk + content[begin:],
        "zeros": content[:begin] + bytes(short - begin) + content[short:],
        "swapped": content[:begin] + content[short:end] + content[begin:short] + content[end:],
        "twice": content + content,
        "zeros behind": content + bytes(7),
        "junk behind": content + junk,
        "nothing": b"",
        "UTF-16": content.decode("utf-8", "replace").encode("utf-16"),
        "surrogate": content[:begin] + b"\xed\xa0\x80" + content[begin:],
        "zero byte": content[:begin] + b"\0" + content[begin:],
    }
    what = list(changes)[int(rng.integers(len(changes)))]
    return Mutant(
        0, what, changes[what], claim if what in ("bits", "bytes", "zeros", "cut") else ""
    )


def _flipped(content: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 4))):
        changed[int(rng.integers(len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _replaced(content: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 4))):
        changed[int(rng.integers(len(changed)))] = int(rng.integers(256))
    return bytes(changed)
