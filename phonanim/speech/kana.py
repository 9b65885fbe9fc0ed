"""Japanese text with kanji as the kana that are said, by Open JTalk (the extra `ja`).

The package pyopenjtalk-plus carries Open JTalk (modified BSD licence) and its dictionary, and works offline.
"""

from __future__ import annotations

import contextlib
import io
import re
import unicodedata
from functools import cache
from importlib.util import find_spec
from typing import Any

_JAPANESE = re.compile("[\u3041-\u3096\u3400-\u9fff々〆ヵヶ]")
MARKS = "。、！？!?.,…「」『』（）()・―—"


def can_read(text: str) -> bool:
    """Whether a text has kanji or hiragana, and the extra that reads them is installed.

    It also writes the particle は as it is said, and long vowels.
    """
    return bool(_JAPANESE.search(text)) and find_spec("pyopenjtalk") is not None


def read_japanese(text: str) -> tuple[str, dict[str, str]]:
    """The text in katakana with a blank between phrases, and how the text writes each of them."""
    phrases: list[list[str]] = []  # kana and writing
    joined = True
    for node in _open_jtalk().run_frontend(text):
        written = str(node["string"])
        if unicodedata.normalize("NFKC", written).strip(MARKS + " ") == "":
            phrases.append([written, ""])
            joined = False
            continue
        said = str(node["pron"]).replace("’", "").replace("'", "")
        if phrases and joined and int(node["chain_flag"]) == 1:
            phrases[-1] = [phrases[-1][0] + said, phrases[-1][1] + written]
        else:
            phrases.append([said, written])
        joined = True
    kana = re.sub(r" (?=[。、！？!?.,…」』）)])", "", " ".join(said for said, _ in phrases))
    return kana, {said: unicodedata.normalize("NFKC", written) for said, written in phrases if written}


@cache
def _open_jtalk() -> Any:
    """The package; what it prints of parts that are not installed is not for users."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        import pyopenjtalk
    return pyopenjtalk
