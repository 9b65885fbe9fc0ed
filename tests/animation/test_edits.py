"""What an animator changed comes back after the line is made anew, follows its phones, and is never lost."""

from __future__ import annotations

import json
from dataclasses import replace

import animations
import numpy as np
import pytest

from phonanim.animation.edit_file import read_edits, write_edits
from phonanim.animation.edits import apply_edits, diff_animations
from phonanim.errors import OptionError
from phonanim.rig import load_rig
from phonanim.speech.alignment import Interval

ERROR = 1e-3


@pytest.fixture(scope="module")
def rig():
    return load_rig("arkit")


@pytest.fixture
def base():
    return animations.line(frames=241, fps=240.0)


def bump(animation, channel, middle, height, width=0.05):
    """The animation with a smooth hill added to one channel."""
    values = animation.values.copy()
    hill = np.clip(1 - np.abs(animation.times - middle) / width, 0, 1) ** 2
    values[:, animation.channels.index(channel)] += (height * hill).astype(np.float32)
    return animation.with_values(values)


def moved(animation, by):
    """The line with phones and words `by` seconds later after a longer silence, curves held at rest."""
    first, *rest = animation.phones
    phones = (
        replace(first, end=first.end + by),
        *(Interval(p.label, p.start + by, p.end + by) for p in rest),
    )
    frames = len(animation.values) + round(by * animation.fps)
    return replace(animation, values=np.zeros((frames, len(animation.channels)), np.float32), phones=phones)


@pytest.mark.parametrize("kind", ["offset", "replace"])
@pytest.mark.parametrize("fps", [24.0, 60.0, 240.0])
def test_edits_give_the_edited_curves_back(rig, kind, fps, tmp_path):
    rng = np.random.default_rng(3)
    base = animations.line(frames=round(fps) + 1, fps=fps)
    wild = base.values.copy()
    for _ in range(60):  # jumps from one frame to the next, at the ends too
        start, channel = rng.integers(0, len(wild)), rng.integers(0, wild.shape[1])
        wild[start : start + rng.integers(1, 30), channel] = rng.uniform(0, 1)
    edited = base.with_values(wild)
    path = tmp_path / "line.edits.json"
    write_edits(diff_animations(base, edited, kind, ERROR), path)
    again, notes = apply_edits(base, read_edits(path), rig)
    assert notes == ()
    assert np.abs(again.values - wild).max() <= ERROR


def test_no_difference_is_no_edit(base):
    assert diff_animations(base, base).edits == ()
    noisy = base.with_values(base.values + np.float32(0.5 * ERROR))
    assert diff_animations(base, noisy, error=ERROR).edits == ()


def test_only_what_changed_is_kept_in_few_keys(base):
    (edit,) = diff_animations(base, bump(base, "jawOpen", 0.5, 0.2, width=0.2)).edits
    assert (edit.channel, edit.kind) == ("jawOpen", "offset")
    assert edit.start == pytest.approx(0.21, abs=0.01)
    assert edit.end == pytest.approx(0.79, abs=0.01)
    assert len(edit.times) < 20


def test_offset_adds_and_replace_insists(rig, base):
    edited = bump(base, "jawOpen", 0.5, 0.2)
    lower = base.with_values(base.values * np.float32(0.5))
    frame, jaw = 120, base.channels.index("jawOpen")
    for kind, expected in (
        ("offset", lower.values[frame, jaw] + 0.2),
        ("replace", edited.values[frame, jaw]),
    ):
        again, _ = apply_edits(lower, diff_animations(base, edited, kind), rig)
        assert again.values[frame, jaw] == pytest.approx(expected, abs=ERROR)
        untouched = np.delete(again.values - lower.values, jaw, axis=1)
        assert not untouched.any()


def test_a_replacement_has_soft_edges(rig, base):
    edited = base.with_values(base.values.copy())
    jaw = base.channels.index("jawOpen")
    edited.values[100:140, jaw] = 1.0
    still = base.with_values(np.zeros_like(base.values))
    again, _ = apply_edits(still, diff_animations(base, edited, "replace"), rig)
    assert np.abs(np.diff(again.values[:100, jaw])).max() < 0.1
    assert again.values[70, jaw] == 0.0


@pytest.mark.parametrize("by", [0.25, -0.05])
def test_an_edit_follows_its_phones(rig, base, by):
    edits = diff_animations(base, bump(base, "jawOpen", 0.5, 0.2))
    later, notes = apply_edits(moved(base, by), edits, rig)
    assert notes == ()
    peak = later.times[later.channel("jawOpen").argmax()]
    assert peak == pytest.approx(0.5 + by, abs=1 / base.fps)


def test_an_edit_is_stretched_with_its_phones(rig, base):
    slow = tuple(Interval(p.label, 2 * p.start, 2 * p.end) for p in base.phones)
    line = replace(base, values=np.zeros((481, len(base.channels)), np.float32), phones=slow)
    again, _ = apply_edits(line, diff_animations(base, bump(base, "jawOpen", 0.5, 0.2)), rig)
    moving = again.times[again.channel("jawOpen") > 0.05]
    assert moving.mean() == pytest.approx(1.0, abs=0.01)
    assert np.ptp(moving) == pytest.approx(2 * 0.05, abs=0.02)


def test_another_frame_rate_takes_the_edits(rig, base):
    edited = bump(base, "jawOpen", 0.5, 0.2)
    again, _ = apply_edits(base.at_rate(60.0), diff_animations(base, edited), rig)
    np.testing.assert_allclose(again.values, edited.at_rate(60.0).values, atol=ERROR)


def test_an_edited_file_of_another_rate_is_compared_in_time(base):
    slow = base.at_rate(120.0)
    values = slow.at_rate(240.0).values
    assert diff_animations(slow, replace(base, values=values)).edits == ()


def test_gone_words_are_told(rig, base):
    other = replace(base, phones=tuple(p if p.label != "OW" else replace(p, label="IY") for p in base.phones))
    again, notes = apply_edits(other, diff_animations(base, bump(base, "jawOpen", 0.5, 0.2)), rig)
    (note,) = notes
    assert note.startswith("edit jawOpen 0.35-0.65 s was left out")
    assert note.endswith("OW is no longer spoken there")
    np.testing.assert_array_equal(again.values, base.values)


def test_an_edit_outside_the_line_is_told(rig, base):
    silent = replace(base, phones=())
    edits = diff_animations(silent, bump(silent, "jawOpen", 0.8, 0.2))
    short = silent.with_values(silent.values[:100])
    again, (note,) = apply_edits(short, edits, rig)
    assert note.endswith("it would be at 0.65 s, outside the line of 0.41 s")
    np.testing.assert_array_equal(again.values, short.values)


def test_another_rig_is_told(base):
    vrm = load_rig("vrm")
    line = replace(base, values=np.zeros((241, 5), np.float32), channels=vrm.controls[:5], rig="vrm")
    _, notes = apply_edits(line, diff_animations(base, bump(base, "jawOpen", 0.5, 0.2)), vrm)
    assert notes[0] == "the edits were made on the rig arkit, this line moves vrm"
    assert notes[1].endswith("vrm has no such channel")


def test_limits_are_kept_and_told(rig, base):
    full = base.with_values(np.ones_like(base.values))
    again, (note,) = apply_edits(full, diff_animations(base, bump(base, "jawOpen", 0.5, 0.2)), rig)
    assert again.values.max() == 1.0
    assert note.endswith("reaches beyond the limits of arkit and was cut there")


def test_two_lines_are_not_compared(base):
    with pytest.raises(
        OptionError, match=r"lasts 1\.00 s and the other 0\.41 s; compare two of the same line"
    ):
        diff_animations(base, base.with_values(base.values[:100]))
    with pytest.raises(
        OptionError, match="only one of the two animations has .*; compare two of the same rig"
    ):
        diff_animations(base, animations.metahuman(frames=241, fps=240.0))


def test_a_channel_that_one_format_adds_at_nought_is_no_difference(base):
    more = replace(base, channels=(*base.channels, "leftEyeYaw"))
    nought = np.zeros((len(base.values), 1), np.float32)
    assert diff_animations(base, more.with_values(np.hstack([base.values, nought]))).edits == ()
    with pytest.raises(OptionError, match="only one of the two animations has leftEyeYaw"):
        diff_animations(base, more.with_values(np.hstack([base.values, nought + 1])))


def test_the_file_is_the_edits(base, tmp_path):
    edits = diff_animations(base, bump(base, "jawOpen", 0.5, 0.2))
    path, twice = tmp_path / "a.json", tmp_path / "b.json"
    write_edits(edits, path)
    write_edits(read_edits(path), twice)
    assert path.read_bytes() == twice.read_bytes()
    assert json.loads(path.read_text())["error"] == ERROR


GOOD = {
    "channel": "jawOpen",
    "kind": "offset",
    "start": 0,
    "end": 1,
    "fade": [0.1, 0.1],
    "keys": [[0, 0], [1, 1]],
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "add"}, "jawOpen 0.00-1.00 s has the kind 'add'; it is offset or replace"),
        ({"keys": []}, "an edit of jawOpen has no keys"),
        ({"keys": [[0, float("nan")]]}, "it has NaN, which is not a number"),
        ({"keys": [[1, 0], [0, 0]]}, "has times that run backwards"),
        ({"fade": [0.6, 0.6]}, "has fades that are longer than it is"),
        ({"fade": 0.6}, "is not a file of edits"),
    ],
)
def test_a_damaged_edit_is_named(change, message, tmp_path):
    path = tmp_path / "line.edits.json"
    tree = {"format": "phonanim edits 1", "rig": "arkit", "error": 0.001, "phones": []}
    path.write_text(json.dumps({**tree, "edits": [GOOD]}))
    assert len(read_edits(path).edits) == 1
    path.write_text(json.dumps({**tree, "edits": [{**GOOD, **change}]}))
    with pytest.raises(OptionError) as caught:
        read_edits(path)
    assert str(caught.value).startswith(f"{path}: is not a file of edits")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [("{", "is not a file of edits: "), ("[]", "is not a file of edits: "), ("{}", "it lacks 'format'")],
)
def test_another_file_is_named(text, message, tmp_path):
    path = tmp_path / "line.edits.json"
    path.write_text(text)
    with pytest.raises(OptionError, match=message):
        read_edits(path)
    path.write_text('{"format": "phonanim animation 1"}')
    with pytest.raises(OptionError, match="its format is 'phonanim animation 1', not 'phonanim edits 1'"):
        read_edits(path)


@pytest.mark.parametrize(
    ("label", "span", "fade"), [("L", (0.3, 0.68), (0.14, 0.0)), ("OW", (0.1, 0.5), (0.0, 0.15))]
)
def test_a_phone_under_a_fade_may_change(rig, base, label, span, fade):
    found = diff_animations(base, bump(base, "jawOpen", 0.55, 0.3))
    other = replace(base, phones=tuple(replace(p, label="M") if p.label == label else p for p in base.phones))
    for used, told in ((fade, False), ((0.0, 0.0), True)):
        edit = replace(found.edits[0], start=span[0], end=span[1], times=np.array(span), fade=used)
        edit = replace(edit, values=np.full(2, 0.1))
        notes = apply_edits(other, replace(found, edits=(edit,)), rig)[1]
        assert any(note.endswith(f"{label} is no longer spoken there") for note in notes) is told


def test_work_without_end_is_refused(rig, base, monkeypatch):
    edits = diff_animations(base, bump(base, "jawOpen", 0.5, 0.3))
    monkeypatch.setattr("phonanim.animation.edits.MOST_STEPS", len(edits.edits) * 200)
    with pytest.raises(
        OptionError, match=r"there are 1 edits of \d+ phones for 241 frames, which is too much"
    ):
        apply_edits(base, edits, rig)
    monkeypatch.undo()
    monkeypatch.setattr("phonanim.speech.anchors.MOST_PAIRS", 1)
    said = [phone.label for phone in reversed(base.phones)]
    other = tuple(replace(phone, label=label) for phone, label in zip(base.phones, said, strict=True))
    with pytest.raises(OptionError, match="are too long to be matched"):
        apply_edits(replace(base, phones=other), edits, rig)
