"""Every file is read by the right reader or refused in one line, whatever its bytes."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from alignment_samples import SAMPLES, Sample
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from timing_samples import EVERY, PHONED, WORDS_ALONE

from phonanim.errors import AlignmentError, PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.readers import find_reader, load_reader, reader_names
from phonanim.speech import alignment_file
from phonanim.speech.alignment import Interval
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones

EACH = [
    pytest.param(name, sample, id=f"{name}-{n}")
    for name, group in PHONED.items()
    for n, sample in enumerate(group)
]
WORDED = [
    pytest.param(name, sample, id=f"{name}-{n}")
    for name, group in WORDS_ALONE.items()
    for n, sample in enumerate(group)
]


def source(data: bytes) -> AlignmentFile:
    return AlignmentFile("x", "x", data)


def spans(intervals: tuple[Interval, ...]) -> list[tuple[str, Any, Any]]:
    return [(i.label, near(i.start), near(i.end)) for i in intervals]


def near(seconds: float) -> Any:
    """Within two samples of 10 kHz: formats differ in whether the last sample counts."""
    return pytest.approx(seconds, abs=2e-4)


def written(folder: Path, data: bytes, name: str = "x") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def test_every_reader_has_a_sample() -> None:
    assert set(EVERY) == set(reader_names())


@pytest.mark.parametrize("name", reader_names())
def test_readers_keep_the_contract(name: str) -> None:
    reader = load_reader(name)
    assert reader.FORMAT
    assert reader.__doc__
    for sample in EVERY[name]:
        assert load_reader(name).recognizes(source(sample.data))
        others = [other for other in map(load_reader, reader_names()) if other is not reader]
        assert not [
            other.__name__
            for other in others
            if not getattr(other, "GUESSES", False) and other.recognizes(source(sample.data))
        ]
        if name != "openutau" or find_spec("yaml"):
            assert reader.read(source(sample.data)).tiers


@pytest.mark.parametrize(("name", "sample"), EACH)
def test_samples_are_read_with_their_times(tmp_path: Path, name: str, sample: Sample) -> None:
    alignment = read_alignment(written(tmp_path, sample.data, sample.name))
    words = tuple(word for word in alignment.words if word.label not in ("", "SENT-START"))
    assert list(sample.phones) == spans(alignment.intervals)
    assert list(sample.words) == spans(words)
    assert len(alignment.notes) == sample.notes
    assert alignment.duration >= alignment.intervals[-1].end


@pytest.mark.parametrize(("name", "sample"), EACH)
def test_samples_close_and_open_the_lips(tmp_path: Path, name: str, sample: Sample) -> None:
    track, _ = to_phones(read_alignment(written(tmp_path, sample.data, sample.name)))
    spoken = [INVENTORY.phones[code] for code in track.codes if code]
    assert spoken[0] in ("b", "m", "p")
    assert {"m", "p"} & set(spoken[-2:])


@pytest.mark.parametrize(("name", "sample"), WORDED)
def test_words_alone_are_refused_without_a_dictionary(
    tmp_path: Path, name: str, sample: Sample, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("phonanim.speech.pronunciations.find_cmu_dictionary", lambda: None)
    monkeypatch.setattr("phonanim.speech.cmu_dictionary.find_cmu_dictionary", lambda: None)
    path = written(tmp_path, sample.data, "x.json")
    message = (
        r"x.json: has words but no phones; give a pronunciation dictionary \(--lexicon\), or .*\[align\]"
    )
    with pytest.raises(AlignmentError, match=message):
        read_alignment(path)


@pytest.mark.parametrize(("name", "sample"), WORDED)
def test_words_alone_are_spelled_with_a_dictionary(tmp_path: Path, name: str, sample: Sample) -> None:
    lexicon = written(tmp_path, b"beam B IY1 M\nme M IY1\n", "d.txt")
    alignment = read_alignment(written(tmp_path, sample.data), lexicon=lexicon)
    words = [word for word in alignment.words if word.label != "2"]  # which has no time
    assert spans(tuple(words)) == list(sample.words)
    spoken = [i for i in alignment.intervals if i.label in ("B", "IY1", "M")]
    assert spans(tuple(spoken[:1])) == [("B", near(0.2), near(0.2 + 0.4 / 3))]
    assert "".join(i.label for i in spoken).startswith("BIY1M")


DAMAGED = [
    ("emu", "10000", "0", r"is a damaged EMU annotation \(.*\); export it again"),
    ("emu", "10000", '"x"', r"is a damaged EMU annotation"),
    ("emu", '"sampleDur": 1999, ', "", r"is a damaged EMU annotation"),
    ("htk", "5000000 6000000 m -12", "5000000 oops m", r'row 4 "5000000 oops m" is damaged; correct it'),
    ("timit", "8000 9600 m", "8000 m", r'row 5 "8000 m" is damaged'),
    ("seconds", "0.500000\t0.600000\tM", "0.5 M", r'row 4 "0.5 M" is damaged'),
    ("xwaves", "0.500000  122 iy", "0.5 iy", r'row 3 "0.5 iy" is damaged'),
    ("ctm", "x 1 0.50 0.10 M_E", "x 1 0.50 M_E", r'row 4 "x 1 0.50 M_E" is damaged'),
    ("bas", "SAM: 10000", "SAM: 0", r"has no sampling rate \(SAM\); export it again"),
    ("elan", "</ANNOTATION_DOCUMENT>", "", r"is a damaged ELAN file \(no element found.*\); save it again"),
    ("elan", 'TIME_SLOT_REF1="ts1"', 'TIME_SLOT_REF1="ts9"', r"is a damaged ELAN file \('ts9'\)"),
    ("gentle", '"end": 0.6, ', "", r"is damaged Gentle output \(.*\); align again"),
    ("tiers_json", '[0.2, 0.6, "beam"]', "[0.2]", r"has a damaged tier \(.*\); export it again"),
    (
        "mfa_csv",
        "0.2,0.6,beam,words",
        "0.2,oops,beam,words",
        r"row 2 is damaged \(.*oops.*\); export it again",
    ),
    ("rhubarb", '"start": 0.3', '"start": "x"', r"has a damaged cue \(.*\); export it again"),
    ("moho", "13 E", "13", r'row 3 "13" is damaged'),
    ("moho", "\n1 rest\n7 MBP\n13 E\n19 MBP\n25 rest", "", r"has no frames; export it again"),
    ("papagayo", "12 E", "", r"is truncated or damaged; save it again"),
    ("papagayo", "\n24\n48", "\n0\n48", r"is truncated or damaged; save it again"),
]


@pytest.mark.parametrize(("name", "old", "new", "message"), DAMAGED)
def test_damage_is_told_with_its_place(name: str, old: str, new: str, message: str) -> None:
    content = SAMPLES[name][0].data.decode()
    assert old in content
    with pytest.raises(AlignmentError, match=rf"x: {message}"):
        load_reader(name).read(source(content.replace(old, new, 1).encode()))


def test_xwaves_with_a_beginning_alone() -> None:
    with pytest.raises(AlignmentError, match=r"x: has no labels; align the recording again"):
        load_reader("xwaves").read(source(b"signal x\n#\n0.0 125 H#\n"))


def test_circular_annotations() -> None:
    content = SAMPLES["elan"][1].data.decode()
    with pytest.raises(AlignmentError, match=r"annotations refer to each other in a circle"):
        load_reader("elan").read(
            source(content.replace('ANNOTATION_REF="a1"', 'ANNOTATION_REF="a3"').encode())
        )


def test_damaged_binary_grids(tmp_path: Path) -> None:
    data = SAMPLES["praat_binary"][0].data
    with pytest.raises(AlignmentError, match=r"x: is truncated or damaged; save it again"):
        read_alignment(written(tmp_path, data[:-3]))
    with pytest.raises(
        AlignmentError, match=r'x: contains a Praat object of class "TextGrim", not a TextGrid'
    ):
        read_alignment(written(tmp_path, data.replace(b"TextGrid", b"TextGrim")))


def test_words_without_numbers() -> None:
    with pytest.raises(AlignmentError, match=r"x: is a damaged list of words \(.*\); recognize again"):
        load_reader("words_json").read(source(b'{"result": [{"word": "a", "start": "x", "end": 1}]}'))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", r"is empty; align the recording again"),
        (b" \n\n", r"is empty; align the recording again"),
        (
            bytes(range(256)) * 4,
            r"is a binary file of an unknown format; readable formats: Praat TextGrid and",
        ),
        (b"RIFF\x00\x00", r"is a binary file"),
        (b"dear diary", r"is not an alignment in a known format; readable formats: Praat TextGrid and"),
        (b"{", r"is not an alignment in a known format"),
        (b"[" * 100_000, r"is not an alignment in a known format"),
    ],
)
def test_files_that_are_no_alignment(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "x.TextGrid"
    path.write_bytes(data)
    with pytest.raises(AlignmentError, match=rf"x.TextGrid: {message}"):
        read_alignment(path)


def test_a_folder_and_an_absent_file(tmp_path: Path) -> None:
    with pytest.raises(AlignmentError, match=r"is a folder; name one alignment file in it"):
        read_alignment(tmp_path)
    with pytest.raises(AlignmentError, match=r"x.TextGrid: cannot be read: No such file"):
        read_alignment(tmp_path / "x.TextGrid")
    with pytest.raises(AlignmentError, match=r"cannot be read: .*embedded null"):
        read_alignment(Path("\0"))


def test_an_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, most: int) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(alignment_file, "read_bounded", refuse)
    with pytest.raises(AlignmentError, match=r"x: cannot be read: Permission denied"):
        read_alignment(written(tmp_path, b"x"))


def test_a_vast_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alignment_file, "MAX_BYTES", 1 << 20)
    path = written(tmp_path, b"x" * (3 << 20))
    with pytest.raises(AlignmentError, match=r"x: cannot be read: it has more than 1 MB"):
        read_alignment(path)


ANY = [sample.data for samples in EVERY.values() for sample in samples]


def said_of(path: Path) -> str:
    """The one line that refuses a file, or one that says that all is well."""
    try:
        track, _ = to_phones(read_alignment(path), unknown="nearest")
    except PhonanimError as error:
        return str(error)
    rising = (track.bounds[1:] > track.bounds[:-1]).all()
    return f"{path}: {len(track.codes)} phones" if rising else "times do not rise"


@settings(max_examples=600, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_bytes_cause_a_traceback(tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(data.draw(st.sampled_from(ANY)))
    for _ in range(data.draw(st.integers(0, 6))):
        place = data.draw(st.integers(0, max(len(content) - 1, 0)))
        length = data.draw(st.sampled_from([0, 1, 1, 2, 30]))
        content[place : place + length] = data.draw(
            st.binary(max_size=8) | st.sampled_from([b'"', b"-", b"nan"])
        )
    path = tmp_path / "x"
    path.write_bytes(bytes(content))
    line = said_of(path)
    assert line.startswith(str(path))
    assert line.isprintable()


def test_an_unknown_format_is_told_in_a_short_line() -> None:
    with pytest.raises(AlignmentError) as error:
        find_reader(source(b"?"))
    others = len(reader_names()) - 1
    assert f"Praat TextGrid and {others} others, listed by `phonanim info`" in str(error.value)
    assert len(str(error.value)) < 160


def test_a_large_elan_file_takes_time_in_step_with_its_size() -> None:
    def calls(slots: int) -> int:
        times = "".join(f'<TIME_SLOT TIME_SLOT_ID="t{n}" TIME_VALUE="{n}"/>' for n in range(slots))
        items = "".join(
            f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a{n}" TIME_SLOT_REF1="t{n}" '
            f'TIME_SLOT_REF2="t{n + 1}"><ANNOTATION_VALUE>a</ANNOTATION_VALUE>'
            "</ALIGNABLE_ANNOTATION></ANNOTATION>"
            for n in range(slots - 1)
        )
        text = (
            f"<ANNOTATION_DOCUMENT><TIME_ORDER>{times}</TIME_ORDER>"
            f'<TIER TIER_ID="phones">{items}</TIER></ANNOTATION_DOCUMENT>'
        )
        count = 0

        def counted(frame: object, event: str, argument: object) -> object:
            nonlocal count
            count += 1
            return counted

        previous = sys.gettrace()
        sys.settrace(counted)
        try:
            load_reader("elan").read(AlignmentFile("x", "x", text.encode()))
        finally:
            sys.settrace(previous)
        return count

    assert calls(800) < 2.5 * calls(400)


def test_a_reader_that_is_not_there() -> None:
    with pytest.raises(AlignmentError, match=r"there is no reader 'praat'; there are .*bas, .*ctm, "):
        load_reader("praat")
