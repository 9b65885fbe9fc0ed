"""Units of time and starts: checked against sense, decided by the recording, set by hand."""

from __future__ import annotations

import wave
from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.errors import AlignmentError, OptionError
from phonanim.inputs.alignment import read_alignment
from phonanim.inputs.speech_input import sound_from
from phonanim.media.audio import Sound, read_sound
from phonanim.speech.alignment import Alignment
from phonanim.speech.clock import parse_offset, parse_unit

MILLISECONDS = "0 200 sil\n200 300 b\n300 500 iy\n500 600 m\n600 1000 sil\n"


def recording(folder: Path, seconds: float, name: str = "x.wav", rate: int = 8000) -> Path:
    with wave.open(str(folder / name), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(rate)
        stream.writeframes(bytes(2 * round(seconds * rate)))
    return folder / name


def rows(unit: float, offset: float = 0.0, points: bool = False) -> str:
    times = ((0.2, 0.3, "b"), (0.3, 0.5, "iy"), (0.5, 0.6, "m"), (0.6, 1.0, "sil"))
    shape = ".3f" if points else ".0f"
    return "".join(f"{(s + offset) / unit:{shape}} {(e + offset) / unit:{shape}} {x}\n" for s, e, x in times)


def saved(folder: Path, text: str, name: str = "x.lab") -> Path:
    (folder / name).write_text(text)
    return folder / name


@pytest.mark.parametrize(
    ("text", "name", "likely"),
    [
        (MILLISECONDS, "x.lab", r"lasts 8.3 ms on average, .* likely ms: give --unit ms, or"),
        (
            "".join(f"{24_000 * n} {24_000 * n + 24_000} {x}\n" for n, x in enumerate("bimba")),
            "x.lab",
            r"likely samples@48000: give --unit samples@48000 \(with the recording's rate\)",
        ),
        (rows(1e-3, points=True), "x.txt", r"lasts 133 s on average, .* likely ms: give --unit ms"),
        (
            "".join(f"{n}.0 {n + 1}.0 {x}\n" for n, x in enumerate("bimba")),
            "x.txt",
            r"lasts 1 s .*; give --unit s, ms",
        ),
    ],
)
def test_times_that_no_speech_has_are_refused_with_the_likely_unit(
    tmp_path: Path, text: str, name: str, likely: str
) -> None:
    with pytest.raises(AlignmentError, match=likely):
        read_alignment(saved(tmp_path, text, name))


@pytest.mark.parametrize("unit", ["ms", "samples@96000", "100ns", "s"])
def test_a_unit_given_by_hand(tmp_path: Path, unit: str) -> None:
    seconds = parse_unit(unit)
    path = saved(tmp_path, rows(seconds, points=unit == "s"))
    found = read_alignment(path, unit=unit)
    assert (found.intervals[0].start, found.duration) == pytest.approx((0.2, 1.0), abs=1e-3)


def test_the_recording_decides_the_unit_and_says_so(tmp_path: Path) -> None:
    found = read_alignment(saved(tmp_path, MILLISECONDS), audio=recording(tmp_path, 1.0))
    assert found.intervals[2].start == pytest.approx(0.3)
    assert found.notes == (
        "times were read as ms, to match the recording: it lasts 1.00 s, and the alignment then 1.00 s",
    )
    with pytest.raises(AlignmentError, match="give --unit ms"):
        read_alignment(saved(tmp_path, MILLISECONDS), audio=recording(tmp_path, 3.0))


def test_samples_of_another_rate_are_told_by_the_recording(tmp_path: Path) -> None:
    path = saved(tmp_path, rows(1 / 44_100, 2.0))
    found = read_alignment(path, audio=recording(tmp_path, 3.0))
    assert found.intervals[0].start == pytest.approx(2.2, abs=1e-3)
    assert found.notes[0].startswith("times were read as samples@44100")


def test_song_and_short_files_are_no_wrong_units(tmp_path: Path) -> None:
    sung = "0.0 0.1 m\n0.1 2.0 a\n2.0 2.1 n\n2.1 4.5 o\n"
    assert read_alignment(saved(tmp_path, sung)).duration == 4.5
    assert read_alignment(saved(tmp_path, "0.0 3.0 a\n")).duration == 3.0


def test_a_part_whose_recording_was_cut_out_starts_at_0(tmp_path: Path) -> None:
    path = saved(tmp_path, rows(1.0, 0.7, points=True))
    found = read_alignment(path, audio=recording(tmp_path, 0.8))
    assert found.offset == pytest.approx(0.9)
    assert found.intervals[0].start == 0
    told = "where the file starts: the recording lasts 0.80 s, as the part from there does"
    assert found.notes == (f"times are counted from 0.9 s, {told}",)
    whole = read_alignment(path, audio=recording(tmp_path, 1.7))
    assert (whole.offset, whole.notes) == (0.0, ())


def test_lengths_that_do_not_fit_are_told(tmp_path: Path) -> None:
    path = saved(tmp_path, rows(1.0, points=True))
    for seconds, told in ((0.3, 1), (0.8, 0), (1.0, 0), (1.9, 0), (2.5, 1)):
        notes = read_alignment(path, audio=recording(tmp_path, seconds)).notes
        assert len(notes) == told, notes
        assert all("check that they belong together" in note for note in notes)


def test_an_offset_given_by_hand(tmp_path: Path) -> None:
    found = read_alignment(saved(tmp_path, rows(1.0, points=True)), offset=0.25)
    assert (found.intervals[0].end, found.offset) == (pytest.approx(0.05), 0.25)
    assert found.notes == ("times are counted from 0.25 s, as set by --offset",)


def test_the_sound_of_a_part(tmp_path: Path) -> None:
    sound = read_sound(recording(tmp_path, 4.0))
    part = Alignment((), 1.0, "phones", "x", offset=2.5)
    assert sound_from(sound, part).duration == pytest.approx(1.5)
    short = Sound(sound.samples[:8000], 8000)
    assert sound_from(short, part) is short


def test_options_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = str(saved(tmp_path, MILLISECONDS)), str(tmp_path / "x.csv")
    assert run(["animate", path, "-o", out]) == 2
    assert run(["animate", path, "-o", out, "--unit", "ms", "--offset", "0.1"]) == 0
    capsys.readouterr()
    assert run(["animate", path, "-o", out, "--unit", "miles"]) == 2
    assert "give s, ms, 100ns or samples@RATE, such as samples@16000" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "samples@0", "frames", "-1"])
def test_units_that_are_none(text: str) -> None:
    with pytest.raises(OptionError, match="unit = .*; give s, ms, 100ns or samples@RATE"):
        parse_unit(text)


@pytest.mark.parametrize("text", ["x", "-1", "nan", "1e9"])
def test_offsets_that_are_none(text: str) -> None:
    with pytest.raises(OptionError, match="offset = .*; give seconds from 0 to 86400"):
        parse_offset(text)
    assert parse_offset("1.5") == 1.5


def test_speech_far_from_the_start_is_told(tmp_path: Path) -> None:
    rows = [(5000.1, 5000.2, "m"), (5000.2, 5000.4, "aɪ"), (5000.4, 5000.5, "p")]
    path = tmp_path / "x.txt"
    path.write_text("".join(f"{a}\t{b}\t{c}\n" for a, b, c in rows))
    (note,) = read_alignment(path).notes
    assert note.startswith(
        "there is no speech before 5000.10 s; where the recording was cut out there, give "
    )
    assert note.endswith("--offset 5000")


def test_a_rate_of_samples_that_is_guessed_is_told(tmp_path: Path) -> None:
    rows = "0 2646 sil\n2646 5292 m\n5292 7938 a\n7938 10584 p\n"
    (tmp_path / "x.lab").write_text(rows)
    (tmp_path / "x.phn").write_text(rows)
    assert read_alignment(tmp_path / "x.lab").notes == (
        "times were read as samples at 16000 Hz, as in TIMIT; --unit samples@RATE sets another rate",
    )
    assert read_alignment(tmp_path / "x.phn").notes == ()
