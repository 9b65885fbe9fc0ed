"""`phonanim info`: list what is installed, what a language covers, what an alignment holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options

if TYPE_CHECKING:
    from phonanim.speech.language import Language


@click.command()
@click.argument("alignment", required=False, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--language",
    help="Print the phones of each label of a language; with a file, read the file as that language.",
)
@click.option("--tier", help="Phone tier of the file, by name or number.")
@click.option("--speaker", help="Speaker whose tiers to read, in a file of several speakers.")
@click.option(
    "--lexicon",
    type=click.Path(exists=True, dir_okay=False),
    help="Pronunciation dictionary, for a file that has words only.",
)
@console_options
def command(
    alignment: Path | None,
    language: str | None,
    tier: str | None,
    speaker: str | None,
    lexicon: str | None,
    console: Console,
) -> None:
    """List what phonanim supports, or describe an alignment.

    \b
    Examples:
      phonanim info
      phonanim info --language german
      phonanim info line.TextGrid
      phonanim info line.TextGrid --tier phones --json
    """
    if alignment:
        facts = describe_alignment(alignment, language or "auto", tier, speaker, lexicon)
    elif language:
        facts = language_coverage(language)
    else:
        facts = list_resources()
    console.print_result(facts, "\n".join(format_lines(facts)))


def list_resources() -> dict[str, Any]:
    """Everything available: versions, phones, languages, alignment formats, rigs, output formats, models."""
    from phonanim.core.catalog import list_models
    from phonanim.core.version import __version__
    from phonanim.exporters import formats
    from phonanim.readers import load_reader, reader_names
    from phonanim.rig import rig_names
    from phonanim.speech.inventory import INVENTORY
    from phonanim.speech.language import language_names, load_language

    return {
        "version": __version__,
        "phones": " ".join(INVENTORY.phones),
        "languages": {name: load_language(name).title for name in language_names()},
        "reads": {name: load_reader(name).FORMAT for name in reader_names()},
        "rigs": list(rig_names()),
        "writes": formats(),
        "models": [entry.name for entry in list_models()],
    }


def language_coverage(name: str) -> dict[str, Any]:
    """The phones of each label of a language, and the phones that no label gives."""
    from phonanim.speech.inventory import INVENTORY
    from phonanim.speech.language import load_language

    language = load_language(name)
    listed = [*language.phones, *language.ipa, *language.closures, *chain(*language.labels.values())]
    sounds = {label: sound for label in dict.fromkeys(listed) if (sound := language.resolve(label))}
    given = {code for sound in sounds.values() for code in sound.codes}
    return {
        "language": name,
        "title": language.title,
        "alphabets": list(language.alphabets),
        "labels": {label: join_phones(sound.codes) for label, sound in sounds.items()},
        "phones not used": [
            phone for code, phone in enumerate(INVENTORY.phones) if code and code not in given
        ],
    }


def describe_alignment(
    path: Path, language_name: str, tier: str | None, speaker: str | None, lexicon: str | None
) -> dict[str, Any]:
    """The content of an alignment: its tiers, the one that is read, the language, every label's share."""
    from phonanim.inputs.alignment import read_alignment
    from phonanim.readers import find_reader
    from phonanim.speech.alignment_file import open_alignment_file
    from phonanim.speech.reading import describe_language, find_reading_language

    source = open_alignment_file(path)
    reader = find_reader(source)
    alignment = read_alignment(path, tier, speaker, lexicon)
    labels = [interval.label for interval in alignment.intervals]
    found = find_reading_language(alignment, language_name)
    language = found.language
    return {
        "file": str(path),
        "format": reader.FORMAT,
        "tiers": [str(tier) for tier in reader.read(source).tiers],
        "read": alignment.tier,
        "seconds": round(alignment.duration, 6),
        "intervals": len(labels),
        "words": len(alignment.words),
        "language": language.name,
        "language from": describe_language(found.facts()),
        "labels": label_meanings(labels, language),
    }


def label_meanings(labels: Iterable[str], language: Language) -> dict[str, dict[str, Any]]:
    """Each label of a file, most frequent first: its count, and its phones or the nearest known labels."""
    from collections import Counter

    return {
        label: {"count": count, **label_meaning(label, language)}
        for label, count in Counter(labels).most_common()
    }


def label_meaning(label: str, language: Language) -> dict[str, str]:
    """The phones of a label, or the nearest labels when the language does not have it."""
    sound = language.resolve(label)
    if sound is None:
        return {"unknown, nearest": " ".join(language.nearest(label))}
    return {"phones": join_phones(sound.codes)}


def join_phones(codes: Iterable[int]) -> str:
    """Phone names separated by spaces."""
    from phonanim.speech.inventory import INVENTORY

    return " ".join(INVENTORY.phones[code] for code in codes)


def format_lines(facts: Mapping[str, Any]) -> list[str]:
    """The same as text: one fact per line, tables indented."""
    lines = []
    for name, value in facts.items():
        if isinstance(value, Mapping):
            lines += [
                f"{name}:",
                *(f"  {key or repr(key):<12} {format_cell(cell)}" for key, cell in value.items()),
            ]
        else:
            lines.append(f"{name}: {format_cell(value)}")
    return lines


def format_cell(value: object) -> str:
    """A value of a table as text."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {cell}" for name, cell in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
