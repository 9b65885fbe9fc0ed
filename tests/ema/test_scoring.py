"""Articulation against sensors: a take is scored as far as it moves like them, in millimetres."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from ema_samples import textgrid

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS, articulate
from phonanim.commands.evaluate import command
from phonanim.ema.channels import Recording, load_recordings
from phonanim.ema.scoring import is_articulography, score_recording
from phonanim.errors import EvaluationError
from phonanim.metrics import speech_mask

PHONES = ("sil", "M", "AA1", "S", "UW1", "B", "IY1", "sil")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Sensors that move as articulation says, half as far again, at 100 Hz."""
    textgrid(tmp_path / "one.TextGrid", *((0.2 * n, 0.2 * n + 0.2, p) for n, p in enumerate(PHONES)))
    spots = np.zeros((170, 3, 3))
    np.savez(tmp_path / "one.npz", sensors=np.array(["UL", "LL", "JAW"]), xyz=spots, hz=100.0)
    track, times = load_recordings(tmp_path)[0].track, np.arange(170) / 100
    moved = articulate(track, times)
    spots[:, 2, 2] = -1.5 * moved.channel("jaw")
    spots[:, 1, 2] = -1.5 * moved.channel("lip_gap")
    np.savez(tmp_path / "one.npz", sensors=np.array(["UL", "LL", "JAW"]), xyz=spots, hz=100.0)
    return tmp_path


@pytest.fixture
def recording(folder: Path) -> Recording:
    return load_recordings(folder)[0]


@pytest.fixture
def take(recording: Recording) -> Animation:
    times = np.arange(0, recording.track.duration, 1 / 60)
    values = articulate(recording.track, times).values.astype(np.float32)
    return Animation(np.zeros((len(times), 1), np.float32), ("jawOpen",), 60, "arkit", articulation=values)


def test_alike_but_smaller(take: Animation, recording: Recording) -> None:
    measures = score_recording(take, recording).measures
    for name in ("jaw", "lip_gap"):
        assert measures[f"articulation_{name}_r"] > 0.99
        assert measures[f"articulation_{name}_slope"] == pytest.approx(2 / 3, abs=0.03)
        assert measures[f"articulation_{name}_sd_ratio"] == pytest.approx(2 / 3, abs=0.03)
    said = speech_mask(recording.track, recording.times)
    third = recording.curves["jaw"][said].std() / 3
    assert measures["articulation_jaw_rmse_mm"] == pytest.approx(third, abs=0.1)
    assert not any("tongue" in name for name in measures)


def test_a_rig_of_articulation_is_scored_as_a_take_that_carries_it(
    take: Animation, recording: Recording
) -> None:
    assert take.articulation is not None
    channels = Animation(take.articulation, CHANNELS, 60, "articulation")
    wanted = score_recording(take, recording).measures
    assert score_recording(channels, recording).measures == pytest.approx(wanted, nan_ok=True)


def test_unknown_units_have_r_alone(take: Animation, recording: Recording) -> None:
    scores = score_recording(take, replace(recording, in_mm=False))
    assert all(name.endswith("_r") for name in scores.measures)
    assert scores.phones == ()
    assert scores.notes == (
        "the labels are read as english; --language gives another",
        "the unit of the sensors is unknown: only r is scored",
    )


def test_what_cannot_be_scored_is_said(take: Animation, recording: Recording) -> None:
    with pytest.raises(EvaluationError, match="has no articulation"):
        score_recording(replace(take, articulation=None), recording)
    with pytest.raises(EvaluationError, match="0 samples of the recording's speech"):
        score_recording(replace(take, start=5.0), recording)


def test_the_command_takes_files_and_folders(take: Animation, folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    take.save(out / "one.npz")
    assert is_articulography(folder)
    assert not is_articulography(out / "one.npz")
    for prediction, reference in ((out, folder), (out / "one.npz", folder / "one.npz")):
        result = CliRunner().invoke(command, [str(prediction), "--reference", str(reference), "--json"])
        assert result.exit_code == 0, result.output
        found = json.loads(result.stdout)["files"]["one.npz"]["measures"]
        assert found["articulation_jaw_r"] > 0.99
    result = CliRunner().invoke(command, [str(out), "--reference", str(folder), "--axes", "back,left,up"])
    assert f"{folder}: an .npz of sensors has axes of its own; leave out --axes" in str(result.exception)
    (out / "one.npz").rename(out / "other.npz")
    result = CliRunner().invoke(command, [str(out), "--reference", str(folder)])
    assert "no file has the name of a recording" in str(result.exception)
