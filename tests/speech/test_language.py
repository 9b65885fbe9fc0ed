"""Labels become phones of the inventory; every label is taken, noted, or refused by name."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phonanim.errors import LabelError
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.labels import Language
from phonanim.speech.language import choose_language, language_names, load_language, read_phones, to_phones

STEP = 0.125


def alignment(labels: str | list[str], **more: Any) -> Alignment:
    """Labels of an eighth of a second each; "~" leaves a gap."""
    labels = labels.split() if isinstance(labels, str) else labels
    intervals = [Interval(label, STEP * n, STEP * (n + 1)) for n, label in enumerate(labels) if label != "~"]
    return Alignment(tuple(intervals), STEP * len(labels), "phones", "a.TextGrid", **more)


def phones(labels: str | list[str], language: str = "auto") -> str:
    track, _ = to_phones(alignment(labels), language)
    return " ".join(INVENTORY.phones[code] for code in track.codes)


@pytest.mark.parametrize(
    ("labels", "language", "expected"),
    [
        ("B IY1 M", "english", "b iy m"),
        ("b iy m", "english", "b iy m"),
        ("AX0 IX AXR UX AX-H", "english", "ah ih er uw ah"),
        ("EL EM EN ENG NX DX HV Q", "english", "l m n ng n d hh hh"),
        ("HH_B AH0_I L_I OW1_E", "english", "hh ah l ow"),
        ("IA EA", "english", "ih ah eh ah"),
        ("aj ɔj ɫ̩ pʰ tʃ d̪ iː ɹ", "english_mfa", "ay oy l p ch d iy r"),
        ("e r O: {", "english_sampa", "eh r ao ae"),
        ("ɟʝ β ð ʎ tʃ r", "spanish", "g y v dh y ch d"),
        ("y: Y 2: 9 OY aI 6 pf ts C x R r", "german", "uw uh ow ao oy ay ah p f t s y k hh hh"),
        ("y ø œ ɑ̃ ɥ e~ R", "french", "uw ow ao aa w eh hh"),
        ("r̝ r̝̊ ow", "czech", "zh sh ow"),
        ("rs s' u0 }: x\\", "swedish", "sh s ow uw sh"),
        ("tɕ tʂ ɨ ʑ", "polish", "t s ch ih z"),
        ("zh ang1 x iong2 iii4 v3 l ü4", "mandarin", "ch aa ng s iy uw ng zh uw l uw"),
        ("i cl p a i N u f U", "japanese", "iy p aa iy ng uh f uh"),
        ("ㅂ ㅜ ㅢ ㅘ ㅈ", "korean", "p uw ih iy w aa t s"),
    ],
)
def test_labels_of_each_language(labels: str, language: str, expected: str) -> None:
    assert phones(labels, language) == expected


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ("pcl p iy", "p iy"),
        ("bcl b", "b"),
        ("tcl ch dcl jh", "ch jh"),
        ("tcl s", "t s"),
        ("bcl ~ b", "b sil b"),
        ("b b", "b b"),
        ("h# bcl m epi pau", "sil b m sil"),
    ],
)
def test_closures_join_their_release(labels: str, expected: str) -> None:
    assert phones(labels, "english") == expected


@pytest.mark.parametrize(
    "label",
    [
        "",
        " ",
        "sil",
        "SIL",
        "sp",
        "pau",
        "<eps>",
        "[SIL]",
        "<p:>",
        "&p:",
        "h#",
        "#",
        "<s>",
        "{B_TRANS}",
        "SIL_S",
    ],
)
@pytest.mark.parametrize("language", language_names())
def test_silences_are_shared_and_run_together(label: str, language: str) -> None:
    spoken = next((name for name, phone in load_language(language).phones.items() if phone != "sil"), "m")
    track, notes = to_phones(alignment([spoken, label, "~", "sil"]), language)
    assert track.codes.tolist()[1:] == [0]
    assert track.bounds.tolist() == [0, STEP, 4 * STEP]
    assert notes == ()


@pytest.mark.parametrize("label", ["spn", "<unk>", "noise", "{LG}", "[noise]", "<usb>"])
def test_noise_is_silent_but_noted(label: str) -> None:
    track, notes = to_phones(alignment(["B", label, "IY", label, label]))
    assert track.codes.tolist() == INVENTORY.codes(["b", "sil", "iy", "sil"]).tolist()
    assert notes == (f'"{label}" at 0.12 s and 2 more: not a phone, shown as silence',)


def test_labels_stay_with_their_segments() -> None:
    track, _ = to_phones(alignment("~ bcl b IA sil ~"), "english")
    assert track.labels == ("", "bcl b", "IA", "IA", "sil")
    assert track.bounds.tolist() == [0, 0.125, 0.375, 0.4375, 0.5, 0.75]


def test_an_unknown_label_is_named_with_its_place() -> None:
    text = r'a.TextGrid: tier "phones", 0.125 s: no phone "QQ" in language english \(nearest: q, .*\); choose'
    with pytest.raises(LabelError, match=text):
        to_phones(alignment("B QQ"), "english")


def test_an_unknown_label_is_replaced_by_consent_and_noted() -> None:
    track, notes = to_phones(alignment("B SHH QQ"), "english", unknown="nearest")
    assert [INVENTORY.phones[c] for c in track.codes] == ["b", "sh", "hh"]
    assert notes[0] == '"SHH" at 0.12 s: unknown in language english, shown as "sh"'
    track, notes = to_phones(alignment("B QQ"), "english", unknown="silence")
    assert [INVENTORY.phones[c] for c in track.codes] == ["b", "sil"]
    assert notes == ('"QQ" at 0.12 s: unknown in language english, shown as silence',)


def test_times_in_messages_are_those_of_the_file() -> None:
    with pytest.raises(LabelError, match=r"100.125 s"):
        to_phones(alignment("B QQ", offset=100.0), "english")
    _, notes = to_phones(alignment("B spn", offset=100.0, notes=("read so",)))
    assert notes[0] == "read so"
    assert '"spn" at 100.12 s' in notes[1]


def test_silence_alone_is_noted() -> None:
    track, notes = to_phones(alignment("~ ~"))
    assert track.codes.tolist() == [0]
    assert notes == ('no phone is spoken in tier "phones"',)


def test_an_unknown_language_suggests_the_nearest() -> None:
    with pytest.raises(LabelError, match=r'there is no language "englsh"; nearest: english, .*or auto'):
        load_language("englsh")


def test_ipa_stands_for_a_language_that_is_not_there_by_consent() -> None:
    with pytest.raises(LabelError, match="or --fallback-language ipa where the labels are IPA"):
        to_phones(alignment("ɓ a"), "hausa")
    track, notes = to_phones(alignment("ɓ a"), "hausa", fallback="ipa")
    assert track.codes.tolist() == to_phones(alignment("ɓ a"), "ipa")[0].codes.tolist()
    assert notes == ()
    with pytest.raises(LabelError, match='there is no language "ip"; nearest: ipa'):
        to_phones(alignment("ɓ a"), "hausa", fallback="ip")


@pytest.mark.parametrize(
    ("labels", "language"),
    [
        ("B IY1 M", "english"),
        ("ɓ ʘ ɬ", "ipa"),
        ("zh ong1 g uo2", "mandarin"),
        ("ky o cl k a N sh", "japanese"),
    ],
)
def test_auto_goes_by_the_labels(labels: str, language: str) -> None:
    assert choose_language(labels.split()).name == language


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("german", "german"),
        ("de", "german"),
        ("de-AT", "german"),
        ("german_mfa", "german"),
        ("English", "english"),
    ],
)
def test_languages_go_by_name_code_or_model(name: str, stem: str) -> None:
    assert load_language(name).name == stem


@pytest.mark.parametrize("name", language_names())
def test_language_files_keep_the_contract(name: str) -> None:
    language = load_language(name)
    assert language.title
    assert set(language.alphabets) <= {"IPA", "SAMPA"}
    for label in [*language.phones, *language.ipa, *language.closures]:
        assert language.resolve_listed(label), label
    missing = [
        label for labels in language.labels.values() for label in labels if not language.resolve(label)
    ]
    assert not missing


@pytest.mark.parametrize("name", language_names())
def test_every_aligner_can_close_and_round_the_lips(name: str) -> None:
    language = load_language(name)
    for aligner, labels in language.labels.items():
        sounds = filter(None, map(language.resolve, labels))
        shown = {INVENTORY.phones[code] for sound in sounds for code in sound.codes}
        assert {"p", "m", "iy"} <= shown, aligner
        assert shown & {"uw", "uh"}, aligner
        assert shown & {"aa", "ae"}, aligner


def test_labels_listed_as_no_ipa_are_refused() -> None:
    with pytest.raises(ValueError, match="not IPA: beam"):
        Language("x", "x", "", ipa={"q": "beam"}).resolve("q")


def test_the_page_has_the_tables_of_today(root: Path) -> None:
    script = runpy.run_path(str(root / "scripts" / "write_language_tables.py"))
    page = (root / "docs" / "language_tables.md").read_text("utf-8")
    assert page.endswith(script["tables"]()), "run scripts/write_language_tables.py"
    for heading in ("## Languages", "| ʘ | bilabial click | p | lips shut |", "| ɥ |"):
        assert heading in page


LABELS = st.lists(
    st.sampled_from(["B", "IY1", "bcl", "tcl", "t", "", "sil", "spn", "~", "IA", "OY2"]), min_size=1
)


@given(LABELS)
def test_tracks_are_contiguous_and_whole(labels: list[str]) -> None:
    track, _ = to_phones(alignment(labels), "english")
    assert track.bounds[0] == 0
    assert track.bounds[-1] == pytest.approx(STEP * len(labels))
    assert (np.diff(track.bounds) > 0).all()
    assert len(track.codes) == len(track.labels) == len(track.bounds) - 1
    silent = track.codes == 0
    assert not (silent[1:] & silent[:-1]).any()


def test_a_mistyped_label_does_not_turn_arpabet_into_sampa() -> None:
    labels = ["M", "AY", "F", "AA", "DH", "ER", "QQQ", "T", "B", "IY"]
    assert choose_language(labels).name == "english"
    assert choose_language([label for label in labels if label != "ER"]).name == "english"


@pytest.mark.parametrize(
    ("language", "labels", "rounding"),
    [("fr", "s a l y", 1.25), ("en", "M UW1", 1.0), ("ipa", "t yː z", 1.25), ("ipa", "t uː z", 1.0)],
)
def test_lips_are_rounder_in_languages_with_front_rounded_vowels(
    language: str, labels: str, rounding: float
) -> None:
    assert read_phones(alignment(labels), language).track.rounding == rounding


@pytest.mark.parametrize(
    ("language", "labels", "phones"),
    [
        ("ja", "k oː j a ɴ", "k ow y aa ng"),
        ("ja", "j u y u", "d z uh y uh"),
        ("zh", "n i˨˩˦ x au̯˨˩˦", "n iy k aw"),
        ("zh", "x i3 j v5", "s iy t s uw"),
        ("zh", "n y˥˩", "n uw"),
    ],
)
def test_letters_of_romanizations_have_the_sound_of_ipa_in_ipa(
    language: str, labels: str, phones: str
) -> None:
    reading = read_phones(alignment(labels), language)
    assert [INVENTORY.phones[code] for code in reading.track.codes] == phones.split()
    assert load_language(reading.language.language.full_name) is reading.language.language
    assert reading.language.facts()["name"] in ("japanese", "mandarin")
