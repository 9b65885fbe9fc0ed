"""The phone table of a rig: natural lines animated, and what its own head shows of each phone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OptionError
from phonanim.metrics.phone_table import Check, Table, check_table, phone_table
from phonanim.options import Options
from phonanim.pipeline import animate_detailed, load_cached_rig
from phonanim.rig import Rig
from phonanim.rig.shown_mouth import SHOWN, TONGUE, show_mouth
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Line = tuple[PhoneTrack, NDArray[np.float64], NDArray[np.float32]]  # instants and values
SUFFIX = ".TextGrid"
USED = 0.1  # of a weight: a shape that never reaches it is not used
FEW = 30  # controls: rigs with no more of them are shapes that add up


def spread_over(folder: Path, count: int) -> list[Path]:
    """At most `count` alignments of a folder, spread over it. Raises OptionError when there are none."""
    paths = sorted(folder.rglob(f"*{SUFFIX}")) if folder.is_dir() else [folder]
    if not paths:
        raise OptionError(f"{folder}: holds no {SUFFIX} files; give a folder of alignments")
    return paths[:: max(1, len(paths) // count)][:count]


def rig_phones(name: str, paths: list[Path]) -> tuple[Table, list[Check], list[str]]:
    """The phone table of a rig over alignments, its checks, and remarks on its weights."""
    rig, lines, weights = load_cached_rig(name), [], []
    for path in paths:
        made = animate_detailed(path, Options(rig=name, life=0.0))
        values = made.animation.values
        times = np.arange(len(values)) / made.animation.fps
        weights.append((made.track, times, values))
        shown = show_mouth(rig, values, made.face) if made.face else None
        if shown is not None:
            lines.append((made.track, times, shown))
    table = phone_table(lines) if lines else {}
    return table, check_table(table), _remarks(rig, weights)


def _remarks(rig: Rig, lines: list[Line]) -> list[str]:
    """What the weights of a rig of few shapes do: their greatest sum, shapes never used, drawn mouths."""
    if rig.articulated or len(rig.controls) > FEW:
        return []
    every = np.concatenate([values for _, _, values in lines])
    unused = [name for name, most in zip(rig.controls, every.max(axis=0), strict=True) if most < USED]
    found = [f"never used: {', '.join(unused)}"] if unused else ["every shape is used"]
    if rig.visemes is not None and rig.visemes.stepped:
        return [*found, _drawn(rig, lines)]
    return [*found, f"sum of the weights: at most {every.sum(axis=1).max():.2f}"]


def _drawn(rig: Rig, lines: list[Line]) -> str:
    """How many phones, and how many closures, show their own drawn mouth at some frame."""
    assert rig.visemes is not None
    shown: list[bool] = []
    closed: list[bool] = []
    for track, times, values in lines:
        for code, begin, end in zip(track.codes, track.bounds[:-1], track.bounds[1:], strict=True):
            near = values[slice(*np.searchsorted(times, (begin, end)))].argmax(axis=1)
            seen = bool(np.isin(near, rig.visemes.of[code]).any())
            (closed if INVENTORY.phones[code] in ("p", "b", "m", "f", "v") else shown).append(seen)
    return f"own mouth shown by {np.mean(shown):.0%} of phones, {np.mean(closed):.0%} of p b m f v"


def table_text(table: Table) -> str:
    """The phone table as a Markdown table."""
    names = [name for name in (*SHOWN, *TONGUE) if any(name in row for row in table.values())]
    lines = [f"| phone | {' | '.join(names)} | closed |", "|---|" + "---:|" * (len(names) + 1)]
    for phone, row in table.items():
        cells = [f"{row[name]:.1f}" if name in row else "" for name in names]
        lines.append(f"| {phone} | {' | '.join(cells)} | {row['closures']:.0%} |")
    return "\n".join(lines)


def checks_text(checks: dict[str, list[Check]]) -> str:
    """The checks of several rigs beside one another, as a Markdown table; what fails is marked."""
    names = list(dict.fromkeys(check.name for found in checks.values() for check in found))
    bars = {check.name: check for found in checks.values() for check in found}
    lines = [f"| check | wanted | {' | '.join(checks)} |", "|---|---|" + "---:|" * len(checks)]
    for name in names:
        cells = []
        for found in checks.values():
            one = next((check for check in found if check.name == name), None)
            cells.append("" if one is None else f"{one.value:.2f}" + ("" if one.passed else " (fails)"))
        bar = f"{'at least' if bars[name].above else 'at most'} {bars[name].bar:g}"
        lines.append(f"| {name} | {bar} | {' | '.join(cells)} |")
    return "\n".join(lines)
