"""Alignments as users have them: each is read, or refused by one line that is right."""

from __future__ import annotations

import tarfile
from pathlib import Path

import numpy as np
import pytest
from praatio import textgrid

from phonanim.errors import PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.readers import load_reader
from phonanim.speech.alignment_file import open_alignment_file
from phonanim.speech.cmu_dictionary import find_cmu_dictionary
from phonanim.speech.language import choose_language, to_phones

# Every 30th of 4000: the whole archives take about five seconds.
EACH = 30


# What becomes of each file of the collection: tier, language, number of segments, number of notes.
READ = {
    "001_en_LJ001-0012.TextGrid": ("phones", "english", 78, 0),
    "002_en_LJ006-0114.TextGrid": ("phones", "english", 67, 0),
    "004_en_LJ030-0031.TextGrid": ("phones", "english", 105, 0),
    "005_es_bailen_2071.TextGrid": ("phones", "spanish", 87, 1),
    "007_es_batalla_arapiles_0017.TextGrid": ("phones", "spanish", 96, 1),
    "008_es_batalla_arapiles_4303.TextGrid": ("phones", "spanish", 72, 1),
    "011_en_tp003.TextGrid": ("phone", "english", 70, 0),
    "013_en_tp011.TextGrid": ("phone", "english", 253, 0),
    "014_en_tp005.TextGrid": ("phone", "english", 44, 0),
    "055_en_SA1.TextGrid": ("phones", "english", 35, 0),
    "056_cmn_SSB00050015.TextGrid": ("phones", "mandarin", 40, 0),
    "059_en_mary.TextGrid": ("phone", "swedish", 16, 0),
    "061_en_damon_set_test.TextGrid": ("phons", "english_sampa", 18, 0),
    "064_en_mary_with_negative_zero.TextGrid": ("phone", "swedish", 16, 0),
    "067_en_acoustic_corpus.TextGrid": ("phones", "english", 216, 0),
    "071_en_cold_corpus.TextGrid": ("phones", "english", 246, 0),
    "073_maus_maus_test.TextGrid": ("MAU", "english", 21, 0),
    "077_en_words_segments.TextGrid": ("segments", "english", 1, 1),
    "080_en_phone_word_no_silence.TextGrid": ("phone", "croatian", 4, 0),
    "082_en_mfa_test.TextGrid": ("phones", "english", 21, 0),
    "085_en_test.phones": ("labels", "english", 24, 1),
    "101_en_short_format.TextGrid": ("phone", "english", 104, 2),
    "110_ja_BASIC5000_0001.lab": ("phones", "japanese", 44, 0),
    "112_ja_LOANWORD128_001.lab": ("phones", "japanese", 43, 0),
    "113_de_dfg91_s1em_0666.MAU": ("labels", "german", 28, 0),
    "116_de_dfgspp_mo1_prosody_0020_bndl.json": ("Segment", "german", 32, 0),
}
REFUSED = {
    "010_en_tp043.TextGrid": r'tier "phone", 9.665 s: no phone "÷" in language english',
    "058_en_bobby_phones.TextGrid": r'tier "phone", 0.521 s: no phone "PT" in language english',
    "062_en_bobby_phones_elan.TextGrid": r'tier "phone", 0.521 s: no phone "PT" in language english',
    "068_en_michaelandsickmichael_short_tg.TextGrid": r'has no phone tier among 1 "michael", 2 "sickmichael"',
    "070_en_short_segments.TextGrid": r'has no phone tier among 1 "talker"; name it with --tier',
    "074_en_fave_stereo.TextGrid": r'has several phone tiers, 3 "Speaker 1 - phone", 5 .*--speaker ',
    "083_en_mfa_test_phones_speaker1_speaker2_no.TextGrid": r'--speaker \("Speaker1", "Speaker2"\) or --tier',
    "115_en_ERC_Polish1_audio_0002_annot.json": r"has words but no phones",
}

# Words without phones, with a word and the first phones of it, by the CMU dictionary or by its letters.
SPELLED = {
    "065_en_bobby_words_with_newlines.TextGrid": ("RIPPED\nVerb", ["R", "IH", "P", "T"]),
    "076_en_pronunc_variants_corpus.TextGrid": ("probably", ["P", "R", "AA", "B"]),
    "079_en_tobi.TextGrid": ("millionaire", ["M", "IH", "L", "Y"]),
    "086_en_test.words": ("whatever", ["W", "AH", "T", "EH"]),
}


@pytest.fixture(scope="module")
def collection(shared_data: Path) -> Path:
    return shared_data / "textgrids"


def test_every_real_file_has_an_expectation(collection: Path) -> None:
    names = {path.name for path in collection.iterdir()} - {"INDEX.tsv"}
    assert {name for name in names if not name.endswith((".wav", ".xz"))} == (
        set(READ) | set(REFUSED) | set(SPELLED)
    )


@pytest.mark.parametrize("name", READ)
def test_real_files_are_read(collection: Path, name: str) -> None:
    alignment = read_alignment(collection / name)
    track, notes = to_phones(alignment)
    language = choose_language(interval.label for interval in alignment.intervals)
    assert (alignment.tier, language.name, len(track.codes), len(notes)) == READ[name]
    assert (np.diff(track.bounds) > 0).all()


@pytest.mark.parametrize("name", REFUSED)
def test_real_files_are_refused_by_one_right_line(collection: Path, name: str) -> None:
    with pytest.raises(PhonanimError, match=REFUSED[name]) as error:
        to_phones(read_alignment(collection / name))
    assert str(error.value).startswith(str(collection / name))
    assert str(error.value).isprintable()


@pytest.mark.skipif(find_cmu_dictionary() is None, reason="no package brings the CMU dictionary")
@pytest.mark.parametrize("name", SPELLED)
def test_real_words_are_spelled(collection: Path, name: str) -> None:
    alignment = read_alignment(collection / name)
    to_phones(alignment)
    label, phones = SPELLED[name]
    word = next(word for word in alignment.words if word.label == label)
    spoken = [i.label.rstrip("012") for i in alignment.intervals if i.start >= word.start - 1e-6]
    assert spoken[: len(phones)] == phones
    assert any("share the time of each word equally" in note for note in alignment.notes)


@pytest.mark.parametrize("speaker", ["Speaker 1", "Speaker's+2?&!#$%()*:;<=>@/\\"])
def test_each_speaker_of_a_real_file(collection: Path, speaker: str) -> None:
    alignment = read_alignment(collection / "074_en_fave_stereo.TextGrid", speaker=speaker)
    assert alignment.tier == f"{speaker} - phone"
    assert alignment.words
    to_phones(alignment)


def test_our_reader_and_praatio_agree(collection: Path) -> None:
    for path in sorted(collection.glob("*.TextGrid")):
        if path.name.startswith("101"):
            continue  # praatio refuses its overlap of 0.1 microseconds
        ours = {
            tier.name: tier.intervals
            for tier in load_reader("textgrid").read(open_alignment_file(path)).tiers
        }
        theirs = textgrid.openTextgrid(str(path), includeEmptyIntervals=True, reportingMode="silence")
        for name, intervals in ours.items():
            entries = theirs.getTier(name).entries
            assert [(i.start, i.end, i.label) for i in intervals] == [tuple(entry) for entry in entries]


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
