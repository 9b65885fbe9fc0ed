"""Corrections of a line come back from their file, and move with the phones of another take."""

import json
from pathlib import Path

import pytest

from phonanim.animation.correction_file import (
    is_corrections,
    parse_settings,
    read_corrections,
    write_corrections,
)
from phonanim.animation.corrections import Corrections, corrected_options, timed_options
from phonanim.animation.edits import Edit, Edits
from phonanim.errors import OptionError
from phonanim.options import Closure, Emotion, Options
from phonanim.speech.alignment import Interval
from phonanim.speech.phone_changes import PhoneChanges

READ = (Interval("B", 0.1, 0.2), Interval("AA", 0.2, 0.4), Interval("M", 0.4, 0.5))
SPOKEN = (Interval("P", 0.1, 0.2), *READ[1:])
CORRECTIONS = Corrections(
    PhoneChanges(READ, SPOKEN),
    {
        "jaw": 1.2,
        "loudness": 0.5,
        "gains": {"jawOpen": 1.5},
        "emotions": (Emotion("joy", 0.5, (0.2, 0.4)), Emotion("sadness", 0.1)),
        "closures": (Closure("hold", 0.4, 0.5),),
    },
    "clear",
    Edits("arkit", 1e-3, SPOKEN, (Edit("jawOpen", "offset", 0.1, 0.4, (0.1, 0.1), (0.1, 0.4), (0.0, 0.2)),)),
)


def test_corrections_come_back_from_their_file(tmp_path):
    path = tmp_path / "line.corrections.json"
    write_corrections(CORRECTIONS, path)
    assert is_corrections(path)
    assert read_corrections(path) == CORRECTIONS
    path.write_text(json.dumps(json.loads(path.read_text()), sort_keys=True, indent=1))  # by another program
    assert is_corrections(path)
    assert read_corrections(path) == CORRECTIONS
    write_corrections(CORRECTIONS, path)
    written = path.read_bytes()
    write_corrections(read_corrections(path), path)
    assert path.read_bytes() == written


def test_settings_hold_for_the_line_and_spans_move_with_its_phones():
    options = corrected_options(Options(gains={"mouthClose": 0.9}, jaw=0.7), CORRECTIONS)
    assert (options.jaw, options.loudness) == (1.2, 0.5)
    assert options.gains == {"mouthClose": 0.9, "jawOpen": 1.5}
    assert timed_options(options, CORRECTIONS, SPOKEN) is options
    slower = tuple(Interval(p.label, 2 * p.start, 2 * p.end) for p in SPOKEN)
    moved = timed_options(options, CORRECTIONS, slower)
    assert moved.emotions[0].span == pytest.approx((0.4, 0.8))
    assert moved.emotions[1].span is None
    assert (moved.closures[0].start, moved.closures[0].end) == pytest.approx((0.8, 1.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "phonanim edits 1"}, "its format is 'phonanim edits 1'"),
        ({"settings": {"fps": 5}}, "'fps' is not a setting of a line"),
        ({"settings": {"jaw": 9}}, "jaw is 9; it is a number from 0 to 4"),
        ({"settings": {"gains": {"jawOpen": "x"}}}, "jawOpen is 'x'"),
        ({"settings": {"closures": [{"kind": "bite", "start": 0, "end": 1}]}}, "it is hold or release"),
        ({"settings": {"closures": [{"kind": "hold", "start": 1, "end": 1}]}}, "must end after it starts"),
        ({"settings": {"emotions": [{"name": "joy", "weight": 1}] * 1001}}, "at most 1000"),
        ({"spoken": [["B", 0, "x"]]}, "the end of a label is 'x'"),
    ],
)
def test_damaged_files_are_refused(change, message, tmp_path):
    path = tmp_path / "line.corrections.json"
    write_corrections(CORRECTIONS, path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(OptionError, match=message):
        read_corrections(path)
    path.write_text("{}")
    with pytest.raises(OptionError, match="it lacks 'format'"):
        read_corrections(path)
    with pytest.raises(OptionError, match="cannot be read"):
        read_corrections(Path(tmp_path))


def test_a_language_is_a_setting():
    assert parse_settings({"language": "german", "emotions": []}) == {"language": "german", "emotions": ()}
