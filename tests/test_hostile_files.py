"""Files with any value at any place end in a result or in one line: takes, characters, rigs, tables, ..."""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path
from typing import Any

import pytest
from animations import line, vowels
from hostile import LEAVES, damaged
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.hostile import small_character
from phonanim.core.catalog import SHIPPED
from phonanim.dubbing.ledger import NAME, read_ledger
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.report import count_totals, html_page
from phonanim.dubbing.reserve import reserve_outputs
from phonanim.dubbing.row import Common
from phonanim.errors import PhonanimError
from phonanim.exporters import load, save
from phonanim.exporters._document import document
from phonanim.media.glb import parse_glb
from phonanim.media.gltf_text import data_uri
from phonanim.regressors import make_config
from phonanim.rig.character import load_character
from phonanim.rig.read import load_rig

quickly = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
GLB = parse_glb(small_character(), "a.glb")
TAKE = document(line(frames=3))
TRACK = {
    "format": "openfacefx.track",
    "version": 1,
    "fps": 60,
    "viseme_set": ["a"],
    "channels": [{"name": "a", "keys": [[0, 0], [1, 1]]}],
}
CARD = json.loads((SHIPPED / "default/model.json").read_text())
KIND, CONFIG = CARD["kind"], CARD["config"]
FACTS = {"frames": 3, "seconds": 0.1, "phones": 2, "flags": [{"check": "a", "text": "b", "severity": 0.5}]}
OUTCOME = {"id": "a", "place": "b", "origin": {}, "outputs": {"a.csv": "0"}, "facts": FACTS, "error": ""}
ROW = {"id": "a", "alignment": "a.TextGrid", "fps": "25", "gain": "jawOpen=1", "smooth": "0", "rig": "arkit"}
POSES = ("mean", *(f"mode{number}_{side}" for number in range(1, 5) for side in ("minus", "plus")))
RIG = {
    "name": "mine",
    "speech": ["a"],
    "controls": {"a": [0, 0, 1], "b": [0, 0, 1]},
    "at_most": {"a": "b"},
    "poses": {pose: {"a": number / 10} for number, pose in enumerate(POSES)},
}


def ends_well(call: Any, path: Path) -> Any:
    """What a call gives, or None for an error of one line that names the file."""
    try:
        return call(path)
    except PhonanimError as error:
        told = str(error)
    assert str(path) in told
    assert len(told.splitlines()) == 1
    return None


@given(damaged(TAKE))
@quickly
def test_takes(tmp_path: Path, tree: Any) -> None:
    (tmp_path / "a.json").write_text(json.dumps(tree))
    found = ends_well(load, tmp_path / "a.json")
    if found is not None:
        assert found.audio is None or found.audio.parent == tmp_path
        assert 0 < found.fps <= 1000
        assert abs(found.start) <= 1e6


@given(damaged(TRACK))
@quickly
def test_tracks(tmp_path: Path, tree: Any) -> None:
    (tmp_path / "a.track.json").write_text(json.dumps(tree))
    ends_well(load, tmp_path / "a.track.json")


EXPORT = {"exportFps": 30, "facsNames": ["a", "b"], "weightMat": [[0, 1], [1, 0]]}
GLTF = {**GLB.tree, "buffers": [{"uri": data_uri(GLB.binary)}], "images": [{"uri": "a.png"}]}


@given(damaged(EXPORT))
@quickly
def test_exports_of_audio2face(tmp_path: Path, tree: Any) -> None:
    (tmp_path / "a.a2f.json").write_text(json.dumps(tree))
    ends_well(load, tmp_path / "a.a2f.json")


@given(st.integers(0, 50 + 4 + 2 * 111 + 4 + 10 * 23), st.binary(min_size=1, max_size=8))
@quickly
def test_motion(tmp_path: Path, place: int, noise: bytes) -> None:
    save(vowels(frames=2, fps=30), tmp_path / "a.vmd")
    data = (tmp_path / "a.vmd").read_bytes()
    (tmp_path / "a.vmd").write_bytes(data[:place] + noise + data[place + len(noise) :])
    ends_well(load, tmp_path / "a.vmd")
    (tmp_path / "a.vmd").write_bytes(data[:place])
    ends_well(load, tmp_path / "a.vmd")


@given(damaged(GLTF))
@quickly
def test_characters_as_text(tmp_path: Path, tree: Any) -> None:
    (tmp_path / "a.png").write_bytes(b"picture")
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    ends_well(load_character, tmp_path / "a.gltf")


@given(st.data())
@quickly
def test_characters(tmp_path: Path, data: st.DataObject) -> None:
    text = json.dumps(data.draw(damaged(GLB.tree))).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(GLB.binary), 0x004E4942) + GLB.binary
    path = tmp_path / "a.glb"
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    ends_well(load_character, path)
    ends_well(load, path)


@given(damaged(RIG))
@quickly
def test_rigs(tmp_path: Path, tree: Any) -> None:
    (tmp_path / "a.toml").write_bytes(toml(tree).encode("utf-8", "replace"))
    ends_well(load_rig, tmp_path / "a.toml")


def toml(tree: dict[str, Any]) -> str:
    """A tree as TOML, every table in one line; JSON's texts and numbers are TOML's."""
    return "".join(f"{json.dumps(key)} = {_value(value)}\n" for key, value in tree.items())


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return '""' if value is None else json.dumps(value).replace("Infinity", "inf").replace("NaN", "nan")


@given(damaged(CONFIG, LEAVES))
@quickly
def test_settings_of_models(tree: Any) -> None:
    config = ends_well(lambda path: make_config(KIND, tree, str(path)), Path("model.json"))
    assert config is None or getattr(config, "networks", 0) <= 4096


@given(damaged(OUTCOME))
@quickly
def test_ledgers(tmp_path: Path, tree: Any) -> None:
    (tmp_path / NAME).write_text(json.dumps(tree) + "\n")
    found = list(read_ledger(tmp_path).values())
    html_page(count_totals(found), found, ())


@given(st.lists(damaged(ROW), min_size=1, max_size=3))
@quickly
def test_tables(tmp_path: Path, rows: list[Any]) -> None:
    (tmp_path / "a.TextGrid").write_text("x")
    (tmp_path / "t.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    found = ends_well(lambda path: read_lines(str(path), Common()), tmp_path / "t.jsonl")
    if found is not None:
        kept = reserve_outputs(found, tmp_path / "out", ["csv"])
        assert len(kept.lines) + len(kept.faults) == len(rows)
        for fault in kept.faults:
            f"{fault.id}{fault.place}{fault.message}".encode()


@pytest.mark.skipif(sys.platform == "win32", reason="attacks run in forks")
# Takes most of a minute, and is not marked slow, because CI runs it each time.
def test_no_attack_of_the_small_suite_finds_a_fault(root: Path) -> None:
    import subprocess

    command = [sys.executable, str(root / "benchmarks/attack.py"), "--small"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 faults" in done.stdout


def test_a_fault_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("resource")
    from benchmarks import attack

    def crash() -> int:
        raise ZeroDivisionError

    monkeypatch.setattr("phonanim.__main__.run", crash)
    with attack.counted_connections() as connections:
        end = attack.carry_out(lambda folder: ["models"], tmp_path / "work", connections)
    assert (end.kind, end.why) == ("fault", "ZeroDivisionError")
