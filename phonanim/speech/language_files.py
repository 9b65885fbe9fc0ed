"""The languages of lexicon/languages and of the user's folders, read and checked."""

from __future__ import annotations

import re
from functools import cache
from typing import Any
from unicodedata import normalize

from phonanim.core.decode import DAMAGE, read_toml
from phonanim.core.lexicon import LEXICON, find_tables
from phonanim.errors import LabelError
from phonanim.speech.alignment_file import quote_label
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.labels import ALPHABETS, IPA, Language, codes_of_ipa, in_notation_of_ipa
from phonanim.speech.language_names import find_language, language_names


@cache
def load_language(name: str) -> Language:
    """The language with a name, a code ("de", "deu", "de-AT") or a model name ("german_mfa").

    Raises LabelError, which suggests the nearest names, when there is no such language.
    """
    bare, _, notation = name.rpartition(":")
    if bare and notation == IPA:
        return in_notation_of_ipa(load_language(bare))
    stem = find_language(name) or _coded(name)
    if stem is not None:
        return _read_language(stem)
    from difflib import get_close_matches

    near = ", ".join(get_close_matches(name.lower(), language_names(), cutoff=0.0))
    mend = f"nearest: {near}, or auto, or --fallback-language ipa where the labels are IPA"
    raise LabelError(f'there is no language "{quote_label(name)}"; {mend}')


def _coded(name: str) -> str | None:
    """The language on PHONANIM_PATH whose file has this code, or the code before the first hyphen."""
    own = [stem for stem, path in find_tables("languages").items() if LEXICON not in path.parents]
    codes = {name.lower(), re.split("[_-]", name.lower())[0]}
    return next((stem for stem in own if _read_language(stem).code.lower() in codes), None)


@cache
def _read_language(name: str) -> Language:
    """Read the language file of a name. Raises LabelError when a file of the user is not a valid language."""
    file = LEXICON / "languages" / f"{name}.toml"
    path = file if file.is_file() else find_tables("languages")[name]
    try:
        language = _build_language(name, read_toml(path))
        if LEXICON not in path.parents:  # the tests check the languages of the package
            _check_sounds(language)
    except (OSError, *DAMAGE) as error:
        reason = f"has no {error}" if isinstance(error, KeyError) else error
        raise LabelError(
            f"{path}: is not a valid language: {reason}; docs/languages.md describes the file"
        ) from error
    return language


def _check_sounds(language: Language) -> None:
    """Raise ValueError for a label that is neither a phone of the inventory nor IPA."""
    for phones in (*language.phones.values(), *language.closures.values()):
        for phone in phones.split():
            if phone not in INVENTORY.phones:
                raise ValueError(f"{phone!r} is not one of the phones {' '.join(INVENTORY.phones)}")
    for sounds in (*language.ipa.values(), *language.in_ipa.values()):
        codes_of_ipa(sounds)
    for alphabet in language.alphabets:
        if alphabet not in ALPHABETS:
            raise ValueError(f"{alphabet!r} is not one of the alphabets {', '.join(ALPHABETS)}")


def _build_language(name: str, table: dict[str, Any]) -> Language:
    fold = bool(table.get("fold", False))

    def entries(key: str) -> dict[str, str]:
        pairs = table.get(key, {}).items()
        return {normalize("NFC", label.lower() if fold else label): text for label, text in pairs}

    return Language(
        name=name,
        title=table["title"],
        code=table["code"],
        alphabets=tuple(table.get("alphabets", ())),
        phones=entries("phones"),
        ipa=entries("ipa"),
        closures=entries("closures"),
        in_ipa=entries("in_ipa"),
        labels={aligner: tuple(text.split()) for aligner, text in table.get("labels", {}).items()},
        ignore=table.get("ignore", ""),
        fold=fold,
        rounding=float(table.get("rounding", 1.0)),
        front=table.get("front", ""),
    )
