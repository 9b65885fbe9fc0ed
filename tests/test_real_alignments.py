"""Alignments as users have them: each is read, or refused by one line that is right."""

from __future__ import annotations

import tarfile
from pathlib import Path

import pytest

from phonanim.alignment import read_alignment
from phonanim.language import to_phones

# Every 30th of 4000: the whole archives take about five seconds.
EACH = 30


@pytest.mark.parametrize("archive", ["ljspeech_mfa_3000.tar.xz", "spanish_mfa_1000.tar.xz"])
def test_natural_text_has_no_unknown_label(shared_data: Path, tmp_path: Path, archive: str) -> None:
    with tarfile.open(shared_data / "textgrids" / archive) as tar:
        members = [member for member in tar.getmembers() if member.isfile()][::EACH]
        assert len(members) > 30
        for member in members:
            content = tar.extractfile(member)
            assert content is not None
            path = tmp_path / "x.TextGrid"
            path.write_bytes(content.read())
            track, _ = to_phones(read_alignment(path))
            assert track.duration > 0.5
            assert len(track.codes) > 5, member.name


def test_the_recordings_that_train_the_model(shared_data: Path) -> None:
    paths = sorted((shared_data / "grid_s1" / "textgrid").glob("*.TextGrid"))[::EACH]
    for path in paths:
        alignment = read_alignment(path)
        track, notes = to_phones(alignment, "english")
        assert notes == ()
        assert len(alignment.words) > 5
        assert track.duration == pytest.approx(2.978, abs=0.03)


def test_german_articulography(shared_data: Path) -> None:
    for path in sorted((shared_data / "ema_de").glob("*_bndl.json")):
        alignment = read_alignment(path)
        track, notes = to_phones(alignment, "german")
        assert notes == ()
        assert len(track.codes) == len(alignment.intervals)
