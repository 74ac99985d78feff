"""Try many mutants of all readers: ``python -m tests.hostile 50000 [READER ...]``.

A file for each fault goes into ``results/hostile``. Ends with 1 if there are any.
"""

from __future__ import annotations

import argparse
import json
import sys

from tests.hostile.campaign import ROOT, Tally, tried
from tests.hostile.worker import all_readers

FOLDER = ROOT / "results" / "hostile"
"""Where faults are written."""


def _tell(name: str, tally: Tally) -> None:
    """Write the line of a reader, and its faults, each into a file, too."""
    counts = (tally.results[kind] for kind in ("read", "told", "refused"))
    columns = "".join(f"{one:>{width}}" for one, width in zip(counts, (8, 8, 9), strict=True))
    print(
        f"{name:<12}{tally.tried:>8}{columns}{len(tally.faults):>8}{tally.slowest:>8.2f} s",
        flush=True,
    )
    for fault in tally.faults:
        FOLDER.mkdir(parents=True, exist_ok=True)
        path = FOLDER / f"{name}_{fault['number']}.json".replace(" ", "_")
        path.write_text(json.dumps(fault, indent=1), encoding="utf-8")
        print(f"  {fault['number']} {fault.get('what', '')}: {fault['fault'][:300]}", flush=True)


def main() -> int:
    """Try them, and write a table."""
    parser = argparse.ArgumentParser(prog="python -m tests.hostile", description=__doc__)
    parser.add_argument("count", type=int, help="how many mutants, shared by the readers")
    parser.add_argument("readers", nargs="*", help="readers, by default all")
    parser.add_argument("--first", type=int, default=0, help="number of the first one of each")
    given = parser.parse_args()
    names = given.readers or list(all_readers())
    share = -(-given.count // len(names))
    shares = {name: range(given.first, given.first + share) for name in names}
    print(f"{'reader':<12}{'tried':>8}{'read':>8}{'told':>8}{'refused':>9}{'faults':>8}  slowest")
    report = tried(shares, done=_tell)
    total = sum(tally.tried for tally in report.tallies.values())
    print(f"{total} mutants, {len(report.faults)} faults, {report.grown / 2**20:.0f} MiB more")
    return 1 if report.faults else 0


if __name__ == "__main__":
    sys.exit(main())
