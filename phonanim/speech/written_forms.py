"""Written forms of English as the words that are said: abbreviations, amounts, times, dates, addresses."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from phonanim.core.lexicon import LEXICON
from phonanim.speech.numbers import CURRENCIES, spell_number

MONTHS = (
    *("January", "February", "March", "April", "May", "June", "July", "August", "September", "October"),
    *("November", "December"),
)
SCALES = {"k": "thousand", "m": "million", "bn": "billion", "b": "billion", "tn": "trillion"}
AROUND = 40  # letters around an abbreviation that decide on it
FRACTIONS = {"1/2": "one half", "1/4": "one quarter", "3/4": "three quarters"}
KINGS = (
    "Charles Edward Elizabeth Frederick George Gregory Henry James John Louis Napoleon Paul Peter Philip "
    "Pius Richard Victor William Benedict Leo"
)
PARTS = "War Part Chapter Act Scene Volume Book Episode Phase Type Level Section Rocky Title Mark Article"
ROMAN = {"I": 1, "V": 5, "X": 10, "L": 50}

_NAMED = r"[A-Z][a-z]"
_MONTH = "|".join((*MONTHS, *(month[:3] for month in MONTHS), "Sept"))
_Rule = tuple[re.Pattern[str], Callable[[re.Match[str]], str]]


def in_english_words(text: str) -> str:
    """English text whose numbers with signs, abbreviations and addresses are written as they are said.

    Plain numbers stay. An abbreviation that may end a sentence is read as one where a name or a number
    follows, as "St. Paul" and "No. 5".
    """
    for pattern, spoken in _rules():
        text = pattern.sub(spoken, text)
    return text


@cache
def _rules() -> tuple[_Rule, ...]:
    units = "|".join(sorted(map(re.escape, _units()), key=len, reverse=True))
    abbreviations = "|".join(sorted(map(re.escape, _abbreviations()), key=len, reverse=True))
    scales = "hundred|thousand|million|billion|trillion|bn|tn|[kmb]"
    return (
        (re.compile(r"\bhttps?://", re.IGNORECASE), lambda _: ""),
        (re.compile(r"(?<=\w)@(?=\w)"), lambda _: " at "),
        (re.compile(r"(?<![\w.])(?:www\.)?[A-Za-z0-9-]{2,63}(?:\.[A-Za-z0-9-]{2,63}){0,4}\.[a-z]{2,12}"
                    r"(?:/[\w./-]{0,200})?(?![\w.]\w)"), _address),
        (re.compile(rf"([$£€])\s?(\d[\d,]*(?:\.\d+)?)(?:\s*({scales})\b)?", re.IGNORECASE), _money),
        (re.compile(r"\b(\d{1,2}):(\d{2})(?::\d{2})?(?:\s*([ap])\.?m\b\.?)?", re.IGNORECASE), _time),
        (re.compile(r"\b(\d{1,2})\s*([ap])\.?m\b\.?", re.IGNORECASE), lambda m: f"{m[1]} {m[2].upper()} M"),
        (re.compile(r"\b(\d{4})-(\d{2})-(\d{2})\b"), _date),
        (re.compile(rf"\b({_MONTH})\.?\s+(\d{{1,2}})(?:st|nd|rd|th)?\b(?![:/.]\d)"), _day),
        (re.compile(r"(?<![\d/])(\d{1,2})/(\d{1,2})(?![\d/])"), _fraction),
        (re.compile(rf"(?<![\w.])(\d[\d,]*(?:\.\d+)?)\s?({units})(?![\w/])", re.IGNORECASE), _measure),
        (re.compile(r"(?<![\w-])(\d{1,4})[-\u2013](\d{1,4})(?![\w-])"), _range),
        (re.compile(r"(?<![\w+-])(\+\d{1,3}(?:[ -]\d{2,4}){2,5}|(?:\d{3}-)?\d{3}-\d{4})(?![\w-])"), _digits),
        (re.compile(r"(?<![\w-])[-\u2212](?=\d)"), lambda _: "minus "),
        (re.compile(r"(?<![\w'])['\u2019](\d0)s\b"), lambda m: " ".join(spell_number(f"{m[1]}s"))),
        (re.compile(rf"\b({_NAMED}\w+)\s+([IVXL]{{2,6}})\b"), _roman),
        (re.compile(r"\b([Dd]r|[Ss]t)\.(?=\s|$|[,;])"), _title_or_street),
        (re.compile(rf"(?<![\w.])({abbreviations})(\.)?(?!\w|\.\w)",
                    re.IGNORECASE), _abbreviation),
    )  # fmt: skip


def _address(match: re.Match[str]) -> str:
    """An address of the web: its parts with "dot" and "slash" between them."""
    text = match[0].rstrip("/")
    return text.replace(".", " dot ").replace("/", " slash ")


def _money(match: re.Match[str]) -> str:
    sign, amount, scale = match.groups()
    if not scale:
        return " ".join(spell_number(f"{sign}{amount}")) or match[0]
    several = CURRENCIES[sign][1]
    return f"{_number(amount)} {SCALES.get(scale.lower(), scale.lower())} {several}"


def _number(text: str) -> str:
    return " ".join(spell_number(text)) or text


def _time(match: re.Match[str]) -> str:
    hour, minute, half = int(match[1]), int(match[2]), match[3]
    if hour > 24 or minute > 59:
        return match[0]
    whole = "" if minute else " o'clock" if 0 < hour <= 12 else " hundred"
    told = f" {half.upper()} M" if half else whole
    spoken = f" {_number(str(minute))}" if minute else ""
    spoken = f" oh{spoken}" if 0 < minute < 10 else spoken
    return f"{_number(str(hour))}{spoken}{told}"


def _date(match: re.Match[str]) -> str:
    year, month, day = match.groups()
    if not (1 <= int(month) <= 12 and 1 <= int(day) <= 31):
        return match[0]
    return f"{MONTHS[int(month) - 1]} {_number(f'{int(day)}th')} {_number(year)}"


def _day(match: re.Match[str]) -> str:
    """A day behind its month is an ordinal: May 5 is May fifth."""
    if not 1 <= int(match[2]) <= 31:
        return match[0]
    month = next(name for name in MONTHS if name.startswith(match[1][:3]))
    return f"{month} {_number(f'{int(match[2])}th')}"


def _fraction(match: re.Match[str]) -> str:
    if told := FRACTIONS.get(match[0]):
        return told
    above, below = int(match[1]), int(match[2])
    if not 0 < above < below or below < 3:
        return f"{above} {below}"
    part = " ".join(spell_number(f"{below}th"))
    return f"{_number(str(above))} {part}{'s' if above > 1 else ''}"


def _measure(match: re.Match[str]) -> str:
    one, several = _units()[match[2].lower()]
    # A letter alone may be a word or a name where a blank is before it, and "in" and "min" are words.
    if len(match[2]) == 1 and match[2] != "°" and match[0][-2].isspace():
        return match[0]
    if match[2].lower() == "in" and match[0][-3].isspace():
        return match[0]
    if match[2].lower() == "s" and match[1].endswith("0"):
        return match[0]  # a decade
    return f"{_number(match[1])} {one if match[1] == '1' else several}"


def _range(match: re.Match[str]) -> str:
    return f"{match[1]} to {match[2]}" if int(match[1]) < int(match[2]) else match[0]


def _digits(match: re.Match[str]) -> str:
    """A telephone number, digit by digit."""
    plus = "plus " if match[1].startswith("+") else ""
    groups = re.findall(r"\d+", match[1])
    return plus + ", ".join(" ".join(" ".join(spell_number(digit)) for digit in group) for group in groups)


def _roman(match: re.Match[str]) -> str:
    """A Roman number behind a name that has one: of a king an ordinal, of a part or a war a number."""
    kinds = _roman_names()
    values = [ROMAN[letter] for letter in match[2]]
    following = [*values[1:], 0]
    number = sum(-one if one < after else one for one, after in zip(values, following, strict=True))
    if match[1] in kinds["ordinal"]:
        return f"{match[1]} the {_number(f'{number}th')}"
    return f"{match[1]} {_number(str(number))}" if match[1] in kinds["number"] else match[0]


@cache
def _roman_names() -> dict[str, frozenset[str]]:
    return {"ordinal": frozenset(KINGS.split()), "number": frozenset(PARTS.split())}


def _title_or_street(match: re.Match[str]) -> str:
    """Doctor or Saint before a name, Drive or Street behind one; alone the title."""
    before = match.string[max(match.start() - AROUND, 0) : match.start()].rstrip()
    after = match.string[match.end() : match.end() + AROUND].lstrip()
    named = bool(re.match(_NAMED, after)) and not re.search(r"\d+(?:st|nd|rd|th)?\s+\w+$", before)
    place = not named and bool(re.search(rf"{_NAMED}\w*$", before))
    short = match[1].lower()
    return {"dr": ("Doctor", "Drive"), "st": ("Saint", "Street")}[short][place]


def _abbreviation(match: re.Match[str]) -> str:
    spoken, where = _abbreviations()[match[1].lower()]
    after = match.string[match.end() : match.end() + AROUND].lstrip()
    dotted = match[2] is not None
    fits = {
        "any": True,
        "dot": dotted,
        "title": dotted and bool(re.match("[A-Z]", after)),
        "number": dotted and bool(re.match(r"\d", after)),
    }[where]
    ends = dotted and (not after or bool(re.match(_NAMED, after))) and where == "any" and len(spoken) > 3
    return (spoken + ("." if ends and not after else "")) if fits else match[0]


@cache
def _abbreviations() -> dict[str, tuple[str, str]]:
    """Each abbreviation without its last dot: what is said, and where it is one."""
    rows = (LEXICON / "english_abbreviations.tsv").read_text("utf-8").splitlines()[1:]
    return {row.split("\t")[0]: (row.split("\t")[1], row.split("\t")[2]) for row in rows}


@cache
def _units() -> dict[str, tuple[str, str]]:
    """Each unit with its names for one and for several."""
    rows = (LEXICON / "english_units.tsv").read_text("utf-8").splitlines()[1:]
    return {row.split("\t")[0]: (row.split("\t")[1], row.split("\t")[2]) for row in rows}
