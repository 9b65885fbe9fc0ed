"""Write the tables of docs/language_tables.md: the languages, and the phones of every IPA symbol and mark.

python scripts/write_language_tables.py
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from phonanim.speech.inventory import LEXICON  # noqa: E402
from phonanim.speech.ipa import Articulation, ipa_symbols  # noqa: E402
from phonanim.speech.language_files import load_language  # noqa: E402
from phonanim.speech.language_names import language_names  # noqa: E402
from phonanim.speech.visible_phones import constriction, lip_closure, lip_spread, to_visible_phones  # noqa: E402

PAGE = ROOT / "docs" / "language_tables.md"
START = "<!-- tables: written by scripts/write_language_tables.py -->"

COMBINED = (
    *(
        "tʃ",
        "dʒ",
        "ts",
        "tɕ",
        "ʈʂ",
        "pf",
        "kx",
        "tɬ",
        "k͡p",
        "ɡ͡b",
        "ŋ͡m",
        "ᵐb",
        "nd",
        "kʷ",
        "pʲ",
        "tʼ",
        "n̩",
        "z̩",
    ),
    *(
        "ɑ̃",
        "œ̃",
        "aɪ",
        "aʊ",
        "ɔɪ",
        "eɪ",
        "oʊ",
        "əʊ",
        "œy",
        "iə",
        "ja",
        "wai",
        "iau",
        "ɑ˞",
        "ɯᵝ",
        "a˥˩",
        "tsʰ",
        "r̝",
    ),
)


def tables() -> str:
    """All tables as Markdown."""
    parts = [START, "", "## Languages", "", languages(), "", "## Every IPA symbol", "", symbol_table()]
    parts += ["", "## Several symbols in one label", "", combined(), "", "## Every mark", "", marks(), ""]
    return "\n".join(parts)


def languages() -> str:
    """One row a language: its code, its alphabets, and how many labels of which aligner are listed."""
    rows = []
    for language in map(load_language, language_names()):
        listed = ", ".join(f"{aligner} {len(labels)}" for aligner, labels in language.labels.items())
        own = len(language.phones) + len(language.ipa) + len(language.closures)
        alphabets = ", ".join(language.alphabets)
        rows.append([f"`{language.name}`", language.code, language.title, alphabets, str(own), listed])
    return table(["language", "code", "title", "alphabets", "own labels", "labels of aligners"], rows)


def symbol_table() -> str:
    """One row a symbol: its phone and what of it is seen."""
    rows = [
        [symbol, sound.name, " ".join(to_visible_phones(symbol)), why(sound)]
        for symbol, sound in ipa_symbols().items()
    ]
    return table(["IPA", "sound", "phones", "visible features"], rows)


def combined() -> str:
    """One row an example."""
    return table(["label", "phones"], [[label, " ".join(to_visible_phones(label))] for label in COMBINED])


def marks() -> str:
    """One row a mark: what it changes and why."""
    with (LEXICON / "ipa_marks.csv").open(encoding="utf-8", newline="") as file:
        rows = [
            ["◌" + row["mark"], effect(row["effect"], row["value"]), row["why"]]
            for row in csv.DictReader(file)
        ]
    return table(["mark", "effect", "why"], rows)


def effect(name: str, value: str) -> str:
    """What a mark does, in words."""
    if name in ("none", "central"):
        return {"none": "not visible", "central": "backness towards the middle"}[name]
    return f"then {value}" if name == "then" else f"{name} {value}"


def why(sound: Articulation) -> str:
    """What a camera sees of a sound."""
    if sound.vowel:
        jaw = "jaw closed" if sound.height >= 0.8 else "jaw half open" if sound.height >= 0.3 else "jaw open"
        drawn = (
            "lips spread" if lip_spread(sound.height, sound.backness, sound.rounding) > 0.3 else "lips slack"
        )
        return f"{'lips rounded' if sound.rounding >= 0.4 else drawn}, {jaw}"
    closed = {1.0: "lips shut", 0.6: "teeth on the lip", 0.5: "lips nearly shut"}.get(lip_closure(sound), "")
    parts = [closed, "lips rounded" if sound.rounding >= 0.4 else "", "" if closed else tongue(sound)]
    return ", ".join(part for part in parts if part)


def tongue(sound: Articulation) -> str:
    """What the tongue shows between open lips."""
    if sound.place in ("pharyngeal", "glottal") or (sound.place == "uvular" and constriction(sound) < 1):
        return "made in the throat: the shape of the neighbours"
    teeth = "teeth together, " if sound.manner == "sibilant" else ""
    spread = ", lips spread" if sound.place == "palatal" else ""
    closed = {1.0: "tongue closes", 0.5: "tongue half closes"}.get(constriction(sound), "tongue near")
    return f"{teeth}{closed}: {sound.place}{spread}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


if __name__ == "__main__":
    text = PAGE.read_text("utf-8")
    PAGE.write_text(text[: text.index(START)] + tables(), "utf-8")
