"""Takes that differ in the tongue alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from speech import write_wav

import phonanim
from phonanim.__main__ import run
from phonanim.animation.animation import Animation
from phonanim.errors import StudyError
from phonanim.exporters import load
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid
from phonanim.study.tongues import load_with_sound, partners, tongue_channels, tongue_takes


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two lines with other tongues, as NPZ with a tongue."""
    folder = tmp_path_factory.mktemp("lines")
    for name, phones in (("a", ("L", "IY1", "K")), ("b", ("TH", "AA1", "G", "IY1"))):
        times = [round(0.1 + 0.15 * n, 2) for n in range(len(phones) + 1)]
        intervals = tuple(map(Interval, phones, times, times[1:]))
        write_textgrid(folder / f"{name}.TextGrid", {"phones": intervals}, intervals[-1].end + 0.2)
        made = phonanim.animate(folder / f"{name}.TextGrid", rig="arkit_tongue", life=0.0)
        made.save(folder / f"{name}.npz")
    return [folder / "a.npz", folder / "b.npz"]


def split(animation: Animation) -> tuple[np.ndarray, np.ndarray]:
    rows = tongue_channels(animation)
    return animation.values[:, rows], np.delete(animation.values, rows, axis=1)


def test_only_the_tongue_differs(lines: list[Path]) -> None:
    one, other = map(load, lines)
    takes = tongue_takes(one, other)
    assert list(takes) == ["tongue", "mismatch", "null"]
    own, face = split(takes["tongue"])
    wrong, same = split(takes["mismatch"])
    still = takes["null"].values[:, tongue_channels(one)]
    assert np.array_equal(face, same)
    assert np.array_equal(face, np.delete(takes["null"].values, tongue_channels(one), axis=1))
    assert not still.any()
    # The other tongue from its first frame to its last, in the time of this line.
    given = split(other)[0]
    np.testing.assert_allclose(wrong[[0, -1]], given[[0, -1]], atol=1e-6)
    assert wrong.max() == pytest.approx(given.max(), abs=0.05)
    assert np.abs(wrong - own).max() > 0.2


def test_the_command_writes_a_folder_for_each(lines: list[Path], tmp_path: Path) -> None:
    output = tmp_path / "takes"
    assert run(["study", "tongues", *map(str, lines), "-o", str(output), "--format", "npz", "-q"]) == 0
    found = sorted(path.relative_to(output).as_posix() for path in output.rglob("*.npz"))
    assert found == [f"{system}/{name}.npz" for system in ("mismatch", "null", "tongue") for name in "ab"]
    np.testing.assert_array_equal(load(output / "tongue/a.npz").values, load(lines[0]).values)
    mismatched, other = load(output / "mismatch/b.npz"), load(lines[0])
    assert np.abs(mismatched.values[0] - other.values[0])[tongue_channels(other)].max() < 1e-6


def test_the_recordings_may_be_elsewhere(
    lines: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `phonanim batch` leaves them: the recordings are beside the alignments, not beside the takes."""
    sounds, made = tmp_path / "sounds", tmp_path / "made"
    for folder in (sounds, made):
        folder.mkdir()
    for line in lines:
        write_wav(sounds / f"{line.stem}.wav", Sound(np.zeros(8000, np.float32), 8000))
        replace(load(line), audio=sounds / f"{line.stem}.wav").save(made / line.name)
    given = ["study", "tongues", *map(str, sorted(made.glob("*.npz"))), "--format", "npz", "-q"]
    assert run([*given, "-o", str(tmp_path / "none")]) == 2
    assert (
        "a.npz: its recording a.wav is not beside it; name its folder by --sounds" in capsys.readouterr().err
    )
    assert not (tmp_path / "none").exists()
    assert run([*given, "-o", str(tmp_path / "takes"), "--sounds", str(sounds)]) == 0
    found = load_with_sound(made / "a.npz", sounds)
    assert found.audio == sounds / "a.wav"


def test_lines_without_a_tongue(lines: list[Path]) -> None:
    one = load(lines[0])
    rows = tongue_channels(one)
    still = one.values.copy()
    still[:, rows] = 0
    with pytest.raises(StudyError, match="does not move; animate the lines with --rig arkit_tongue"):
        tongue_takes(replace(one, values=still), one)
    with pytest.raises(StudyError, match="two lines have other channels"):
        tongue_takes(one, replace(one, channels=tuple(reversed(one.channels))))
    with pytest.raises(StudyError, match="needs two lines or more"):
        partners(1)
