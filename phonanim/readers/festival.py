"""Utterances of Festival (.utt): the items of the relation Segment, with end times in seconds."""

from __future__ import annotations

import re

from phonanim.readers._rows import LONGEST_ROW, from_ends
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Festival utterance (.utt)"

_ITEM = re.compile(r"(\d+) id (\S+) ;(.*)")
_FEATURE = re.compile(r'\s*(\w+) ("(?:[^"\\]|\\.){0,1000}"|[^;]*?)\s*;')
_RELATION = re.compile(r"Relation (\S+) ;")
_NODE = re.compile(r"(\d+) (\d+) (\d+) (\d+) (\d+) (\d+)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line is that of a saved utterance."""
    return source.text.startswith("EST_File utterance")


def read(source: AlignmentFile) -> Recording:
    """The segments."""
    items, relations = _parse(source)
    segments = [(n, items[n]) for n in relations.get("Segment", ()) if "end" in items.get(n, {})]
    try:
        ends = [(float(features["end"]), features.get("name", "")) for _, features in segments]
    except ValueError as error:
        raise source.error(f"has a damaged end ({error}); save the utterance again") from error
    if not ends:
        raise source.error("has no segments with end times; save it after synthesis (utt.save)")
    return Recording((Tier("phones", from_ends(ends)),), 0.0, ends[-1][0])


def _parse(source: AlignmentFile) -> tuple[dict[str, dict[str, str]], dict[str, list[str]]]:
    """The features of each item, and the items of each relation in their order."""
    items: dict[str, dict[str, str]] = {}
    relations: dict[str, list[str]] = {}
    name = ""
    for line in source.text.splitlines():
        if len(line) > LONGEST_ROW:
            continue
        if found := _RELATION.match(line):
            name = found[1]
        elif item := _ITEM.match(line):
            features = _FEATURE.findall(item[3])
            items[item[1]] = {key: value.strip('"') for key, value in features}
        elif name and (node := _NODE.fullmatch(line.strip())):
            relations.setdefault(name, []).append(node[2])
    return items, relations
