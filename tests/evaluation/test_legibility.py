"""The reader of visemes: what it reads of lips that speak, mumble, shout or say something else."""

from pathlib import Path

import numpy as np
import pytest

from phonanim.articulation import articulate
from phonanim.errors import EvaluationError
from phonanim.evaluation.legibility import (
    LIPS,
    READER_FILE,
    VISEMES,
    VisemeRow,
    fit_reader,
    load_reader,
    merge_visemes,
    read_visemes,
    save_reader,
    see_lips,
    viseme_scores,
)
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

CHANNEL = dict(zip(LIPS, ("lip_gap", "lip_width", "protrusion", "upper_lip"), strict=True))


@pytest.fixture(scope="module")
def line(root):
    return to_phones(read_alignment(root / "examples/line.TextGrid"), "english")[0]


def lips_of(track, scale=1.0, fps=60):
    times = np.arange(0, track.duration, 1 / fps)
    moved = articulate(track, times)
    return {name: scale * moved.channel(channel) for name, channel in CHANNEL.items()}, times


def read(track, scale=1.0, fps=60, said=None):
    curves, times = lips_of(track, scale, fps)
    return read_visemes(see_lips(curves, times, said or track), load_reader()).share()


def test_lips_that_say_a_line_are_read_and_lips_that_say_another_are_not(line):
    rng = np.random.default_rng(1)
    other = PhoneTrack(rng.permutation(line.codes), line.bounds, line.labels)
    assert read(line) > 0.6
    assert read(line, said=other) < 0.4


def test_a_mumbling_mouth_is_read_less_and_a_still_one_not_at_all(line):
    loud, usual, mumbled, still = (read(line, scale) for scale in (1.5, 1.0, 0.15, 0.0))
    assert loud == pytest.approx(usual, abs=0.1)
    assert mumbled < usual - 0.1
    assert still < 0.35


def test_the_rate_of_frames_does_not_matter(line):
    assert read(line, fps=30) == pytest.approx(read(line, fps=120), abs=0.05)


def test_scores_are_of_both_sides_and_by_viseme(line):
    curves, times = lips_of(line)
    less = {name: 0.15 * curve for name, curve in curves.items()}
    measures, rows = viseme_scores(less, curves, times, line)
    assert measures["captured_visemes_legible"] > measures["visemes_legible"]
    assert measures["captured_viseme_log_p"] > measures["viseme_log_p"]
    assert {row.name for row in rows} == set(VISEMES)
    judged = np.isin(line.codes, INVENTORY.codes(" ".join(VISEMES.values()).split()))
    assert sum(row.sounds for row in rows) == judged.sum()
    assert viseme_scores({"aperture": times}, curves, times, line) == ({}, ())


def test_lines_are_merged_by_sounds():
    rows = merge_visemes([[VisemeRow("open", 0.5, 1.0, 1)], [VisemeRow("open", 0.8, 0.4, 3)]])
    assert [vars(row) for row in rows] == [
        {"name": "open", "read": pytest.approx(0.725), "captured": pytest.approx(0.55), "sounds": 4}
    ]


def test_a_reader_is_fitted_and_comes_back_from_its_table(line, tmp_path):
    curves, times = lips_of(line)
    sight = see_lips(curves, times, line, ("aperture", "width"))
    fitted = fit_reader([sight], ("aperture", "width"))
    save_reader(fitted, tmp_path / "reader.csv")
    kept = load_reader(tmp_path / "reader.csv")
    assert kept.lips == fitted.lips
    assert read_visemes(sight, kept).share() == pytest.approx(read_visemes(sight, fitted).share(), abs=0.02)
    assert read_visemes(sight, fitted).share() > 0.6


def test_what_cannot_be_fitted_or_read_is_said(line, tmp_path):
    curves, times = lips_of(line)
    vowels = PhoneTrack(np.full_like(line.codes, INVENTORY.code("aa")), line.bounds, line.labels)
    with pytest.raises(EvaluationError, match="the recordings contain no phone that is 'closed'"):
        fit_reader([see_lips(curves, times, vowels)])
    with pytest.raises(EvaluationError, match="no speech"):
        see_lips(curves, times + 1000, line)
    damaged = tmp_path / "reader.csv"
    damaged.write_text("\n".join(READER_FILE.read_text().splitlines()[:4]))
    with pytest.raises(EvaluationError, match="needs a row for each of closed"):
        load_reader(damaged)
    with pytest.raises(EvaluationError, match="cannot be read"):
        load_reader(Path("absent.csv"))
