"""What writing costs: a line of 60 s with its sound, from a cold start to every format, and films.

    python benchmarks/output.py [SUFFIX ...]

Wall and processor seconds are each the best of several runs; where a machine is busy, compare the second.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
import wave
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from animate import lengthened

from phonanim.exporters import save
from phonanim.exporters.mp4 import FASTEST
from phonanim.pipeline import animate

ROOT = Path(__file__).resolve().parent.parent
SECONDS, TRIES = 60.0, 5
SUFFIXES = ("npz", "csv", "json", "glb", "html", "usda", "usdc", "anim", "track.json", "tsv", "png")
RATE = 16000  # hertz


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock and of the processor."""

    wall: float
    cpu: float


def timed(command: list[str]) -> Cost:
    """The cost of a process."""
    before, started = os.times(), time.perf_counter()
    if os.spawnv(os.P_WAIT, command[0], command):
        sys.exit(f"failed: {' '.join(command)}")
    wall, after = time.perf_counter() - started, os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return Cost(wall, cpu)


def best(command: list[str]) -> Cost:
    """The least of several runs, each of wall and processor time by itself."""
    costs = [timed(command) for _ in range(TRIES)]
    return Cost(min(cost.wall for cost in costs), min(cost.cpu for cost in costs))


def silence(path: Path) -> Path:
    """A recording of nothing as long as the line: what it weighs in a page."""
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, RATE, 0, "NONE", ""))
        file.writeframes(bytes(2 * RATE * int(SECONDS)))
    return path


def film(line: Path, folder: Path) -> tuple[Cost, float]:
    """The cost of a film of 512 x 512 pixels, and its frames per second of wall time."""
    animation = animate(line)
    started, cpu = time.perf_counter(), time.process_time()
    save(animation, folder / "a.mp4")
    cost = Cost(time.perf_counter() - started, time.process_time() - cpu)
    return cost, float(animation.times[-1]) * FASTEST / cost.wall


def main() -> None:
    """Print one table row per format, then the film."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("suffixes", nargs="*", metavar="SUFFIX", default=[*SUFFIXES, "mp4"])
    suffixes = options.parse_args().suffixes
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        line, sound = lengthened(SECONDS, folder), silence(folder / "a.wav")
        print("| suffix | wall | processor | size |\n|---|---|---|---|")
        for suffix in [suffix for suffix in suffixes if suffix != "mp4"]:
            path = folder / f"a.{suffix}"
            command = [sys.executable, str(ROOT / "cli.py"), "animate", str(line), "--audio", str(sound)]
            cost = best([*command, "-o", str(path), "-q"])
            size = path.stat().st_size / 1e6
            print(f"| {suffix} | {cost.wall:.2f} s | {cost.cpu:.2f} s | {size:.1f} MB |", flush=True)
        if "mp4" in suffixes:
            cost, rate = film(lengthened(5.0, folder), folder)
            print(f"\nfilm: {rate:.0f} frames/s, {rate * cost.wall / cost.cpu:.0f} per processor second")


if __name__ == "__main__":
    main()
