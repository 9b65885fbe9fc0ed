"""What animating costs: start, memory, frames per second, and growth with length.

    python benchmarks/animate.py            one figure for each step
    python benchmarks/animate.py --long     processor time and memory of lines of hours, to CSV
    python benchmarks/animate.py --formats  the same of the longest line that needs no option, in every format

Makes its lines from examples/line.TextGrid, repeated. Each figure is the best of several runs.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from phonanim.animation.rates import frame_count
from phonanim.articulation.blend import blend_articulation
from phonanim.exporters import suffixes
from phonanim.face import contacts
from phonanim.inputs.alignment import read_alignment
from phonanim.life import add_life, life_of, mouth_freedom
from phonanim.options import DEFAULTS
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.rig.retarget import retarget
from phonanim.speech.alignment import Interval
from phonanim.speech.language import to_phones
from phonanim.speech.prosody import read_prosody
from phonanim.speech.textgrid import write_textgrid

ROOT = Path(__file__).resolve().parent.parent
LINE = ROOT / "examples" / "line.TextGrid"
TRIES = 5
FPS = 60.0
PICTURES = (".mp4", ".png", ".vrm")  # .vrm needs a character
RIGS = {".dat": "preston_blair", ".tsv": "rhubarb", ".rhubarb.json": "rhubarb", ".vrma": "vrm", ".vmd": "vrm"}
LONG = ((3650, 60), (7190, 60), (7190, 240))  # seconds and frames per second


def lengthened(seconds: float, folder: Path) -> Path:
    """An alignment of about `seconds`: the example, as often as it takes."""
    line = read_alignment(LINE)
    times = max(1, round(seconds / line.duration))
    phones = [
        Interval(phone.label, *(round(t + n * line.duration, 6) for t in (phone.start, phone.end)))
        for n in range(times)
        for phone in line.intervals
    ]
    path = folder / f"{seconds:g}.TextGrid"
    write_textgrid(path, {"phones": phones}, times * line.duration)
    return path


def cold_start(folder: Path) -> tuple[float, float]:
    """Seconds and megabytes of `phonanim animate` of the example to CSV, in a process of its own."""
    command = [sys.executable, str(ROOT / "cli.py"), "animate", str(LINE), "-o", str(folder / "a.csv"), "-q"]
    walls = []
    for _ in range(TRIES):
        started = time.perf_counter()
        subprocess.run(command, check=True)
        walls.append(time.perf_counter() - started)
    return min(walls), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def steps(path: Path) -> dict[str, float]:
    """Seconds that each step from alignment to controls takes."""
    model, rig = load_model(DEFAULTS.model), load_cached_rig(DEFAULTS.rig)
    clock = [time.perf_counter()]

    def lap() -> None:
        clock.append(time.perf_counter())

    alignment = read_alignment(path)
    lap()
    track, _ = to_phones(alignment)
    lap()
    modes = model.predict(track, FPS, frame_count(track.duration, FPS))
    lap()
    times = np.arange(len(modes)) / FPS
    modes = contacts.enforce_lip_contacts(modes, track, model.face, times)
    lap()
    lips, closed = contacts.lip_part(model.face)
    mouth = blend_articulation(lips.instance(modes), lips, closed, track, times)
    lap()
    values = retarget(modes, model.face, rig, track=track, times=times, articulation=mouth)
    lap()
    prosody = read_prosody(track, alignment.words)
    add_life(values, rig, life_of(DEFAULTS, path.stem), prosody, times, mouth_freedom(prosody, track, times))
    lap()
    names = ("read", "phones", "predict", "contacts", "articulate", "solve", "life")
    return {name: end - start for name, (start, end) in zip(names, pairwise(clock), strict=True)}


def peak(path: Path) -> float:
    """Megabytes that animating a file to NPZ takes, in a process of its own."""
    process = subprocess.Popen(
        [sys.executable, "cli.py", "animate", str(path), "-o", str(path.with_suffix(".npz")), "-q"], cwd=ROOT
    )
    _, _, usage = os.wait4(process.pid, 0)
    return usage.ru_maxrss / 1024


def long_lines() -> None:
    """Processor seconds and megabytes of lines of hours at several rates."""
    print("seconds   fps   frames   processor s   peak MB      CSV MB")
    with tempfile.TemporaryDirectory() as name:
        for seconds, fps in LONG:
            path = lengthened(seconds, Path(name))
            out = path.with_suffix(".csv")
            words = ["--fps", str(fps), "--most-frames", "10000000"]
            cost, memory, size = whole_command(path, out, words)
            frames = frame_count(read_alignment(path).duration, fps)
            print(f"{seconds:7d} {fps:5d} {frames:8d} {cost:13.1f} {memory:9.0f} {size:11.0f}")


def all_formats() -> None:
    """The same of the first of those lines, in every format but films and plots."""
    print("format              processor s   peak MB     file MB")
    with tempfile.TemporaryDirectory() as name:
        path = lengthened(LONG[0][0], Path(name))
        for suffix in suffixes():
            if suffix in PICTURES:
                continue
            out = path.with_name(f"line{suffix}")
            cost, memory, size = whole_command(path, out, ["--rig", RIGS[suffix]] if suffix in RIGS else [])
            print(f"{suffix:18} {cost:13.1f} {memory:9.0f} {size:11.0f}", flush=True)


def whole_command(path: Path, out: Path, options: list[str]) -> tuple[float, float, float]:
    """Processor seconds and peak MB of `phonanim animate`, and the MB of the file, which is deleted."""
    words = [sys.executable, "cli.py", "animate", str(path), "-o", str(out), "-q", *options]
    process = subprocess.Popen(words, cwd=ROOT)
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0, f"{out.name}: {status}"
    size = out.stat().st_size / 1e6
    out.unlink()
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, size


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--long", action="store_true")
    options.add_argument("--formats", action="store_true")
    chosen = options.parse_args()
    if chosen.long:
        long_lines()
    elif chosen.formats:
        all_formats()
    else:
        each_step()


def each_step() -> None:
    """A cold start, and the seconds of each step for lines of several lengths."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wall, memory = cold_start(folder)
        print(f"a line of 4.5 s to CSV, cold start: {wall:.2f} s, {memory:.0f} MB\n")
        print(
            "seconds   frames    read  phones predict contacts articulate solve    life   frames/s   peak MB"
        )
        for seconds in (10, 60, 600, 3600):
            path = lengthened(seconds, folder)
            runs = [steps(path) for _ in range(TRIES if seconds <= 60 else 2)]
            best = min(runs, key=lambda run: sum(run.values()))
            frames = frame_count(read_alignment(path).duration, FPS)
            rate = frames / sum(value for name, value in best.items() if name != "read")
            laps = "  ".join(f"{value:7.3f}" for value in best.values())
            print(f"{seconds:7d} {frames:8d} {laps} {rate:12.0f} {peak(path):9.0f}")


if __name__ == "__main__":
    main()
