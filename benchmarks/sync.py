"""What it costs that a batch puts its outputs and its ledger on the disk at checkpoints.

    python benchmarks/sync.py [FOLDER]

Records 500 lines with outputs of 250 kB in a folder (by default, a temporary one), as a batch does: without
any fsync, with one checkpoint for all lines, and with one after each line. Prints milliseconds a line, by the
clock and of processor time, the best of three runs. A disk with a cache that survives a power loss is faster.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path
from unittest import mock

from phonanim.dubbing import ledger
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.stamps import OUTPUTS, stamp_outputs

LINES, SIZE, TRIES = 500, 250_000, 3
FACTS = {"frames": 360, "seconds": 6.0, "phones": 60, "flags": []}


def record(folder: Path, period: float) -> tuple[float, float]:
    """Milliseconds a line to write outputs and to record them, by the clock and of the processor."""
    data = os.urandom(SIZE)
    began, used = time.perf_counter(), time.process_time()
    with mock.patch.object(ledger, "PERIOD", period), ledger.ledger_writer(folder) as add:
        for number in range(LINES):
            name = f"{number:04}.csv"
            (folder / name).write_bytes(data)
            stamps = {OUTPUTS: stamp_outputs([name], folder)}
            add(Outcome(name, name, {"options": {}}, {name: "0" * 64}, FACTS, stamps=stamps))
    return tuple(1000 * cost / LINES for cost in (time.perf_counter() - began, time.process_time() - used))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("folder", type=Path, nargs="?", metavar="FOLDER")
    place = options.parse_args().folder
    ways = {"no fsync": (60.0, False), "one checkpoint": (60.0, True), "after each line": (0.0, True)}
    print(f"{'':18}{'by the clock':>14}{'processor':>12}   ms a line")
    for name, (period, synced) in ways.items():
        runs = []
        for _ in range(TRIES):
            with tempfile.TemporaryDirectory(dir=place) as folder:
                if synced:
                    runs.append(record(Path(folder), period))
                else:
                    with mock.patch("os.fsync"):
                        runs.append(record(Path(folder), period))
        wall, processor = (min(column) for column in zip(*runs, strict=True))
        print(f"{name:18}{wall:14.2f}{processor:12.2f}")


if __name__ == "__main__":
    main()
