"""EMU bundles as a reference: axes of any direction, and labels of any language."""

from __future__ import annotations

import json
from pathlib import Path

import ema_samples as samples
import numpy as np
import pytest
from click.testing import CliRunner, Result

from phonanim.animation.animation import Animation
from phonanim.articulation import articulate
from phonanim.commands.evaluate import command
from phonanim.ema import load_utterances
from phonanim.ema.articulation import DIRECTIONS
from phonanim.ema.channels import load_recordings
from phonanim.speech.phones import PhoneTrack

ENGLISH = ("", "M", "AA1", "S", "UW1", "B", "IY1", "TH", "")
GERMAN = ("", "m", "a:", "S", "u:", "b", "i:", "C", "")
RATE, STEP, PLACES = 200.0, 0.2, {"upper_lip": (45, 0, 8), "lower_lip": (43, 0, -10), "t_back": (0, 0, 0)}


def written(folder: Path, labels: tuple[str, ...], axes: str) -> Path:
    """A bundle whose lips move as articulation says, with x, y and z of its files in these directions."""
    folder.mkdir(parents=True, exist_ok=True)
    spans = [(STEP * n, STEP * (n + 1), label) for n, label in enumerate(labels)]
    samples.bundle(folder / "line_bndl.json", *spans)
    times = np.arange(round(spans[-1][1] * RATE)) / RATE
    shown = {name: np.tile(np.array(place, float), (len(times), 1)) for name, place in PLACES.items()}
    for _ in range(2):  # its phones are read before its lips can move by them
        for name, track in shown.items():
            words = [DIRECTIONS[word] for word in axes.split(",")]
            own = np.column_stack([sign * track[:, axis] for axis, sign in words])
            samples.ssff(folder / f"line.{name}", samples.sensor_columns(name, own), RATE)
        moved = articulate(track_of(folder, axes), times)
        shown["lower_lip"][:, 2] = -10 - moved.channel("lip_gap")
    return folder


def track_of(folder: Path, axes: str) -> PhoneTrack:
    return load_recordings(folder, axes=axes)[0].track


@pytest.fixture
def take(tmp_path: Path) -> Path:
    """What is said, by articulation."""
    folder = written(tmp_path / "spoken", ENGLISH, "forward,left,up")
    track = track_of(folder, "forward,left,up")
    times = np.arange(0, track.duration, 1 / 60)
    values = articulate(track, times).values.astype(np.float32)
    take = Animation(np.zeros((len(times), 1), np.float32), ("jawOpen",), 60, "arkit", articulation=values)
    take.save(tmp_path / "line.npz")
    return tmp_path / "line.npz"


def evaluate(take: Path, reference: Path, *options: str) -> Result:
    return CliRunner().invoke(command, [str(take), "--reference", str(reference), *options])


def scored(take: Path, reference: Path, *options: str) -> tuple[dict[str, float], list[str]]:
    result = evaluate(take, reference, "--json", *options)
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)["files"]["line.npz"]
    return found["measures"], found["notes"]


@pytest.mark.parametrize("axes", ["left,back,up", "forward,left,up", "down,forward,right", "up,back,right"])
def test_axes_are_found_and_told(axes: str, take: Path, tmp_path: Path) -> None:
    folder = written(tmp_path / "turned", ENGLISH, axes)
    for reference in (folder, folder / "line_bndl.json"):
        measures, notes = scored(take, reference)
        assert measures["articulation_lip_gap_r"] > 0.99
        assert measures["articulation_lip_gap_slope"] == pytest.approx(1, abs=0.05)
        assert notes[0] == f"x, y and z are {axes}, as lips and tongue lie; --axes gives others"
    given, notes = scored(take, folder, "--axes", axes)
    assert given == pytest.approx(measures, nan_ok=True)
    assert not any("x, y and z" in note for note in notes)


def test_axes_that_sensors_do_not_show(take: Path, tmp_path: Path) -> None:
    folder = written(tmp_path / "turned", ENGLISH, "forward,left,up")
    (folder / "line.t_back").unlink()
    measures, notes = scored(take, folder)
    assert measures["articulation_lip_gap_r"] > 0.99
    assert (
        notes[0] == "which way x, y and z point is not known, forward,left,up is assumed; --axes gives others"
    )


def test_the_language_is_that_of_the_labels_or_of_the_option(take: Path, tmp_path: Path) -> None:
    for labels, language in ((ENGLISH, "english"), (GERMAN, "german")):
        folder = written(tmp_path / language, labels, "left,back,up")
        measures, notes = scored(take, folder)
        assert f"the labels are read as {language}; --language gives another" in notes
        assert measures["articulation_lip_gap_r"] > 0.8
        named, notes = scored(take, folder, "--language", language)
        assert not any("--language" in note for note in notes)
        assert named == pytest.approx(measures, nan_ok=True)
    result = evaluate(take, folder, "--language", "english")
    assert '"C"' in str(result.exception)
    assert str(folder / "line_bndl.json") in str(result.exception)


def test_a_bundle_without_speech_has_none(tmp_path: Path) -> None:
    folder = written(tmp_path, ENGLISH, "left,back,up")
    samples.bundle(folder / "line_bndl.json", (0.0, 1.8, ""))
    (found,) = load_utterances(folder)
    assert not found.speech.any()


def test_axes_are_of_sensors(take: Path, tmp_path: Path) -> None:
    folder = written(tmp_path / "turned", ENGLISH, "left,back,up")
    result = evaluate(take, folder, "--axes", "left,left,up")
    assert "'left,left,up': give the directions of x, y and z" in str(result.exception)
    result = evaluate(take, take, "--axes", "left,back,up")
    assert result.exit_code == 2
    assert "--axes cannot be used with a reference without sensors; leave it out" in result.output
