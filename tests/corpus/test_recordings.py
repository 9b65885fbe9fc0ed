"""Films become recordings that `build_corpus` reads; those that cannot are left out and told."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from films import FRAMES, fake_tracker, head_shape, make_film, put_alignment

from phonanim.__main__ import run
from phonanim.corpus import tracking
from phonanim.corpus.corpus import build_corpus, load_corpus, read_clips, read_landmarks
from phonanim.corpus.recordings import choose_test_clips, make_recordings
from phonanim.errors import CorpusError
from phonanim.media.video import open_film

pytest.importorskip("av")


def films(folder: Path, *names: str) -> list[Path]:
    paths = [make_film(folder / f"{name}.mp4") for name in names]
    for path in paths:
        put_alignment(path)
    return paths


def test_recordings_become_a_corpus(tmp_path: Path) -> None:
    report = make_recordings(films(tmp_path, "a", "b", "c"), tmp_path / "rec", fake_tracker(), test=0.34)
    assert [clip.name for clip in report.clips] == ["a", "b", "c"]
    build_corpus(tmp_path / "rec", tmp_path / "corpus")
    corpus = load_corpus(tmp_path / "corpus")
    assert corpus.frames.tolist() == [FRAMES] * 3
    assert corpus.split == ("train", "test", "train")
    assert corpus.tracks[0].labels == ("sil", "M", "AA", "sil")
    assert corpus.words[0][0].label == "ma"


def test_landmarks_are_kept_to_an_eighth_of_a_pixel(tmp_path: Path) -> None:
    make_recordings(films(tmp_path, "a"), tmp_path / "rec", fake_tracker())
    points, indices, fps = read_landmarks(tmp_path / "rec", read_clips(tmp_path / "rec"))
    truth = np.stack([head_shape(n) for n in range(FRAMES)]) * [1, -1, -1]
    assert (fps, len(indices)) == (25.0, truth.shape[1])
    assert np.abs(points - truth).max() <= 0.0626


def test_the_film_of_the_mouth_holds_the_lower_face(tmp_path: Path) -> None:
    make_recordings(films(tmp_path, "a"), tmp_path / "rec", fake_tracker())
    row = read_clips(tmp_path / "rec")[0]
    assert open_film(tmp_path / "rec" / "mouth" / "a.mp4").frames == FRAMES
    lips = head_shape(0)[[13, 14, 61, 291], :2] - [int(row["crop_x"]), int(row["crop_y"])]
    assert lips.min() > 0


def test_the_same_films_give_the_same_bytes(tmp_path: Path) -> None:
    paths = films(tmp_path, "a", "b")
    for name in ("one", "two"):
        make_recordings(paths, tmp_path / name, fake_tracker())
    written = sorted(p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*") if p.is_file())
    assert len(written) == 4 + 2 * 3
    assert all((tmp_path / "one" / p).read_bytes() == (tmp_path / "two" / p).read_bytes() for p in written)


def test_what_was_bridged_is_in_the_report(tmp_path: Path) -> None:
    put_alignment(make_film(tmp_path / "a.mp4", dark=(3,)))
    make_recordings([tmp_path / "a.mp4"], tmp_path / "rec", fake_tracker())
    facts = json.loads((tmp_path / "rec" / "quality.json").read_text())
    assert facts["clips"][0]["bridged"] == {"3": "no face was found"}
    assert "frame 3: no face was found, bridged" in (tmp_path / "rec" / "quality.txt").read_text()


def test_a_film_that_cannot_be_used_leaves_nothing_behind(tmp_path: Path) -> None:
    good, bad = *films(tmp_path, "good"), make_film(tmp_path / "bad.mp4", dark=tuple(range(FRAMES)))
    put_alignment(bad)
    report = make_recordings([bad, good], tmp_path / "rec", fake_tracker())
    assert [(film.film.name, "no face was found" in film.why) for film in report.rejected] == [
        ("bad.mp4", True)
    ]
    assert not list((tmp_path / "rec").rglob("bad.*"))
    assert "rejected: " in (tmp_path / "rec" / "quality.txt").read_text()


def why(film: Path) -> str:
    with pytest.raises(CorpusError, match="none of the 1 videos can be used; the first: ") as caught:
        make_recordings([film], film.parent / "rec", fake_tracker())
    assert not (film.parent / "rec").exists()
    return str(caught.value)


def test_no_text(tmp_path: Path) -> None:
    assert "a.mp4: no text; write the spoken words to a.txt next to it" in why(make_film(tmp_path / "a.mp4"))


def test_no_sound(tmp_path: Path) -> None:
    film = make_film(tmp_path / "a.mp4", sound=False)
    put_alignment(film)
    assert "a.mp4: has no audio track" in why(film)


def test_an_alignment_of_another_length(tmp_path: Path) -> None:
    film = make_film(tmp_path / "a.mp4")
    put_alignment(film, stretch=2)
    assert "a.TextGrid: lasts 1.60 s and the video 0.80 s; align it again" in why(film)


def test_a_text_that_is_not_utf8(tmp_path: Path) -> None:
    film = make_film(tmp_path / "a.mp4")
    film.with_suffix(".txt").write_bytes(b"\xffma")
    assert "a.txt: cannot be read: it is not UTF-8 text (byte 0); save it as UTF-8" in why(film)


def test_a_text_that_nobody_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("phonanim.aligners.pocketsphinx.can_speak", lambda: False)
    monkeypatch.setitem(sys.modules, "soundfile", None)  # the extra `track` does not bring it
    pytest.importorskip("pocketsphinx")
    film = make_film(tmp_path / "a.mp4")
    film.with_suffix(".txt").write_text("xqzzt")
    assert "a.txt: not in the pronouncing dictionary: 'xqzzt'" in why(film)
    film.with_suffix(".txt").write_text("a very long sentence that cannot be said in so short a time " * 3)
    assert "a.txt: the text cannot be found in the audio" in why(film)


def test_two_films_of_one_name(tmp_path: Path) -> None:
    with pytest.raises(CorpusError, match="a: two videos have this name; rename one"):
        make_recordings([tmp_path / "a.mp4", tmp_path / "a.mov"], tmp_path / "rec", fake_tracker())


def test_films_of_two_rates(tmp_path: Path) -> None:
    first = films(tmp_path, "a")[0]
    second = make_film(tmp_path / "b.mp4", rate=20)
    put_alignment(second, stretch=1.25)
    report = make_recordings([first, second], tmp_path / "rec", fake_tracker())
    assert (
        "b.mp4: has 20 frames per second and a.mp4 25; convert it: ffmpeg -i b.mp4 -vf fps=25 "
        in report.rejected[0].why
    )


def test_test_clips_are_spread_and_never_all() -> None:
    assert choose_test_clips(4, 0.5) == ["train", "test", "train", "test"]
    assert choose_test_clips(1, 0.5) == ["train"]
    assert choose_test_clips(20, 0.1).count("test") == 2


def test_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tracking, "mediapipe_tracker", lambda indices: fake_tracker())
    paths = [str(path) for path in (*films(tmp_path, "a"), make_film(tmp_path / "b.mp4"))]
    assert run(["corpus", "track", *paths, "-o", str(tmp_path / "rec"), "--json"]) == 1
    facts = json.loads(capsys.readouterr().out)
    assert facts["clips"] == ["a"]
    assert "b.mp4: no text" in facts["rejected"][0]["why"]
    assert run(["corpus", "track", paths[0], "-o", str(tmp_path / "rec"), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert run(["corpus", "track", paths[1], "-o", str(tmp_path / "no")]) == 2
    assert "none of the 1 videos can be used" in capsys.readouterr().err
