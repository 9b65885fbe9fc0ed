"""The study of docs/study.md whose two systems are the same lines with life and without."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from speech import write_wav

from phonanim.__main__ import run
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

pytest.importorskip("av", reason="needs the extra video")


@pytest.mark.slow
def test_life_on_and_off_on_the_same_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("lines").mkdir()
    for name, vowel in (("a", "AA1"), ("b", "IY1")):
        write_textgrid(Path(f"lines/{name}.TextGrid"), {"phones": (Interval(vowel, 0.1, 0.4),)}, 0.5)
        write_wav(Path(f"lines/{name}.wav"), Sound(np.full(8000, 0.01, np.float32), 16000))
    batch = ["batch", "lines", "--format", "mp4", "--fps", "10", "-q", "-o"]
    assert run([*batch, "on"]) == 0
    assert run([*batch, "off", "--life", "0"]) == 0
    few = ["--practice", "0", "--controls", "0", "--choices", "equal", "--ours", "on"]
    asked = ["--question", "Who looks more alive?"]
    assert run(["study", "make", "on", "off", *few, *asked, "-o", "life.html", "-q"]) == 0
    page = Path("life.html").read_text("utf-8")
    assert asked[1] in page
    films = {base64.b64decode(film) for film in re.findall(r"data:video/mp4;base64,([\w+/=]+)", page)}
    assert films == {path.read_bytes() for path in tmp_path.glob("o*/*.mp4")}
    assert len(films) == 4, "life is seen in every film"
