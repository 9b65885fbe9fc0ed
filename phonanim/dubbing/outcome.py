"""The outcome of a line, and its form in the ledger."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from phonanim.core.decode import (
    DAMAGE,
    DecodeError,
    decode_list,
    decode_number,
    decode_table,
    decode_text,
    parse_json,
)
from phonanim.dubbing.stamps import check_stamps

MOST = 1e12  # of a count


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of one line.

    `origin` is everything that the outputs depend on; `outputs` are paths relative to the output folder with
    their content hashes; `facts` are for the report; `error` is the reason when there are no outputs.
    `stamps` are sizes and times of inputs and outputs (`phonanim.dubbing.stamps`), empty where they are not
    known; `motion` is what an audit asks of outputs.
    """

    id: str
    place: str
    origin: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""
    stamps: Mapping[str, Any] = field(default_factory=dict)
    motion: Mapping[str, Any] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether the outputs exist."""
        return not self.error


_NAMES = tuple(field.name for field in fields(Outcome))


def encode_outcome(outcome: Outcome) -> str:
    """One outcome as one line of JSON."""
    return json.dumps({name: getattr(outcome, name) for name in _NAMES}, ensure_ascii=False) + "\n"


def decode_outcomes(lines: Iterable[str]) -> dict[str, Outcome]:
    """The last outcome of each id; incomplete lines, as a killed run leaves them, are skipped."""
    found = filter(None, map(_outcome, lines))
    return {outcome.id: outcome for outcome in found}


def _outcome(line: str) -> Outcome | None:
    try:
        found = Outcome(**parse_json(line))
        _check(found)
    except DAMAGE:
        return None
    return found


def _check(outcome: Outcome) -> None:
    """Raise DecodeError for an outcome that no run writes, because the report and the audit rely on it."""
    for name in ("id", "place", "error"):
        decode_text(getattr(outcome, name), name)
    for name in ("origin", "outputs", "facts", "stamps", "motion"):
        decode_table(getattr(outcome, name), name)
    check_stamps(outcome.stamps)
    check_motion(outcome.motion)
    for name, digest in outcome.outputs.items():
        decode_text(digest, "a hash")
        if name.startswith(("/", "\\")) or ".." in name or "\0" in name:
            raise DecodeError(f"the output {name!r} lies elsewhere")
    if outcome.done:
        decode_table(outcome.origin.get("options", {}), "options")
        for name in ("frames", "seconds", "phones"):
            decode_number(outcome.facts[name], name, 0, MOST)
        if outcome.facts.get("language") is not None:
            language = decode_table(outcome.facts["language"], "language")
            decode_text(language["name"], "name")
            decode_text(language["by"], "by")
            decode_number(language["certainty"], "certainty", 0, 1)
            for name, share in decode_table(language.get("candidates", {}), "candidates").items():
                decode_number(share, name, 0, 1)
        for flag in decode_list(outcome.facts["flags"], "flags"):
            decode_text(flag["check"], "check")
            decode_text(flag["text"], "text")
            decode_number(flag["severity"], "severity", 0, MOST)


def check_motion(motion: Mapping[str, Any]) -> None:
    """Raise DecodeError for a motion that no run writes; an empty one is not known."""
    if not motion:
        return
    for name in ("end", "seconds"):
        decode_number(motion[name], name, 0, MOST)
    if not isinstance(motion["still"], bool):
        raise DecodeError("still is true or false")
