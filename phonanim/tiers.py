"""Which tier of a recording holds the phones, and which the words."""

from __future__ import annotations

from collections.abc import Iterable

from phonanim.alignment import Recording, Tier
from phonanim.readers import Source, brief

# Best first: a file may hold MAU (what was said) beside a broader `segments`.
PHONE_NAMES = (
    *("phones", "phone", "phons", "phon", "phonemes", "phoneme", "phn", "phns", "mau", "phonetic"),
    *("phonetics", "segments", "segment", "segs", "seg", "sounds", "sound", "allophones"),
)
WORD_NAMES = ("words", "word", "ort", "ort-mau", "orthography", "wrd", "text", "tokens", "token")

ENOUGH_KNOWN = 0.8
"""Share of a tier's labels that one language must know for the tier to be its phones."""


def phone_tier(recording: Recording, wanted: str | None, source: Source) -> Tier:
    """The tier named or numbered `wanted`, else the one that has the phones. Raises AlignmentError."""
    if not recording.tiers:
        raise source.error("has no interval tier; align the recording first")
    if wanted is not None:
        return _wanted(recording.tiers, wanted, source)
    found = _by_name(recording.tiers, PHONE_NAMES) or _by_content(recording.tiers)
    if len(found) > 1 and any(map(_labels, found)):
        found = [tier for tier in found if _labels(tier)]
    if not found:
        raise source.error(f"has no phone tier among {_listing(recording.tiers)}; name it with --tier")
    if len(found) > 1:
        raise source.error(f"has several phone tiers, {_listing(found)}; choose one with --tier")
    return found[0]


def word_tier(recording: Recording, phones: Tier) -> Tier | None:
    """The tier of words that goes with a phone tier: of the same speaker, if tiers name speakers."""
    speaker = _speaker(phones.name)
    rest = [t for t in recording.tiers if t is not phones and _speaker(t.name) == speaker and _labels(t)]
    found = _by_name(rest, WORD_NAMES)
    return found[0] if found else None


def _wanted(tiers: Iterable[Tier], wanted: str, source: Source) -> Tier:
    tiers = list(tiers)
    exact = [tier for tier in tiers if tier.name == wanted]
    found = exact or [tier for tier in tiers if tier.name.strip().lower() == wanted.strip().lower()]
    found = found or [tier for tier in tiers if str(tier.number) == wanted.strip()]
    if not found:
        raise source.error(f'has no interval tier "{brief(wanted)}"; there are {_listing(tiers)}')
    if len(found) > 1:
        raise source.error(f'has {len(found)} tiers "{brief(wanted)}"; choose by number: {_listing(found)}')
    return found[0]


def _by_name(tiers: Iterable[Tier], names: tuple[str, ...]) -> list[Tier]:
    """The tiers that bear the best of the names that occurs."""
    ranked = [(names.index(_kind(tier.name)), tier) for tier in tiers if _kind(tier.name) in names]
    best = min((rank for rank, _ in ranked), default=0)
    return [tier for rank, tier in ranked if rank == best]


def _by_content(tiers: Iterable[Tier]) -> list[Tier]:
    """The tier whose labels a language knows best, if it knows most of them."""
    from phonanim.language import recognized

    shares = [(recognized(_labels(tier)), tier) for tier in tiers if _labels(tier)]
    best = max((share for share, _ in shares), default=0.0)
    return [tier for share, tier in shares if share == best >= ENOUGH_KNOWN]


def _labels(tier: Tier) -> list[str]:
    return [interval.label for interval in tier.intervals if interval.label]


def _kind(name: str) -> str:
    """The part of "SPEAKER - phones" that says what the tier holds."""
    return name.rpartition(" - ")[2].strip().strip('"').lower()


def _speaker(name: str) -> str:
    return name.rpartition(" - ")[0].strip()


def _listing(tiers: Iterable[Tier]) -> str:
    return ", ".join(map(str, tiers))
