"""Made-up recordings of sensors in the layouts of their machines and programs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.ema import Articulation

Array = NDArray[np.float64]


def ssff(path: Path, columns: dict[str, Array], rate: float = 200.0, start: float = 0.0) -> None:
    """One file of EMU: float columns."""
    lines = ["SSFF -- (c) SHLRC", "Machine IBM-PC", f"Record_Freq {rate}", f"Start_Time {start}"]
    lines += [f"Column {name} FLOAT 1" for name in columns] + ["-" * 17]
    table = np.column_stack(list(columns.values())).astype("<f4")
    path.write_bytes(("\n".join(lines) + "\n").encode() + table.tobytes())


def sensor_columns(prefix: str, positions: Array) -> dict[str, Array]:
    """Position and orientation of a sensor, six columns."""
    named = {f"{prefix}_pos{axis}": column for axis, column in zip("xyz", positions.T, strict=True)}
    return named | {f"{prefix}_ori{axis}": np.ones(len(positions)) for axis in "xyz"}


def pos(path: Path, positions: Array, rate: int = 250, header: bool = True) -> None:
    """A file of Carstens: the AG501's with a header, the AG500's without; (samples, channels, 3)."""
    samples, channels, _ = positions.shape
    table = np.zeros((samples, channels, 7), "<f4")
    table[..., :3], table[..., 3:] = positions, (10, 20, 1.5, 0)
    fields = f"NumberOfChannels={channels}\nSamplingFrequencyHz={rate}\n\0\x1a"
    size = len("AG50xDATA_V002\n00000000\n") + len(fields)
    head = f"AG50xDATA_V002\n{size:08d}\n{fields}".encode() if header else b""
    path.write_bytes(head + table.tobytes())


def still(*points: tuple[float, float, float], names: str, samples: int = 10) -> Articulation:
    """Sensors that rest, at 100 Hz."""
    positions = np.tile(np.array(points, float), (samples, 1, 1))
    return Articulation(tuple(names.split()), positions, 100.0, source="made up")


def bundle(path: Path, *intervals: tuple[float, float, str], rate: int = 16000) -> None:
    """The labels of an EMU bundle: one level of segments."""
    items = [
        {
            "id": number,
            "sampleStart": round(start * rate),
            "sampleDur": round((end - start) * rate) - 1,
            "labels": [{"name": "Segment", "value": label}],
        }
        for number, (start, end, label) in enumerate(intervals, start=1)
    ]
    level = {"name": "Segment", "type": "SEGMENT", "items": items}
    annotation = {"name": path.stem, "annotates": "", "sampleRate": rate, "levels": [level], "links": []}
    path.write_text(json.dumps({"ssffFiles": [], "annotation": annotation}), "utf-8")


def textgrid(path: Path, *intervals: tuple[float, float, str]) -> None:
    """A phone tier."""
    rows = "".join(f'{start}\n{end}\n"{label}"\n' for start, end, label in intervals)
    head = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n'
    tier = f'1\n"IntervalTier"\n"phones"\n0\n{intervals[-1][1]}\n{len(intervals)}\n'
    path.write_text(f"{head}0\n{intervals[-1][1]}\n<exists>\n{tier}{rows}")
