"""Choose the phone tier and the word tier of a recording."""

from __future__ import annotations

import re
from collections.abc import Iterable

from phonanim.speech.alignment_file import AlignmentFile, quote_label
from phonanim.speech.intervals import Recording, Tier

# Best first: a file may have MAU (as pronounced) next to a broader `segments`.
PHONE_NAMES = (
    *("phones", "phone", "phons", "phon", "phonemes", "phoneme", "phn", "phns", "mau", "phonetic"),
    *("phonetics", "segments", "segment", "segs", "seg", "sounds", "sound", "allophones"),
)
WORD_NAMES = ("words", "word", "ort", "ort-mau", "orthography", "wrd", "text", "tokens", "token")

UNNAMED = ("labels",)  # of files that do not name what their labels are

# A speaker and a kind in one word; these kinds have no other meaning.
_JOINED = re.compile(r"(.*?[^ _:/-])[ _:/-]+(phones?|phonemes?|segments?|words?)", re.IGNORECASE)

ENOUGH_KNOWN = 0.8
"""Share of a tier's labels that one language must have for the tier to count as phones."""


def phone_tier(recording: Recording, wanted: str | None, speaker: str | None, source: AlignmentFile) -> Tier:
    """The tier named or numbered `wanted`, else that of `speaker` with phones. Raises AlignmentError."""
    if not recording.tiers:
        raise source.error("has no interval tier; align the recording first")
    tiers = recording.tiers if speaker is None else _spoken_by(recording.tiers, speaker, source)
    if wanted is not None:
        return _wanted(tiers, wanted, source)
    found = best_named_tiers(tiers, PHONE_NAMES) or best_tiers_by_content(tiers)
    if len(found) > 1 and any(map(_labels, found)):
        found = [tier for tier in found if _labels(tier)]
    if not found and best_named_tiers(tiers, (*WORD_NAMES, *UNNAMED)):
        raise source.error(
            "has words but no phones; give a pronunciation dictionary (--lexicon), or align to phones"
            + _dictionary_hint(recording)
        )
    if not found:
        raise source.error(f"has no phone tier among {_listing(recording.tiers)}; name it with --tier")
    if len(found) > 1:
        raise source.error(f"has several phone tiers, {_listing(found)}; choose one with {_choices(found)}")
    return found[0]


def _dictionary_hint(recording: Recording) -> str:
    """What brings pronunciations: a dictionary if the words may be English, else the rules of eSpeak NG."""
    from phonanim.media.espeak import can_speak
    from phonanim.speech.cmu_dictionary import find_cmu_dictionary

    spoken = recording.spoken.lower()
    if spoken and not spoken.startswith("en"):
        return "" if can_speak() else "; pip install 'phonanim[espeak]' brings pronunciations"
    if not find_cmu_dictionary():
        return "; pip install 'phonanim[align]' brings one for English"
    return "; words of another language than English are read with its name in --language"


def word_tier(recording: Recording, phones: Tier) -> Tier | None:
    """The word tier that goes with a phone tier: of the same speaker, if tiers name speakers."""
    speaker = speaker_of(phones)
    rest = [
        tier
        for tier in recording.tiers
        if tier is not phones and speaker_of(tier) == speaker and _labels(tier)
    ]
    found = best_named_tiers(rest, WORD_NAMES)
    return found[0] if found else None


def speaker_of(tier: Tier) -> str:
    """The speaker of a tier, by the format or by a name such as "SPEAKER - phones"; else empty."""
    return tier.speaker or _split(tier.name)[0]


def _spoken_by(tiers: Iterable[Tier], speaker: str, source: AlignmentFile) -> tuple[Tier, ...]:
    speakers = list(dict.fromkeys(name for tier in tiers if (name := speaker_of(tier))))
    wanted = next((name for name in speakers if name == speaker), None)
    wanted = wanted or next((name for name in speakers if name.lower() == speaker.strip().lower()), None)
    if wanted is None:
        names = ", ".join(f'"{quote_label(name)}"' for name in speakers) or "none is named"
        raise source.error(f'has no speaker "{quote_label(speaker)}"; speakers: {names}')
    return tuple(tier for tier in tiers if speaker_of(tier) == wanted)


def _choices(tiers: Iterable[Tier]) -> str:
    """The options that distinguish the tiers."""
    speakers = [speaker_of(tier) for tier in tiers]
    names = ", ".join(f'"{quote_label(name)}"' for name in speakers)
    return (
        f"--speaker ({names}) or --tier"
        if all(speakers) and len(set(speakers)) == len(speakers)
        else "--tier"
    )


def _wanted(tiers: Iterable[Tier], wanted: str, source: AlignmentFile) -> Tier:
    tiers = list(tiers)
    exact = [tier for tier in tiers if tier.name == wanted]
    found = exact or [tier for tier in tiers if tier.name.strip().lower() == wanted.strip().lower()]
    found = found or [tier for tier in tiers if str(tier.number) == wanted.strip()]
    if not found:
        raise source.error(f'has no interval tier "{quote_label(wanted)}"; there are {_listing(tiers)}')
    if len(found) > 1:
        raise source.error(
            f'has {len(found)} tiers "{quote_label(wanted)}"; choose by number: {_listing(found)}'
        )
    return found[0]


def best_named_tiers(tiers: Iterable[Tier], names: tuple[str, ...]) -> list[Tier]:
    """For each speaker, the tiers with the best of the names that occur."""
    named = [tier for tier in tiers if _kind(tier.name) in names]
    best: dict[str, int] = {}
    for tier in named:
        best[speaker_of(tier)] = min(names.index(_kind(tier.name)), best.get(speaker_of(tier), len(names)))
    return [tier for tier in named if names.index(_kind(tier.name)) == best[speaker_of(tier)]]


def best_tiers_by_content(tiers: Iterable[Tier]) -> list[Tier]:
    """The tier with the largest share of labels that a language has, if that is most of them."""
    from phonanim.speech.language_choice import recognized_share

    shares = [(recognized_share(_labels(tier)), tier) for tier in tiers if _labels(tier)]
    best = max((share for share, _ in shares), default=0.0)
    return [tier for share, tier in shares if share == best >= ENOUGH_KNOWN]


def _labels(tier: Tier) -> list[str]:
    return [interval.label for interval in tier.intervals if interval.label]


def _kind(name: str) -> str:
    return _split(name)[1]


def _split(name: str) -> tuple[str, str]:
    """Speaker and kind of a tier named "SPEAKER - phones", "SPEAKER_phones" or just "phones"."""
    name = name.strip().strip('"')
    speaker, _, kind = name.rpartition(" - ")
    if not speaker and (parts := _JOINED.fullmatch(name)):
        speaker, kind = parts.groups()
    return speaker.strip(), kind.strip().lower()


def _listing(tiers: Iterable[Tier]) -> str:
    return ", ".join(map(str, tiers))
