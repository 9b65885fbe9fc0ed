"""Any IPA label becomes the phones that look like it, and nothing else does."""

from __future__ import annotations

import unicodedata

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phonanim.speech.inventory import INVENTORY
from phonanim.speech.ipa import ipa_diacritics, ipa_substitutes, ipa_symbols, parse_ipa
from phonanim.speech.sampa import to_ipa
from phonanim.speech.visible_phones import to_visible_phones

# What every symbol becomes, to be read by a phonetician.
GOLDEN = """
i=iy y=uw ɨ=ih ʉ=uw ɯ=ih u=uw ɪ=ih ʏ=uh ᵻ=ih ᵿ=uh ʊ=uh e=ey ø=ow ɘ=eh ɵ=ow ɤ=ah o=ow ə=ah ɚ=er
ɛ=eh œ=ao ɜ=ah ɝ=er ɞ=ao ʌ=ah ɔ=ao æ=ae ɐ=ah a=aa ɶ=aa ɑ=aa ɒ=ao p=p b=b t=t d=d ʈ=t ɖ=d c=k
ɟ=g k=k ɡ=g q=k ɢ=g ʡ=hh ʔ=hh m=m ɱ=v n=n ɳ=n ɲ=ng ŋ=ng ɴ=ng ʙ=b r=d ʀ=g ʜ=hh ʢ=hh ⱱ=v ɾ=d ɽ=d
ɺ=d ɸ=f β=v f=f v=v θ=th ð=dh ç=y ʝ=y x=k ɣ=g χ=hh ʁ=hh ħ=hh ʕ=hh h=hh ɦ=hh s=s z=z ʃ=sh ʒ=zh
ʂ=sh ʐ=zh ɕ=s ʑ=z ɧ=sh ɬ=l ɮ=l ʋ=v ɹ=r ɻ=r j=y ɥ=w ɰ=y w=w ʍ=w l=l ɫ=l ɭ=l ʎ=y ʟ=g ʘ=p ǀ=t ǃ=t
ǂ=k ǁ=t ɓ=b ɗ=d ᶑ=d ʄ=g ɠ=g ʛ=g
"""

COMBINED = """
tʃ=ch dʒ=jh t͡ʃ=ch ʧ=ch ʈʂ=ch ts=t+s tɕ=t+s dʑ=d+z pf=p+f kx=k tɬ=t+l ɟʝ=g+y k͡p=p ɡ͡b=b ŋ͡m=m
ᵐb=b ⁿd=d mb=m+b nd=n+d kʷ=k+w pʲ=p tʼ=t k̚=k t̪s̪=t+s tsʰ=t+s tɕ͈=t+s n̩=n z̩=z t̼=t d̥=t p̬=b
ɯᵝ=uh e̞=eh o̞=ao ä=aa ɑ̃=aa œ̃=ao ẽː=ey ç=y aɪ=ay aj=ay ai=ay aʊ=aw aw=aw ɑu=aw ɔɪ=oy oi=oy
eɪ=ey ɛi=ey oʊ=ow ow=ow ou=ow əʊ=ah+uh œy=ao+uw iə=iy+ah ʊə=uh+ah ja=y+aa wai=w+ay iau=iy+aw
a˥˩=aa a1=aa ˈa=aa ɑ˞=aa+er g=g a:=aa
"""


def pairs(table: str) -> list[tuple[str, tuple[str, ...]]]:
    cells = [cell.split("=") for cell in table.split()]
    return [(label, tuple(phones.split("+"))) for label, phones in cells]


def test_every_symbol_has_its_golden_phone() -> None:
    golden = dict(pairs(GOLDEN))
    assert list(golden) == list(ipa_symbols())
    assert {symbol: to_visible_phones(symbol) for symbol in ipa_symbols()} == golden


@pytest.mark.parametrize(("label", "phones"), pairs(COMBINED))
def test_combinations(label: str, phones: tuple[str, ...]) -> None:
    assert to_visible_phones(label) == phones
    assert to_visible_phones(unicodedata.normalize("NFD", label)) == phones


@pytest.mark.parametrize(
    "label", ["", "the", "beam", "hello", "word", "I", "B", "?", "ˈ", "5", "str", "æ-", "語"]
)
def test_what_is_no_sound_in_ipa(label: str) -> None:
    assert to_visible_phones(label) == ()


@pytest.mark.parametrize("phone", INVENTORY.phones)
def test_the_inventory_looks_like_itself(phone: str) -> None:
    sound = INVENTORY.sounds[INVENTORY.code(phone)]
    assert to_visible_phones(sound.ipa) == ((phone,) if sound.ipa else ())


@pytest.mark.parametrize("symbol", list(ipa_symbols()))
def test_lips_decide(symbol: str) -> None:
    sound = ipa_symbols()[symbol]
    phone = INVENTORY.sounds[INVENTORY.code(to_visible_phones(symbol)[0])]
    if sound.vowel:
        assert (sound.rounding >= 0.5) == (phone.rounding >= 0.5)
        assert abs(sound.height - phone.height) <= 0.35
    closes = sound.place == "bilabial" and sound.manner not in ("fricative", "approximant")
    assert closes == (phone.lips == "closed")
    if sound.place == "labiodental":
        assert phone.lips == "teeth"


MARKED = st.tuples(
    st.sampled_from(list(ipa_symbols())),
    st.lists(st.sampled_from(list(ipa_diacritics())), max_size=4, unique=True),
)


@given(MARKED)
def test_any_symbol_with_any_marks_resolves(marked: tuple[str, list[str]]) -> None:
    symbol, added = marked
    assert to_visible_phones(symbol + "".join(added)), (symbol, added)


@given(st.text(max_size=6))
def test_any_text_is_taken_or_refused(text: str) -> None:
    assert set(to_visible_phones(text)) <= set(INVENTORY.phones)
    assert set(to_visible_phones(to_ipa(text))) <= set(INVENTORY.phones)


def test_tables_do_not_contradict() -> None:
    assert not set(ipa_symbols()) & set(ipa_diacritics())
    assert not set(ipa_symbols()) & set(ipa_substitutes())
    assert not set(ipa_diacritics()) & set(ipa_substitutes())
    for spelling, ipa in ipa_substitutes().items():
        assert parse_ipa(ipa) or ipa in ipa_diacritics(), spelling
    for effect, value in ipa_diacritics().values():
        assert effect in {"none", "then", "place", "central", "rounding", "height", "backness", "voiced"}
        assert np.isfinite(float(value)) if effect in {"rounding", "height", "backness", "voiced"} else True
        assert value in ipa_symbols() if effect == "then" else True


@pytest.mark.parametrize(
    ("sampa", "ipa"),
    [
        ("aI", "aɪ"),
        ("r\\`", "ɻ"),
        ("t_h", "tʰ"),
        ("9~", "œ̃"),
        ("@`", "ɚ"),
        ("|\\|\\", "ǁ"),
        ("b_<", "ɓ"),
        ("é", ""),
    ],
)
def test_sampa_is_ipa_of_keyboards(sampa: str, ipa: str) -> None:
    assert to_ipa(sampa) == ipa
