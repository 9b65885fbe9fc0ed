"""eSpeak NG in a process of its own: speech and phonemes of texts.

eSpeak NG is under the GPL (version 3 or later). phonanim contains nothing of it: the extra `espeak` installs
the package espeakng-loader, which carries the library and its voices, and the library is loaded at run time.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

from phonanim.errors import MissingExtraError, OptionError


def can_speak() -> bool:
    """Whether the extra `espeak` is installed."""
    return importlib.util.find_spec("espeakng_loader") is not None


def ask_espeak(request: Mapping[str, Any]) -> dict[str, Any]:
    """What the process answers (`_espeak_process`).

    Raises OptionError for an unknown voice, suggesting the nearest, and MissingExtraError without the extra.
    """
    if not can_speak():
        raise MissingExtraError("speech from text needs eSpeak NG: pip install 'phonanim[espeak]'")
    done = subprocess.run(
        [sys.executable, "-m", "phonanim.media._espeak_process"],
        input=json.dumps(request),
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    if done.returncode:
        reason = done.stderr.strip().splitlines() or [f"it ended with {done.returncode}"]
        raise MissingExtraError(f"eSpeak NG cannot speak ({reason[-1]}); install phonanim[espeak] again")
    answer = json.loads(done.stdout)
    if "error" in answer:
        raise OptionError(answer["error"])
    return dict(answer)
