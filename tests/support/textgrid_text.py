"""TextGrid texts, written as Praat and its imitators write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

Entry = tuple[float | str, float | str, str]
Tiers = Sequence[tuple[str, Sequence[Entry]]]

BEAM: list[Entry] = [(0, 0.2, ""), (0.2, 0.3, "B"), (0.3, 0.5, "IY1"), (0.5, 0.6, "M"), (0.6, 1, "sil")]
WORDS: list[Entry] = [(0, 0.2, ""), (0.2, 0.6, "beam"), (0.6, 1, "")]


def quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"'


def long_text(tiers: Tiers, start: float = 0, end: float = 1) -> str:
    lines = [
        'File type = "ooTextFile"',
        'Object class = "TextGrid"',
        "",
        f"xmin = {start} ",
        f"xmax = {end} ",
    ]
    lines += ["tiers? <exists> ", f"size = {len(tiers)} ", "item []: "]
    for number, (name, entries) in enumerate(tiers, 1):
        lines += [
            f"    item [{number}]:",
            '        class = "IntervalTier" ',
            f"        name = {quoted(name)} ",
        ]
        lines += [f"        xmin = {start} ", f"        xmax = {end} "]
        lines += [f"        intervals: size = {len(entries)} "]
        for index, (first, last, label) in enumerate(entries, 1):
            lines += [f"        intervals [{index}]:", f"            xmin = {first} "]
            lines += [f"            xmax = {last} ", f"            text = {quoted(label)} "]
    return "\n".join(lines) + "\n"


def short_text(tiers: Tiers, start: float = 0, end: float = 1) -> str:
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', "", f"{start}", f"{end}", "<exists>"]
    lines += [f"{len(tiers)}"]
    for name, entries in tiers:
        lines += ['"IntervalTier"', quoted(name), f"{start}", f"{end}", f"{len(entries)}"]
        for first, last, label in entries:
            lines += [f"{first}", f"{last}", quoted(label)]
    return "\n".join(lines) + "\n"


def save(folder: Path, text: str, encoding: str = "utf-8", name: str = "a.TextGrid") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path
