"""Map a sound to the phones of the inventory that look most like it.

Only the visible articulation counts: closed lips, teeth on the lip, rounding, the height of the jaw, then the
place of the tongue.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache

from phonanim.speech.inventory import INVENTORY, Phone
from phonanim.speech.ipa import Articulation, ipa_symbols, parse_ipa

# Costs of a difference, by its visibility. Lips that shut (1) or stay open (0) outweigh everything else;
# voicing is invisible and only breaks ties, as between p and b.
LIPS, ROUNDING, CONTACT, HEIGHT = 4.0, 2.0, 1.5, 1.5
PLACE, HISS, SPREAD = 1.0, 1.0, 0.8
MANNER, BACKNESS, VOICE = 0.35, 0.2, 0.2

DIPHTHONG_NEAR = 0.6
"""Largest distance of a pair of vowels from a diphthong of the inventory that replaces it."""

AFFRICATE_NEAR = 1.0
"""Largest distance of a stop with a fricative from an affricate of the inventory that replaces it."""

# Places of the tongue from the lip to the throat, in steps of about equal visibility. Lip sounds leave the
# tongue in the middle.
PLACES = {
    **{"linguolabial": 0.0, "dental": 1.0, "alveolar": 2.0, "postalveolar": 3.0, "retroflex": 3.3},
    **{"alveolo-palatal": 3.6, "palatal": 4.0, "labial-palatal": 4.0, "velar": 5.0, "labial-velar": 5.0},
    **{"labiovelar": 5.0, "uvular": 5.5, "pharyngeal": 7.0, "glottal": 7.0},
    **dict.fromkeys(("bilabial", "labiodental", "none"), 3.0),
}
STOPS = frozenset({"plosive", "implosive", "click", "tap", "trill", "affricate"})
FRICATIVES = frozenset({"fricative", "sibilant", "lateral fricative"})
GLIDES = {"j": "i", "w": "u", "ɥ": "y", "ɰ": "ɯ"}
COLOURS = ("ɹ", "ɻ")
"""Consonants that eSpeak writes in one label with the vowel before them, as in [ɑːɹ]."""

SONORANTS = frozenset("lɫnm")
"""Sounds that may close a label with a schwa alone, as in [əl]."""

# Consonants that form one label together: n nasal, s stop, f fricative, l lateral.
CLUSTERS = frozenset(
    {"", "n", "s", "f", "l", "a", "ns", "nf", "nl", "nn", "ss", "sf", "sl", "nsf", "nss", "sff"}
)
LONGEST = 4
"""Maximum number of vowels and glides in one label; more is a word."""


@lru_cache(maxsize=4096)
def to_visible_phones(label: str) -> tuple[str, ...]:
    """The phones that look like an IPA label, in order; empty when it is not one sound in IPA.

    A label may be one sound, a diphthong or triphthong, a vowel after a glottal stop or coloured by [ɹ], an
    affricate, a double stop, a nasal with its stop, or glides with their vowel. Words are refused, so that a
    word tier is not mistaken for phones.
    """
    sounds = parse_ipa(label)
    if any(sound.vowel for sound in sounds):
        return _without_repeats(_syllabic(sounds)) if len(sounds) <= LONGEST else ()
    kinds = "".join(_kind(sound) for sound in sounds)
    known = kinds.rstrip("w") in CLUSTERS
    return _without_repeats(_consonants(sounds)) if known else ()


def visual_distance(start: Articulation, end: Articulation, phone: Phone) -> float:
    """Visual distance between a sound that goes from `start` to `end` and a phone of the inventory."""
    if start.vowel:
        return (_vowel_distance(start, phone, False) + _vowel_distance(end, phone, True)) / 2
    return _consonant_distance(start, phone)


def _vowel_distance(sound: Articulation, phone: Phone, at_end: bool) -> float:
    height = phone.end_height if at_end else phone.height
    backness = phone.end_backness if at_end else phone.backness
    rounding = phone.end_rounding if at_end else phone.rounding
    drawn = lip_spread(height, backness, rounding)
    return (
        ROUNDING * abs(sound.rounding - rounding)
        + HEIGHT * abs(sound.height - height)
        + SPREAD * abs(lip_spread(sound.height, sound.backness, sound.rounding) - drawn)
        + BACKNESS * abs(sound.backness - backness)
    )


def lip_spread(height: float, backness: float, rounding: float) -> float:
    """How far the mouth corners are spread: most in [i]; 0 in open, back or rounded vowels."""
    return height * (1 - backness) * (rounding == 0)


def _consonant_distance(sound: Articulation, phone: Phone) -> float:
    other = _articulation(phone)
    return (
        LIPS * abs(lip_closure(sound) - lip_closure(other))
        + ROUNDING * abs(sound.rounding - other.rounding)
        + CONTACT * abs(constriction(sound) - constriction(other))
        + PLACE * abs(PLACES[sound.place] - PLACES[other.place])
        + HISS * ((sound.manner == "sibilant") != (other.manner == "sibilant"))
        + SPREAD * ((sound.place == "palatal") != (other.place == "palatal"))
        + MANNER * (_family(sound) != _family(other))
        + VOICE * abs(sound.voiced - other.voiced)
    )


def lip_closure(sound: Articulation) -> float:
    """How far the lips close: 1 shut, 0.6 teeth on the lip, 0.5 nearly shut, 0 open."""
    if sound.place == "labiodental":
        return 0.6
    if sound.place != "bilabial":
        return 0.0
    return 1.0 if constriction(sound) == 1.0 else 0.5


def constriction(sound: Articulation) -> float:
    """How far tongue or lips close the vocal tract: 1 in stops and nasals, 0.5 in laterals, 0 otherwise.

    Teeth on the lip leave an opening, so [ɱ] counts like a lateral.
    """
    if sound.place == "labiodental":
        return 0.0 if _family(sound) in ("fricative", "approximant") else 0.5
    if sound.manner in STOPS or sound.manner == "nasal":
        return 1.0
    return 0.5 if sound.manner.startswith("lateral") else 0.0


def _family(sound: Articulation) -> str:
    if sound.manner in STOPS:
        return "stop"
    return "fricative" if sound.manner in FRICATIVES else sound.manner


def _syllabic(sounds: tuple[Articulation, ...]) -> tuple[str, ...]:
    """Vowels and glides, after a glottal stop, before a rhotic or a schwa's sonorant; () for other sounds."""
    core = sounds[1:] if sounds[0].symbol == "ʔ" else sounds
    last = core[-1]
    coda: tuple[Articulation, ...] = ()
    if len(core) > 1 and (last.symbol in COLOURS or (core[0].symbol == "ə" and last.symbol in SONORANTS)):
        core, coda = core[:-1], (last,)
    if not all(sound.vowel or sound.symbol in GLIDES for sound in core):
        return ()
    return (*_vowels(core), *_consonants(coda))


def _vowels(sounds: tuple[Articulation, ...]) -> tuple[str, ...]:
    """Vowels and glides: a diphthong of the inventory if one is close, else one phone after the other."""
    first, rest = sounds[0], sounds[1:]
    if not first.vowel:
        return (_nearest(first, "consonant")[0], *(_vowels(rest) if rest else ()))
    if not rest:
        return (_nearest(first, "vowel")[0],)
    end = rest[0] if rest[0].vowel else ipa_symbols()[GLIDES[rest[0].symbol]]
    diphthong, far = _nearest(first, "diphthong", end)
    if far <= DIPHTHONG_NEAR:
        return (diphthong, *(_vowels(rest[1:]) if rest[1:] else ()))
    return (_nearest(first, "monophthong")[0], *_vowels((end, *rest[1:])))


def _consonants(sounds: tuple[Articulation, ...]) -> tuple[str, ...]:
    if not sounds:
        return ()
    first, rest = sounds[0], sounds[1:]
    if rest and constriction(first) == constriction(rest[0]) == 1.0 and _family(first) == _family(rest[0]):
        # Simultaneous, as in [k͡p]: the lips hide the tongue.
        return _consonants((max(first, rest[0], key=lip_closure), *rest[1:]))
    if rest and first.manner in STOPS and rest[0].manner == "sibilant":
        affricate, far = _nearest(replace(rest[0], manner="affricate"), "affricate")
        if far <= AFFRICATE_NEAR:
            return (affricate, *_consonants(rest[1:]))
    return (_nearest(first, "consonant")[0], *_consonants(rest))


def _nearest(start: Articulation, kind: str, end: Articulation | None = None) -> tuple[str, float]:
    """The name of the phone of a kind that looks most like a sound, and its distance."""
    ranked = [(visual_distance(start, end or start, phone), phone.name) for phone in _phones(kind)]
    far, name = min(ranked, key=lambda pair: pair[0])
    return name, far


def _without_repeats(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for n, name in enumerate(names) if n == 0 or name != names[n - 1])


def _kind(sound: Articulation) -> str:
    if sound.symbol in ("w", "ɥ"):
        return "w"
    return {"stop": "s", "fricative": "f", "nasal": "n", "lateral": "l"}.get(_family(sound), "a")


@cache
def _phones(kind: str) -> tuple[Phone, ...]:
    """The phones of a kind: vowel, monophthong, diphthong, consonant or affricate."""
    diphthongs = INVENTORY.attribute("Diphthong-Closing")
    chosen = {
        "vowel": INVENTORY.where(kind="vowel"),
        "monophthong": INVENTORY.where(kind="vowel") & ~diphthongs,
        "diphthong": diphthongs,
        "consonant": INVENTORY.where(kind="consonant"),
        "affricate": INVENTORY.where(manner="affricate"),
    }[kind]
    return tuple(phone for phone, take in zip(INVENTORY.sounds, chosen, strict=True) if take)


@cache
def _articulation(phone: Phone) -> Articulation:
    """A consonant of the inventory as IPA describes it."""
    hissing = INVENTORY.attribute("Sibilant-Fricative")[INVENTORY.code(phone.name)]
    manner = "sibilant" if hissing else phone.manner
    where = (phone.height, phone.backness, phone.rounding)
    return Articulation(phone.name, False, phone.place, manner, float(phone.voiced), *where)
