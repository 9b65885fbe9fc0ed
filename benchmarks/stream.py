"""What streaming costs: exactness against waiting, processor time for each frame, and a run by the clock.

    python benchmarks/stream.py look-ahead work/natural/ljspeech    phones: error against seconds waited
    python benchmarks/stream.py ahead                               sound: networks that read so far ahead
    python benchmarks/stream.py cost work/cnn work/tcn              processor time, one frame at a time
    python benchmarks/stream.py int8 work/cnn work/tcn              weights of 8 bits
    python benchmarks/stream.py realtime --seconds 60               frames that leave when they fall due

`ahead` trains the networks of benchmarks/configs/cnn.toml and tcn.toml for 15 epochs each, a minute of the
processor; its scores are of the validation clips.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Thread

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.motion import predict_controls
from phonanim.animation.rates import frame_count
from phonanim.corpus.corpus import load_corpus
from phonanim.encoders import RATE
from phonanim.inputs.alignment import read_alignment
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.regressors._streaming import Streamed
from phonanim.speech.alignment import Interval
from phonanim.speech.language import to_phones
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import Samples
from phonanim.stream.sinks import Stage, open_named
from phonanim.stream.sound import SoundStream, streamable
from phonanim.training.recipe import read_recipe
from phonanim.training.recipes import fit_recipe

ROOT = Path(__file__).resolve().parent.parent
LINE = ROOT / "examples" / "line.TextGrid"
LOOKS = (None, 0.5, 0.3, 0.2, 0.1, 0.05)
LINES = 20
FPS = 60.0
EPOCHS = 15  # of each network that is compared; the recipes have more
# What the machine itself does to a program that should wake up for every frame.
SLEEPER = """
import json, sys, time
start, late = time.monotonic() + 0.5, []
for n in range(int(float(sys.argv[1]) * 60)):
    time.sleep(max(0.0, start + n / 60 - time.monotonic()))
    late.append(time.monotonic() - start - n / 60)
print(json.dumps(late))
"""
OPTIONS, SPEECH = Options(language="english"), Options(language="english", life=0)  # with life, and alone


def streamed(intervals: tuple[Interval, ...], look_ahead: float | None) -> NDArray[np.float32]:
    """Frames of a line whose phones come one by one."""
    stream = PhoneStream(SPEECH, look_ahead)
    found = []
    for interval in intervals:
        stream.push(interval.label, interval.start, interval.end)
        found.append(stream.frames())
    stream.end()
    return np.concatenate([*found, stream.frames()])


def look_ahead(folder: Path) -> None:
    """Root mean square of what a stream leaves of the whole line, in controls and in their motion."""
    model, rig = load_model(SPEECH.model), load_cached_rig(SPEECH.rig)
    errors: dict[float | None, list[NDArray[np.float32]]] = {look: [] for look in LOOKS}
    moved = []
    for path in sorted(folder.rglob("*.TextGrid"))[:LINES]:
        alignment = read_alignment(path)
        track, _ = to_phones(alignment, "english")
        whole = predict_controls(track, model, rig, SPEECH, frame_count(track.duration, FPS))[1]
        moved.append(whole - whole.mean(axis=0))
        for look, found in errors.items():
            made = streamed(alignment.intervals, look)
            shared = min(len(made), len(whole))
            found.append(made[:shared] - whole[:shared])
    motion = rms(moved)
    jaw = rig.controls.index("jawOpen")
    print(f"{len(moved)} lines, {sum(map(len, moved)) / FPS:.0f} s; motion itself has {motion:.4f}")
    print("look-ahead     rms  of the motion  jawOpen  99 % within")
    for look, found in errors.items():
        name = "exact" if look is None else f"{look:g} s"
        share, opening = 100 * rms(found) / motion, rms([part[:, jaw] for part in found])
        most = np.quantile(np.abs(np.concatenate(found)), 0.99)
        print(f"{name:>10} {rms(found):7.4f} {share:14.1f} % {opening:8.4f} {most:12.4f}")


def rms(parts: list[NDArray[np.float32]]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def ahead() -> None:
    """Networks of convolutions that read more or less ahead."""
    variants = [("cnn", steps, 0.004) for steps in (0, 3, 7, 11)]
    variants += [("cnn", 7, 0.0), ("tcn", 0, 0.0)]
    print("kind  steps ahead    ctc  look-ahead  vertex error  aperture r  width r  processor")
    for kind, steps, ctc in variants:
        config = ROOT / "benchmarks" / "configs" / f"{kind}.toml"
        recipe = read_recipe(config)
        recipe = replace(
            recipe, settings={**(recipe.settings or {}), "ahead": steps, "ctc": ctc, "epochs": EPOCHS}
        )
        corpus = load_corpus(config.parent / recipe.corpus)
        began = time.process_time()
        model = fit_recipe(recipe, corpus, corpus.clips_of("train"), recipe.seed, config)
        spent = time.process_time() - began
        assert isinstance(model.regressor, Streamed)
        error, aperture, width = model.card["provenance"]["scores"].values()
        print(
            f"{kind:>4} {steps:12d} {ctc:6g} {1000 * model.regressor.look_ahead:8.0f} ms {error:10.3f} mm"
            f" {aperture:11.3f} {width:8.3f} {spent:8.0f} s",
            flush=True,
        )


def cost(models: list[Path]) -> None:
    """Processor time of frames that are made one by one."""
    print(f"load average {os.getloadavg()[0]:.1f}; ms of the processor a frame")
    print("made from                     mean   99.9 %")
    report("phones, default model", phone_times())
    for path in models:
        report(f"sound, {path.name}", sound_times(path))
    stage = Stage("arkit", load_cached_rig("arkit").controls, FPS)
    values = np.linspace(0, 1, len(stage.controls)).astype(np.float32)
    for name in ("livelink", "osc", "vmc"):
        sink = open_named(name, stage)
        report(f"sent to {name}", clocked(lambda n, sink=sink: sink.send(n, n / FPS, values), 1000))


def clocked(work: object, count: int) -> NDArray[np.float64]:
    """Milliseconds of the processor that each of many calls takes."""
    times = []
    for number in range(count):
        began = time.thread_time()
        work(number)  # type: ignore[operator]
        times.append(time.thread_time() - began)
    return 1000 * np.array(times)


def report(name: str, times: NDArray[np.float64]) -> None:
    print(f"{name:25} {times.mean():8.3f} {np.quantile(times, 0.999):8.3f}")


def phone_times() -> NDArray[np.float64]:
    stream = PhoneStream(OPTIONS, 0.2)
    stream.warm_up()
    phones = spoken(30.0)

    def one(number: int) -> None:
        while phones and phones[0].end <= number / FPS + 0.2:
            phone = phones.pop(0)
            stream.push(phone.label, phone.start, phone.end)
        stream.pass_time(number / FPS + 0.2)
        assert len(stream.frames()) == 1

    return clocked(one, round(30 * FPS))


def sound_times(path: Path) -> NDArray[np.float64]:
    """A frame's sound, 1/60 s, encoded and shown."""
    stream = SoundStream(Options(model=str(path)))
    stream.warm_up()
    size = round(RATE / FPS)
    noise = np.random.default_rng(0).normal(0, 0.1, 1800 * size).astype(np.float32)

    def one(number: int) -> None:
        stream.take(Samples(noise[number * size : (number + 1) * size]))
        stream.frames()

    return clocked(one, 1800)


def spoken(seconds: float) -> list[Interval]:
    """The phones of the example line, as often as it takes."""
    line = read_alignment(LINE)
    return [
        Interval(phone.label, phone.start + n * line.duration, phone.end + n * line.duration)
        for n in range(round(seconds // line.duration) + 1)
        for phone in line.intervals
        if phone.end + n * line.duration <= seconds
    ]


def int8(models: list[Path]) -> None:
    """Weights of 8 bits, a scale for each output: what is lost, and whether NumPy gains from them."""
    for path in models:
        regressor = streamable(load_model(str(path)).regressor, str(path))
        rng = np.random.default_rng(0)
        values = rng.normal(regressor.centre, 1 / regressor.scale, (2000, *regressor.centre.shape))
        small = {n: np.multiply(*rounded(part)) for n, part in regressor.weights.items()}
        features = values.astype(np.float32)
        apart = np.abs(replace(regressor, weights=small).step(features) - regressor.step(features))
        size = sum(part.size for part in regressor.weights.values())
        print(f"{path.name}: {4 * size / 1e3:.0f} kB as float32, {size / 1e3:.0f} kB as int8")
        print(f"  modes move by {apart.mean():.3f} mm, at most {apart.max():.3f} mm")
        products(regressor, features)


def products(regressor: Streamed, features: NDArray[np.float32]) -> None:
    """Milliseconds of one step, and of its largest product in floats and in whole numbers."""
    field = features[: regressor.receptive_field]
    kernel = max(regressor.weights.values(), key=lambda part: part.size)
    flat = kernel.reshape(-1, kernel.shape[-1])
    whole = rounded(flat)[0]
    row = np.ones((1, len(flat)))
    step = np.median(clocked(lambda n: regressor.step(field), 300))
    print(f"  one step of all layers: {step:.3f} ms as float32")
    for name, kind in (("float32", np.float32), ("int8, summed in 32 bits", np.int32)):
        left, right = row.astype(kind), whole.astype(kind)
        spent = np.median(clocked(lambda n, left=left, right=right: left @ right, 500))
        print(f"  its largest product: {spent:.4f} ms as {name}")


def rounded(weights: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Whole numbers in -127..127 and their scale for each output; vectors stay as they are."""
    if weights.ndim < 2:
        return weights, np.float32(1)  # type: ignore[return-value]
    scale = np.abs(weights).max(axis=tuple(range(weights.ndim - 1)), keepdims=True) / 127
    return np.rint(weights / scale), scale.astype(np.float32)


def realtime(seconds: float, delay: float) -> None:
    """Phones are told when they end, as a recognizer would; frames are timed where they arrive."""
    command = [sys.executable, str(ROOT / "cli.py"), "stream", "--realtime", "--json"]
    command += ["--look-ahead", str(delay)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin
    assert process.stdout
    process.stdout.readline()
    time.sleep(3)
    sleeper = subprocess.Popen([sys.executable, "-c", SLEEPER, str(seconds)], stdout=subprocess.PIPE)
    start = time.monotonic()
    Thread(target=tell, args=(process.stdin, start, seconds), daemon=True).start()
    came = []
    for line in process.stdout:
        told = json.loads(line)
        if "frame" in told:
            came.append((told["time"], time.monotonic() - start))
        elif told["event"] == "end":
            print(told)
    times, arrived = np.array(came).T
    latency = 1000 * (arrived - times)
    lateness = latency - np.median(latency)
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; {len(came)} frames")
    print("latency of frames behind their time, ms: " + quantiles(latency))
    print("apart from the median, ms: " + quantiles(lateness))
    print(f"later than a frame: {(lateness > 1000 / FPS).sum()}")
    woke = 1000 * np.array(json.loads(sleeper.communicate()[0]))
    print("a program that only sleeps, beside it, wakes late by, ms: " + quantiles(woke))
    print(f"later than a frame: {(woke > 1000 / FPS).sum()}")


def tell(stdin: Iterator[bytes], start: float, seconds: float) -> None:
    """Write each phone when it ends."""
    events = [(0.0, {"time": 0.001})]
    events += [(p.end, {"phone": p.label, "start": p.start, "end": p.end}) for p in spoken(seconds)]
    for at, event in [*events, (seconds, {"end": True})]:
        time.sleep(max(0.0, start + at - time.monotonic()))
        stdin.write(json.dumps(event).encode() + b"\n")  # type: ignore[attr-defined]
        stdin.flush()  # type: ignore[attr-defined]


def quantiles(values: NDArray[np.float64]) -> str:
    found = np.quantile(values, [0, 0.5, 0.99, 0.999, 1])
    return "least {:.1f}, median {:.1f}, 99 % {:.1f}, 99.9 % {:.1f}, most {:.1f}".format(*found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parts = parser.add_subparsers(dest="part", required=True)
    parts.add_parser("look-ahead").add_argument("folder", type=Path)
    parts.add_parser("ahead")
    parts.add_parser("cost").add_argument("models", type=Path, nargs="*")
    parts.add_parser("int8").add_argument("models", type=Path, nargs="+")
    run = parts.add_parser("realtime")
    run.add_argument("--seconds", type=float, default=60.0)
    run.add_argument("--delay", type=float, default=0.2)
    given = vars(parser.parse_args())
    {"look-ahead": look_ahead, "ahead": ahead, "cost": cost, "int8": int8, "realtime": realtime}[
        given.pop("part")
    ](**given)


if __name__ == "__main__":
    main()
