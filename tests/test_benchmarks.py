"""The scripts of benchmarks/ still import, tell what they need, and run to their end on small inputs."""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from speech import random_track, sound_of, write_wav

from phonanim.corpus.corpus import Corpus, save_corpus
from phonanim.pipeline import load_model
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"
SCRIPTS = sorted(
    path.name for path in FOLDER.glob("*.py") if 'if __name__ == "__main__"' in path.read_text("utf-8")
)
EXAMPLES = FOLDER.parent / "examples"
LINE = str(EXAMPLES / "line.TextGrid")
CLIPS = 8


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Run a script as `python benchmarks/NAME WORD...` does, in this process."""
    stems = {path.stem for path in FOLDER.glob("*.py")}
    hidden = {name: sys.modules.pop(name) for name in stems & set(sys.modules)}  # tests/support has a `takes`
    known, environment = set(sys.modules), dict(os.environ)

    def run(name: str, *words: str) -> None:
        monkeypatch.setattr(sys, "argv", [str(FOLDER / name), *words])
        monkeypatch.setattr(sys, "path", [str(FOLDER), *sys.path])
        try:
            runpy.run_path(str(FOLDER / name), run_name="__main__")
        except SystemExit as end:
            if end.code:
                pytest.fail(f"{name} ends with {end.code}")

    yield run
    for name in set(sys.modules) - known:  # they have names that others may have too
        if Path(getattr(sys.modules[name], "__file__", None) or "").parent == FOLDER:
            del sys.modules[name]
    sys.modules.update(hidden)
    os.environ.clear()
    os.environ.update(environment)


@pytest.mark.parametrize("name", SCRIPTS)
def test_each_tells_its_use(
    name: str, script: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    script(name, "--help")
    assert "usage: " in capsys.readouterr().out.lower()


def test_each_is_named_where_its_figures_are() -> None:
    pages = "".join(page.read_text("utf-8") for page in (FOLDER.parent / "docs").rglob("*.md"))
    assert [name for name in SCRIPTS if f"benchmarks/{name}" not in pages] == []


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings with textgrid/ and audio/, and their corpus, whose faces are those of the default model."""
    folder, rng, model = (
        tmp_path_factory.mktemp("recordings"),
        np.random.default_rng(0),
        load_model("default"),
    )
    tracks = tuple(random_track(rng) for _ in range(CLIPS))
    names = tuple(f"clip{number}" for number in range(CLIPS))
    frames = np.array([int(track.duration * 25) for track in tracks])
    for kind in ("textgrid", "audio"):
        (folder / kind).mkdir()
    for name, track in zip(names, tracks, strict=True):
        spans = zip(track.labels, track.bounds, track.bounds[1:], strict=False)
        phones = [Interval(label, float(begin), float(end)) for label, begin, end in spans]
        write_textgrid(folder / "textgrid" / f"{name}.TextGrid", {"phones": phones}, float(track.duration))
        write_wav(folder / "audio" / f"{name}.wav", sound_of(track, 16000))
    modes = [model.predict(track, 25.0, int(n), 0.02) for track, n in zip(tracks, frames, strict=True)]
    corpus = Corpus(
        landmarks=model.face.instance(np.concatenate(modes)).astype(np.float32),
        indices=model.face.indices,
        fps=25.0,
        clips=names,
        frames=frames,
        tracks=tracks,
        words=tuple((Interval("said", 0.1, float(track.duration)),) for track in tracks),
        split=("train",) * (CLIPS - 3) + ("test",) * 3,
        audio=tuple(folder / "audio" / f"{name}.wav" for name in names),
        provenance={"source": "made up"},
    )
    save_corpus(corpus, folder / "corpus")
    return folder


@pytest.mark.parametrize(
    ("name", "words", "told"),
    [
        ("layers.py", [LINE], "| smooth 0.1 s |"),
        ("life.py", [LINE, "--minutes", "0.3", "--seeds", "1"], "| blinks a minute, talking |"),
        ("audio.py", ["encoding", str(EXAMPLES / "line.wav"), "mfcc"], "mfcc: "),
    ],
)
def test_each_runs_on_a_line(
    name: str,
    words: list[str],
    told: str,
    script: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    script(name, *words)
    assert told in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "words", "told"),
    [
        ("phones.py", ["corpus"], "modes leave 0.0"),
        ("retarget.py", ["corpus", "--model", "default", "--timed", "100"], "| aperture r face | "),
        ("loudness.py", ["corpus"], "| captured | "),
        ("legibility_rigs.py", ["corpus", "--rig", "arkit"], "| `arkit` |"),
        ("stream_loudness.py", ["textgrid", "audio"], "8 lines"),
        ("tools.py", ["corpus", "."], "rhubarb"),
    ],
)
def test_each_runs_on_a_corpus(
    name: str,
    words: list[str],
    told: str,
    script: Callable[..., None],
    recordings: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(recordings)
    script(name, *words)
    assert told in capsys.readouterr().out
