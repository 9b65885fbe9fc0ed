"""Features are kept on disk, and made again when the file is damaged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from encoder_samples import Loudness, speech

from phonanim.encoders import encode
from phonanim.encoders._cache import cache_folder, fingerprint
from phonanim.errors import OutputError
from phonanim.media.audio import Sound


def test_features_are_kept_and_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    lengths: list[int] = []
    sound = speech()
    first = encode(Loudness(lengths), sound)
    assert np.array_equal(encode(Loudness(lengths), sound).values, first.values)
    assert len(lengths) == 1
    encode(Loudness(lengths, identity="another"), sound)
    encode(Loudness(lengths), Sound(sound.samples, 8000))
    assert len(lengths) == 3
    assert len(list((tmp_path / "features").iterdir())) == 3


@pytest.mark.parametrize("damage", [b"", b"\x93NUMPY\x01", "cut", "objects"])
def test_damaged_features_are_made_again(
    damage: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    lengths: list[int] = []
    values = np.array(encode(Loudness(lengths), speech()).values)
    path = next((tmp_path / "features").iterdir())
    if damage == "objects":
        np.save(path, values.astype(object))
    else:
        path.write_bytes(path.read_bytes()[:-40] if damage == "cut" else damage)
    assert np.array_equal(encode(Loudness(lengths), speech()).values, values)
    assert len(lengths) == 2


def test_nothing_half_made_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))

    class Broken(Loudness):
        def run(self, samples: np.ndarray) -> np.ndarray:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        encode(Broken([]), speech())
    assert list((tmp_path / "features").iterdir()) == []


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path / "file"))
    with pytest.raises(OutputError, match=r"features: cannot be created .*; set PHONANIM_CACHE to a folder"):
        encode(Loudness([]), speech())


@pytest.mark.parametrize(
    ("platform", "variable", "end"),
    [("linux", "XDG_CACHE_HOME", "base/phonanim"), ("win32", "LOCALAPPDATA", "base/phonanim")],
)
def test_where_features_are_kept(
    platform: str, variable: str, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PHONANIM_CACHE", raising=False)
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setenv(variable, "base")
    assert cache_folder() == Path(end)
    monkeypatch.setattr("sys.platform", "darwin")
    folder = cache_folder()
    assert folder is not None
    assert folder.as_posix().endswith("Library/Caches/phonanim")


def test_the_fingerprint_is_of_sound_and_encoder() -> None:
    sound = speech()
    other = Sound(sound.samples + np.float32(1e-3), sound.rate)
    found = {fingerprint("a", sound), fingerprint("b", sound), fingerprint("a", other)}
    assert len(found) == 3
