"""Praat's backslash trigraphs, such as "\\sh" for [ʃ], by the table lexicon/praat_trigraphs.tsv.

The table has the letters and marks that Praat 6.4 itself gives (`backslashTrigraphsToUnicode$`).
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

from phonanim.core.lexicon import LEXICON
from phonanim.speech.alignment import Recording, Tier

_TRIGRAPH = re.compile(r"\\(..)", re.DOTALL)


def decode_trigraphs(recording: Recording) -> Recording:
    """The recording with its trigraphs as the characters that Praat shows; unknown ones stay as they are."""
    return replace(recording, tiers=tuple(map(_decoded, recording.tiers)))


def _decoded(tier: Tier) -> Tier:
    intervals = (
        replace(one, label=_plain(one.label)) if "\\" in one.label else one for one in tier.intervals
    )
    return replace(tier, intervals=tuple(intervals))


def _plain(label: str) -> str:
    return _TRIGRAPH.sub(lambda match: _table().get(match[0], match[0]), label)


@cache
def _table() -> dict[str, str]:
    lines = (LEXICON / "praat_trigraphs.tsv").read_text("utf-8").splitlines()[1:]
    return dict(line.split("\t") for line in lines)
