"""The language of a line is found by its labels, with how sure that is; what cannot be told is said."""

from __future__ import annotations

import pytest

from phonanim.speech import language_choice
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.label_frequencies import notations
from phonanim.speech.language import read_phones
from phonanim.speech.language_choice import language_probabilities, rank_languages, recognized_share
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import language_names
from phonanim.speech.reading import describe_language


def line(labels: str, language: str = "") -> Alignment:
    """An alignment of labels of a tenth of a second; "~" is silence without a label."""
    parts = ["" if label == "~" else label for label in labels.split()]
    intervals = tuple(Interval(label, 0.1 * n, 0.1 * (n + 1)) for n, label in enumerate(parts))
    return Alignment(intervals, 0.1 * len(parts), "phones", "a.TextGrid", language=language)


@pytest.mark.parametrize(
    ("labels", "language"),
    [
        ("sil k a w a i i sil", "japanese"),
        ("pau y u k i ch a N pau", "japanese"),
        ("pau o h a y o o pau", "japanese"),
        ("sil a r i g a t o o sil", "japanese"),
        ("sil x ie4 x ie5 sil", "mandarin"),
        ("sil sh ui3 sil", "mandarin"),
        ("sil n i3 h ao3 sil", "mandarin"),
        ("M AO R N IH NG", "english"),
        ("h# dcl d ey h#", "english"),
        ("~ b ɔ̃ ʒ u ʁ ~", "french"),
        ("~ ʃ øː n ə ~", "german"),
        ("~ ɟ ɛ ɾ ɛ k ~", "turkish"),
        ("~ s̪ ɨ n̪ ɔ ɕ tɕ ~", "polish"),
        ("ㅂ ㅏ ㅂ", "korean"),
        ("n g o5 h ou2", "cantonese"),
        ("か わ", "japanese"),
        ("บ า", "thai"),
    ],
)
def test_short_lines_are_in_their_language(labels: str, language: str) -> None:
    choice = rank_languages(labels.replace("~", "").split())
    assert choice.language.name == language
    assert choice.certainty > 0.95


def test_a_short_line_needs_more_certainty() -> None:
    labels = list("iɹʉkkirʌdʉ")  # Tamil, by eSpeak: Indian English has the same sounds
    choice = rank_languages(labels)
    assert 0.95 < choice.certainty < choice.needed
    assert not choice.sure
    assert "the language is unsure" in " ".join(read_phones(line(" ".join(labels))).notes)
    assert rank_languages(labels * 2).needed == 0.95


@pytest.mark.parametrize(
    ("labels", "rounded"),
    [("~ t y ~", "y"), ("~ l y n ~", "y"), ("~ f y r ~", "y"), ("~ m y l k ~", "y"), ("~ k ø l n ~", "ø")],
)
def test_front_rounded_vowels_of_a_short_line_stay_rounded(labels: str, rounded: str) -> None:
    reading = read_phones(line(labels))
    spoken = dict(zip(reading.track.labels, reading.track.codes, strict=True))
    assert INVENTORY.sounds[spoken[rounded]].rounding > 0.5


def test_a_glide_stays_one_where_the_line_is_japanese() -> None:
    reading = read_phones(line("pau y u k i y o pau"))
    assert [INVENTORY.phones[code] for code in reading.track.codes][1] == "y"
    assert reading.language.language.name == "japanese"


def test_what_cannot_be_told_is_said_with_what_else_it_may_be() -> None:
    reading = read_phones(line("~ y a ~"))
    assert not reading.language.sure
    note = next(note for note in reading.notes if "unsure" in note)
    assert "which differ in phones; name it with --language" in note
    assert reading.language.runner_up in note
    assert reading.language.runner_up not in ("", reading.language.language.name)


def test_languages_that_read_the_labels_alike_do_not_make_doubt() -> None:
    choice = rank_languages(["m", "a", "m", "a"])
    assert choice.probability < 0.9
    assert choice.certainty > choice.probability


def test_an_expected_language_decides_what_labels_do_not() -> None:
    labels = ["y", "a", "m"]
    assert not rank_languages(labels).sure
    assert rank_languages(labels, "japanese").language.name == "japanese"
    assert rank_languages(labels, "japanese").sure
    assert rank_languages(["M", "AO", "R", "N", "IH", "NG"], "japanese").language.name == "english"
    reading = read_phones(line("~ y a m ~"), "auto:fra")
    assert reading.language.language.name == "french"


def test_the_facts_of_the_choice_are_those_that_are_told() -> None:
    facts = read_phones(line("~ b ɔ̃ ʒ u ʁ ~")).language.facts()
    assert (facts["name"], facts["by"]) == ("french", "labels")
    assert 0.95 < facts["certainty"] <= 1
    assert describe_language(facts).startswith("language french, by its labels, 99 % sure")
    named = read_phones(line("b u"), "Français").language.facts()
    assert describe_language(named) == "language french, as named"
    by_format = read_phones(line("MBP AI", "preston_blair")).language.facts()
    assert describe_language(by_format) == "language preston_blair, by the format"
    fallen = read_phones(line("b u"), "hausa", fallback="ipa").language.facts()
    assert describe_language(fallen) == 'language ipa, as there is no language "hausa"'


def test_probabilities_are_those_of_all_languages() -> None:
    found = language_probabilities(["s", "a", "l", "y"])
    assert sum(found.values()) == pytest.approx(1)
    assert {"finnish", "french", "ipa", "sampa"} <= found.keys()


def test_silence_alone_has_no_language_to_doubt() -> None:
    assert rank_languages(["", "sil"]).sure
    assert recognized_share(["sil"]) == 0.0


def test_every_counted_label_is_a_phone_of_its_language() -> None:
    for notation in notations():
        language = load_language(notation.language)
        unknown = [label for label in notation.shares if label != "#" and not language.resolve(label)]
        known = sum(share for label, share in notation.shares.items() if label not in unknown)
        assert known > 0.98, (notation.language, notation.name, unknown)


def test_a_long_file_is_read_as_fast_as_its_different_labels() -> None:
    labels = ["M", "AO", "R", "N", "IH", "NG"] * 20_000
    assert rank_languages(labels).language.name == "english"


def test_a_language_that_lists_every_label_goes_before_one_that_lacks_some() -> None:
    sung = "SP d ao p u AP zh iong q v SP"  # pinyin without tones, as singers are labelled
    found = rank_languages(sung.split(" "))
    assert found.language.name == "mandarin"
    assert sum(share for _, share in found.candidates) <= 1.0 + 1e-9


def test_languages_that_read_the_labels_alike_are_told() -> None:
    facts = read_phones(line("~ b a m i ~")).language.facts()
    assert facts["probability"] < 0.95 < facts["certainty"]
    assert "% sure of the phones (of the language " in describe_language(facts)


def test_labels_that_no_language_has_still_give_one():
    labels = [f"q{number}x7" for number in range(400)]
    assert rank_languages(labels).language.name in language_names()


def test_only_the_most_frequent_labels_decide(monkeypatch):
    english = ["AA1", "S", "T", "IH0", "N"] * 20
    monkeypatch.setattr(language_choice, "MOST_LABELS", 5)
    assert rank_languages([*english, *(f"q{n}" for n in range(50))]).language.name == "english"


def test_a_label_of_very_many_marks_costs_no_time():
    label = "a" + "\u0303\u0330" * 500_000  # its normal form takes quadratic time
    assert read_phones(line(f"a {label} m"), "english", "silence").track.duration > 0
