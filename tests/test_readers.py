"""Every file is read by the right reader or refused in one line, whatever its bytes."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from textgrid_text import BEAM, WORDS, long_text, save, short_text

from phonanim import readers
from phonanim.alignment import read_alignment
from phonanim.errors import AlignmentError, PhonanimError
from phonanim.language import to_phones
from phonanim.readers import Source, find_reader, load_reader, reader_names

TIERS = [("words", WORDS), ("phones", BEAM)]


def emu(bundle: bool = True) -> str:
    items = [(0, 2000, ""), (2000, 999, "b"), (3000, 2999, "i:"), (6000, 4000, "m")]
    segments = [
        {"id": n, "sampleStart": start, "sampleDur": length, "labels": [{"name": "Phones", "value": label}]}
        for n, (start, length, label) in enumerate(items)
    ]
    levels = [
        {"name": "Word", "type": "ITEM", "items": []},
        {"name": "Phonetic", "type": "SEGMENT", "items": segments},
    ]
    annotation = {"name": "x", "annotates": "x.wav", "sampleRate": 10000, "levels": levels, "links": []}
    return json.dumps({"ssffFiles": [], "annotation": annotation} if bundle else annotation)


SAMPLES = {"textgrid": [long_text(TIERS), short_text(TIERS)], "emu": [emu(True), emu(False)]}


def source(text: str) -> Source:
    return Source("x", "x", text.encode())


def test_every_reader_has_a_sample() -> None:
    assert set(SAMPLES) == set(reader_names())


@pytest.mark.parametrize("name", reader_names())
def test_readers_keep_the_contract(name: str) -> None:
    reader = load_reader(name)
    assert reader.FORMAT
    assert reader.__doc__
    for text in SAMPLES[name]:
        recognizing = [other for other in reader_names() if load_reader(other).recognizes(source(text))]
        assert recognizing == [name]
        assert reader.read(source(text)).tiers


@pytest.mark.parametrize("bundle", [True, False])
def test_emu_samples_become_seconds(tmp_path: Path, bundle: bool) -> None:
    path = save(tmp_path, emu(bundle), name="x_annot.json")
    alignment = read_alignment(path)
    assert alignment.tier == "Phonetic"
    assert [(i.label, i.start, i.end) for i in alignment.intervals] == [
        ("", 0, 0.2),
        ("b", 0.2, pytest.approx(0.2999)),
        ("i:", pytest.approx(0.2999), pytest.approx(0.5999)),
        ("m", pytest.approx(0.5999), 1.0),
    ]
    assert alignment.duration == 1.0


@pytest.mark.parametrize(("old", "new"), [("10000", "0"), ("10000", '"x"'), ('"sampleDur": 2000, ', "")])
def test_damaged_emu_annotations(tmp_path: Path, old: str, new: str) -> None:
    assert old in emu()
    path = save(tmp_path, emu().replace(old, new), name="x_annot.json")
    with pytest.raises(
        AlignmentError, match=r"x_annot.json: is a damaged EMU annotation \(.*\); export it again"
    ):
        read_alignment(path)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", r"is empty; align the recording again"),
        (b" \n\n", r"is empty; align the recording again"),
        (bytes(range(256)) * 4, r"is a binary file; what can be read: Praat TextGrid, .*EMU"),
        (b"RIFF\x00\x00", r"is a binary file"),
        (b"dear diary", r"is no alignment in a known format; what can be read: Praat TextGrid"),
        (b"{", r"is no alignment in a known format"),
        (b"[" * 100_000, r"is no alignment in a known format"),
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
    with pytest.raises(AlignmentError, match=r"cannot be read: embedded null"):
        read_alignment(Path("\0"))


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="permissions do not bind this user")
def test_an_unreadable_file(tmp_path: Path) -> None:
    path = save(tmp_path, long_text(TIERS))
    path.chmod(0)
    with pytest.raises(AlignmentError, match=r"a.TextGrid: cannot be read: Permission denied"):
        read_alignment(path)


def test_a_vast_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readers, "MAX_BYTES", 1 << 20)
    path = save(tmp_path, "x" * (3 << 20))
    with pytest.raises(AlignmentError, match=r"a.TextGrid: has 3 MB; an alignment has at most 1"):
        read_alignment(path)


EVERY_SAMPLE = [
    text.encode(encoding) for texts in SAMPLES.values() for text in texts for encoding in ("utf-8", "utf-16")
]


def said_of(path: Path) -> str:
    """The one line that refuses a file, or one that says that all is well."""
    try:
        track, _ = to_phones(read_alignment(path), unknown="nearest")
    except PhonanimError as error:
        return str(error)
    rising = (track.bounds[1:] > track.bounds[:-1]).all()
    return f"{path}: {len(track.codes)} phones" if rising else "times do not rise"


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_bytes_cause_a_traceback(tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(data.draw(st.sampled_from(EVERY_SAMPLE)))
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


def test_find_reader_names_the_formats_once() -> None:
    with pytest.raises(AlignmentError) as error:
        find_reader(source("?"))
    for name in reader_names():
        assert load_reader(name).FORMAT in str(error.value)
