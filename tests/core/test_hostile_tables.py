"""Tables and caches with any value at any place end in a result or in one line that names the file."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hostile import LEAVES, damaged
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from phonanim.articulation.table import CHANNELS_FILE, read_targets
from phonanim.comparison.conditions import _read_phones
from phonanim.comparison.fit import read_job
from phonanim.ema.channels import load_recordings
from phonanim.encoders._transformers import _normalized
from phonanim.errors import PhonanimError
from phonanim.evaluation.legibility import READER_FILE, load_reader
from phonanim.life.parsing import read_emotions
from phonanim.rig.accents import read_accents
from phonanim.rig.landmarks import SHIPPED, read_landmarks
from phonanim.rig.measures import read_measures
from phonanim.rig.motion import SHIPPED as MOTION
from phonanim.rig.motion import read_motion
from phonanim.rig.names import read_names
from phonanim.rig.read import load_rig
from phonanim.rig.tongue import read_tongue
from phonanim.training.losses import read_losses

RIG = load_rig("arkit_tongue")
LEXICON = CHANNELS_FILE.parent
RIGS = LEXICON / "rigs"
quickly = settings(
    max_examples=12,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def head_of(path: Path, rows: int = 6) -> list[list[str]]:
    return [line.split(",") for line in path.read_text("utf-8").splitlines()[:rows]]


TABLES: dict[str, tuple[Any, list[list[str]]]] = {
    "emotions": (
        read_emotions,
        [["emotion", "weight", "start", "end"], ["joy", "0.5", "0", "1"], ["anger", "1", "1", "2"]],
    ),
    "names": (
        lambda path: read_names([path]),
        [["shape", "control", "weight"], ["Mund", "jawOpen", "1"], ["spitz", "mouthPucker", "0.5"]],
    ),
    "accents": (
        lambda path: read_accents.__wrapped__(path, RIG.controls),
        [["phones", "control", "amount"], ["f v", "mouthRollLower", "0.3"]],
    ),
    "tongue": (
        lambda path: read_tongue.__wrapped__(path, RIG.controls),
        head_of(next(RIGS.glob("*tongue*.csv"))),
    ),
    "measures": (lambda path: read_measures(path, RIG.controls), head_of(next(RIGS.glob("arkit*mouth.csv")))),
    "landmarks": (read_landmarks, head_of(SHIPPED)),
    "motion": (read_motion, head_of(MOTION)),
    "targets": (lambda path: read_targets.__wrapped__(path), head_of(LEXICON / "articulation.csv")),
    "channels": (
        lambda path: read_targets.__wrapped__(LEXICON / "articulation.csv", path),
        head_of(CHANNELS_FILE, 20),
    ),
    "reader": (lambda path: load_reader.__wrapped__(path), head_of(READER_FILE, 20)),
    "losses": (read_losses, [["epoch", "loss", "error"], ["1", "2", "3"], ["2", "1", "2"]]),
}
CACHES: dict[str, tuple[Any, Any]] = {
    "job.json": (lambda path: read_job(path.parent), {"key": "a", "seconds": 1.5, "settings": {}}),
    "phones.json": (_read_phones, [["AA", 0.0, 0.5], ["B", 0.5, 0.6]]),
    "preprocessor_config.json": (lambda path: _normalized(path.parent), {"do_normalize": False}),
}


def ends_well(call: Any, path: Path) -> None:
    try:
        call(path)
    except PhonanimError as error:
        told = str(error)
    else:
        return
    assert str(path) in told
    assert len(told.splitlines()) == 1


@pytest.mark.parametrize("name", TABLES)
@given(data=st.data())
@quickly
def test_tables(tmp_path: Path, name: str, data: st.DataObject) -> None:
    read, rows = TABLES[name]
    changed = data.draw(damaged(rows, LEAVES))
    lines = [",".join(map(str, row)) if isinstance(row, list) else str(row) for row in changed]
    path = tmp_path / "t.csv"
    path.write_bytes("\n".join(lines).encode("utf-8", "replace"))
    ends_well(read, path)


@pytest.mark.parametrize("name", CACHES)
@given(data=st.data())
@quickly
def test_caches(tmp_path: Path, name: str, data: st.DataObject) -> None:
    read, tree = CACHES[name]
    (tmp_path / name).write_text(json.dumps(data.draw(damaged(tree))))
    ends_well(read, tmp_path / name)


def test_sound_tables_and_caches_are_read(tmp_path: Path) -> None:
    for name in ("emotions", "names", "accents", "landmarks", "motion", "losses"):
        read, rows = TABLES[name]
        (tmp_path / "t.csv").write_text("\n".join(map(",".join, rows)), "utf-8")
        assert read(tmp_path / "t.csv") is not None
    for name, (read, tree) in CACHES.items():
        (tmp_path / name).write_text(json.dumps(tree))
        assert read(tmp_path / name) is not None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize("name", [*TABLES, *CACHES])
def test_pipes_are_refused_and_not_waited_for(tmp_path: Path, name: str) -> None:
    read = (TABLES | CACHES)[name][0]
    path = tmp_path / (name if name in CACHES else "t.csv")
    os.mkfifo(path)
    with pytest.raises(PhonanimError, match=r"pipe or a device"):
        read(path)


@pytest.mark.parametrize("data", [b"", b"PK\x03\x04" + bytes(40), b"x" * 100])
def test_sensors_that_are_no_arrays(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.npz").write_bytes(data)
    with pytest.raises(PhonanimError, match=r"a\.npz"):
        list(load_recordings(tmp_path))
