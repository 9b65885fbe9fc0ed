"""`--style`, `--level` and `--loudness`, and the same in Python and in tables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from speech import write_wav
from voices import RATE, TIMES, TRACK, voiced, whispered

import phonanim
from phonanim.__main__ import run
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.errors import OptionError
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

PHONES = tuple(
    Interval(label.upper(), start, end)
    for label, start, end in zip(
        TRACK.labels, TRACK.bounds[:-1].tolist(), TRACK.bounds[1:].tolist(), strict=True
    )
)


@pytest.fixture
def line(tmp_path: Path) -> Path:
    path = tmp_path / "line.TextGrid"
    write_textgrid(path, {"phones": PHONES}, TRACK.duration)
    return path


def record(path: Path, samples: np.ndarray) -> Path:
    write_wav(path, Sound(samples.astype(np.float32), RATE))
    return path


def dials(path: Path) -> dict[str, object]:
    options = json.loads(path.read_text())["provenance"]["options"]
    return {name: options[name] for name in ("jaw", "lips", "reduction", "level")}


def test_a_style_sets_dials_but_for_those_that_are_given(line: Path) -> None:
    out = line.with_name("x.json")
    assert run(["animate", str(line), "-o", str(out), "--style", "Shouted", "--lips", "0.9", "-q"]) == 0
    assert dials(out) == {"jaw": 1.5, "lips": 0.9, "reduction": 0.5, "level": None}


def test_a_style_that_is_none(line: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["animate", str(line), "--style", "shuoted"]) == 2
    assert "there is no style 'shuoted'; did you mean 'shouted'?" in capsys.readouterr().err


def test_styles_and_ranges_in_python(line: Path) -> None:
    plain, loud = phonanim.animate(line, life=0), phonanim.animate(line, life=0, style="shouted")
    assert loud.channel("jawOpen").max() > 1.2 * plain.channel("jawOpen").max()
    with pytest.raises(OptionError, match=r"quickness = 0; give a number from 0\.5 to 2"):
        phonanim.animate(line, quickness=0.0)


def test_the_mouth_follows_the_recording_beside_the_line(line: Path) -> None:
    louder = record(line.with_suffix(".wav"), voiced() * np.where(TIMES > 3.5, 2.0, 1.0))
    even, followed = (phonanim.animate(line, life=0, loudness=g) for g in (0.0, 1.0))
    half = len(even.values) // 2
    change = followed.channel("jawOpen") - even.channel("jawOpen")
    assert change[: half - 30].min() < -0.02
    assert change[half + 30 :].max() > 0.02
    again = phonanim.animate(line, audio=louder, life=0)
    np.testing.assert_array_equal(again.values, followed.values)
    assert "audio_sha256" in followed.provenance


def test_levels_over_lines(line: Path) -> None:
    sound = record(line.with_name("a.wav"), voiced())
    opened = [
        phonanim.animate(line, audio=sound, life=0, level=level).channel("jawOpen").max()
        for level in (-26.0, None, -14.0)
    ]
    assert opened[0] > opened[1] > opened[2]


def test_a_whisper_is_said_and_is_no_smaller(line: Path) -> None:
    sound = record(line.with_name("a.wav"), whispered())
    found = phonanim.animate(line, audio=sound, life=0, level=-20.0)
    np.testing.assert_array_equal(found.values, phonanim.animate(line, life=0).values)
    assert "the recording is whispered, so the mouth does not follow its level" in found.provenance["notes"]


def test_cells_of_a_table(line: Path) -> None:
    record(line.with_name("usual.wav"), voiced())
    table = line.with_name("t.csv")
    table.write_text(
        "id,alignment,style,level,loudness,quickness,hold\n"
        "a,line.TextGrid,sung,usual.wav,0.5,,2\n"
        "b,line.TextGrid,,-23,,1.5,\n"
        "c,line.TextGrid,,gone.wav,,,\n"
        "d,line.TextGrid,,,,0.1,\n"
    )
    lines = read_lines(str(table), Common())
    first, second = (one.options for one in lines.lines)
    assert (first.jaw, first.loudness, first.quickness, first.hold) == (1.3, 0.5, 0.85, 2.0)
    assert first.level == pytest.approx(-20, abs=2)
    assert (second.level, second.quickness) == (-23.0, 1.5)
    assert "gone.wav: does not exist; correct the path" in lines.faults[0].message
    assert lines.faults[1].message == "quickness = '0.1'; give a number from 0.5 to 2"


def test_a_line_has_its_own_style_or_that_of_the_run(line: Path) -> None:
    table = line.with_name("t.csv")
    table.write_text("id,alignment,style\na,line.TextGrid,neutral\nb,line.TextGrid,\n")
    out = line.with_name("out")
    asked = ["--style", "shouted", "--lips", "0.9", "--format", "json", "--workers", "1", "-q"]
    assert run(["batch", str(table), "-o", str(out), *asked]) == 0
    assert dials(out / "a.json") == {"jaw": 1.0, "lips": 0.9, "reduction": 1.0, "level": None}
    assert dials(out / "b.json") == {"jaw": 1.5, "lips": 0.9, "reduction": 0.5, "level": None}
