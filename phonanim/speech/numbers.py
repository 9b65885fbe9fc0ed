"""Numbers as English words: cardinals, ordinals, years, decimals and amounts."""

from __future__ import annotations

import re

SMALL = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven"),
    *("twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
SCALES = ((10**9, "billion"), (10**6, "million"), (10**3, "thousand"), (100, "hundred"))
ORDINALS = {
    **{"one": "first", "two": "second", "three": "third", "five": "fifth", "eight": "eighth"},
    **{"nine": "ninth", "twelve": "twelfth"},
}
CURRENCIES = {"$": ("dollar", "dollars"), "£": ("pound", "pounds"), "€": ("euro", "euros")}
LARGEST = 10**12
"""Numbers from here on are read digit by digit."""

_NUMBER = re.compile(r"([$£€]?)(\d[\d,]*)(?:\.(\d+))?(st|nd|rd|th|s|%)?")


def spell_number(text: str) -> list[str]:
    """The words of a number such as 42, 3rd, 1,024, 1984, 2.5, $5 or 20%; empty when it is none."""
    found = _NUMBER.fullmatch(text.lower())
    if not found or len(text) > 40:
        return []
    currency, digits, fraction, suffix = found.groups()
    whole = int(digits.replace(",", ""))
    plain = not (currency or fraction or suffix or "," in digits)
    if fraction and not currency:
        words = [*_cardinal(whole), "point", *(SMALL[int(digit)] for digit in fraction)]
    elif suffix in ("st", "nd", "rd", "th"):
        words = _ordinal(whole)
    elif (plain or suffix == "s") and len(digits) == 4 and 1100 <= whole < 2100 and whole // 10 != 200:
        words = _year(whole)
    elif (digits.startswith("0") and len(digits) > 1) or whole >= LARGEST:
        words = [SMALL[int(digit)] for digit in digits.replace(",", "")]
    else:
        words = _cardinal(whole)
    if suffix == "s":
        words = [*words[:-1], _plural(words[-1])]
    if currency:
        words += [CURRENCIES[currency][whole != 1], *(_cents(fraction) if fraction else [])]
    return [*words, "percent"] if suffix == "%" else words


def _cardinal(number: int) -> list[str]:
    if number < 20:
        return [SMALL[number]]
    if number < 100:
        tens, ones = divmod(number, 10)
        return [TENS[tens - 2], *([SMALL[ones]] if ones else [])]
    size, name = next((size, name) for size, name in SCALES if number >= size)
    count, rest = divmod(number, size)
    return [*_cardinal(count), name, *(_cardinal(rest) if rest else [])]


def _ordinal(number: int) -> list[str]:
    *words, last = _cardinal(number) if number < LARGEST else ["zero"]
    if last in ORDINALS:
        return [*words, ORDINALS[last]]
    return [*words, last[:-1] + "ieth" if last.endswith("y") else last + "th"]


def _year(number: int) -> list[str]:
    century, rest = divmod(number, 100)
    if rest == 0:
        return [*_cardinal(century), "hundred"]
    return [*_cardinal(century), *(["oh"] if rest < 10 else []), *_cardinal(rest)]


def _plural(word: str) -> str:
    if word.endswith("y"):
        return word[:-1] + "ies"
    return word + ("es" if word.endswith("x") else "s")


def _cents(fraction: str) -> list[str]:
    cents = int((fraction + "0")[:2])
    return [*_cardinal(cents), "cent" if cents == 1 else "cents"] if cents else []
