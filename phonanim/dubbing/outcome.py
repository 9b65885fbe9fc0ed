"""What became of a line, and how a ledger writes it down."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one line.

    `origin` is everything that the outputs depend on; `outputs` are paths relative to the output folder
    with their content hashes; `facts` are for the report; `error` says why there are no outputs.
    """

    id: str
    place: str
    origin: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""

    @property
    def done(self) -> bool:
        """Whether the outputs are there."""
        return not self.error


def encode_outcome(outcome: Outcome) -> str:
    """One outcome as one line of JSON."""
    return json.dumps(asdict(outcome), ensure_ascii=False) + "\n"


def decode_outcomes(lines: Iterable[str]) -> dict[str, Outcome]:
    """The last outcome of each id; lines that are none, as a kill leaves them, are left out."""
    found = filter(None, map(_outcome, lines))
    return {outcome.id: outcome for outcome in found}


def _outcome(line: str) -> Outcome | None:
    try:
        return Outcome(**json.loads(line))
    except (ValueError, TypeError):
        return None
