"""Networks of words, and what stretches of speech may say."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.aligners._network import Slot, choices_of, transitions_of
from phonanim.aligners._slots import Plan, Said, plan_stretches, slot_of

SLOTS: list[Slot] = [(("a",),), (("b", "c"), ("d",)), (("e",), ()), (("f",),)]


def said(words: str, begin: float = 0.0, window: int = 0) -> list[Said]:
    """Words of 0.4 s, one after the other."""
    return [
        Said(word, window, begin + 0.4 * n, begin + 0.4 * (n + 1), 0.9)
        for n, word in enumerate(words.split())
    ]


def sentences_of(slots: list[Slot]) -> set[str]:
    """All that a grammar can say."""
    last, transitions = transitions_of(slots)

    def go_on(state: int, words: tuple[str, ...]) -> set[str]:
        found = {" ".join(words)} if state == last else set()
        for start, to, _, word in transitions:
            if start == state:
                found |= go_on(to, words if word == "<sil>" else (*words, word))
        return found

    return go_on(0, ())


def test_a_network_says_each_alternative() -> None:
    assert sentences_of(SLOTS) == {"a b c e f", "a b c f", "a d e f", "a d f"}
    assert sentences_of([*SLOTS, (("g",), ())]) == {
        f"{one}{end}" for one in sentences_of(SLOTS) for end in ("", " g")
    }


def test_the_first_alternative_is_likelier() -> None:
    chances = {word: chance for _, _, chance, word in transitions_of(SLOTS)[1]}
    assert chances["b"] > 0.9 > 0.1 > chances["d"] > 0
    assert chances["a"] == chances["c"] == 1


def test_what_each_slot_says() -> None:
    assert choices_of(SLOTS, ["a", "b", "c", "f"]) == [("a",), ("b", "c"), (), ("f",)]
    assert choices_of(SLOTS, ["a", "d", "e", "f"]) == [("a",), ("d",), ("e",), ("f",)]
    assert choices_of([(("a",), ()), (("a",),)], ["a"]) == [(), ("a",)]
    assert choices_of(SLOTS, ["a", "d"]) is None


def slots_of(plan: Plan, text: str, recognized: list[Said]) -> list[list[Slot]]:
    return [[slot_of(choice, text.split(), recognized) for choice in one.choices] for one in plan.stretches]


def test_text_and_recognized_words_are_alternatives() -> None:
    text, recognized = "we sold the old blue lamp today", said("we bought the blue lamp again today")
    plan = plan_stretches(text.split(), recognized)
    assert slots_of(plan, text, recognized) == [
        [
            (("we",),),
            (("sold",), ("bought",)),
            (("the",),),
            (("old",), ()),
            (("blue",),),
            (("lamp",),),
            ((), ("again",)),
            (("today",),),
        ]
    ]
    assert plan.share == pytest.approx(5 / 7)


def test_a_passage_that_the_text_lacks_is_left_out() -> None:
    aside = "one two three four five six seven eight nine"
    recognized = said(f"we bought the lamp {aside} and then we left")
    plan = plan_stretches(["we", "bought", "the", "lamp", "and", "then", "we", "left"], recognized)
    assert [recognized[j].word for j in plan.asides[0]] == aside.split()
    first, second = plan.stretches
    assert first.end <= recognized[4].start + 1e-9
    assert second.start >= recognized[12].end - 1e-9


def test_a_passage_that_is_not_spoken_is_left_out() -> None:
    text = "we bought the lamp one two three four five six and then we left"
    plan = plan_stretches(text.split(), said("we bought the lamp and then we left"))
    assert plan.lost == [4, 5, 6, 7, 8, 9]
    assert [len(one.choices) for one in plan.stretches] == [8]


def test_a_pause_and_a_window_part_stretches() -> None:
    text = "we bought the lamp and then we left and came home again"
    recognized = [
        *said("we bought the lamp"),
        *said("and then we left", 8),
        *said("and came home again", 20, 1),
    ]
    plan = plan_stretches(text.split(), recognized)
    assert [(one.window, len(one.choices)) for one in plan.stretches] == [(0, 4), (0, 4), (1, 4)]
    np.testing.assert_allclose([one.start for one in plan.stretches], [0, 7.4, 19.4])
    np.testing.assert_allclose([one.end for one in plan.stretches], [2.2, 10.2, 22.2])
