"""The options of an animation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from difflib import get_close_matches
from pathlib import PurePath
from typing import Any, Literal

from phonanim.core.catalog import DEFAULT_MODEL
from phonanim.core.typed import check_types
from phonanim.errors import OptionError

MOST_FRAMES = 220_000
"""Frames of a line unless more are asked for: an hour at 60 per second, in less than 20 s and 1 GB."""


@dataclass(frozen=True, slots=True)
class Overlay:
    """A pose or an animation added to the speech: a file or a shipped name, times `gain`.

    It is active from `span[0]` to `span[1]` seconds of the line, or in the whole line when `span` is None.
    """

    source: str
    gain: float = 1.0
    span: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Emotion:
    """An emotion of lexicon/emotions with its weight; `span` as in `Overlay`, in seconds."""

    name: str
    weight: float = 1.0
    span: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Closure:
    """Lips that are held closed ("hold") or kept apart ("release") from `start` to `end`, in seconds."""

    kind: Literal["hold", "release"]
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Options:
    """The options of an animation; the defaults suit speech from any aligner on the shipped head.

    `model` and `rig` are names or paths, `fps` is in hertz, `tier` is detected when it is None. `speaker` is
    required where several people speak, `lexicon` (a dictionary's path) where a file has words only.
    `unit` is the unit of the file's times (s, ms, 100ns, samples@RATE) where it is not that of its format.
    `offset` is the time of the file, in seconds, that is 0 of the animation.
    `fallback` is the language to use where `language` does not exist.
    `intensity`, `jaw`, `lips`, `rounding`, `quickness`, `reduction` and `hold` scale motion; a style sets
    them.
    `loudness` scales how much the mouth follows the level of a recording. `level` is the usual level of the
    speech in dB of full scale; the level of the line itself when it is None. `pitch` finds the pitch of a
    recording: our own estimate, or Praat's with the extra `pitch`.
    `gains` scale single controls, by name; `smooth` is in seconds.
    `life` scales motion besides speech: 0 animates only the mouth. A mapping has a number for each behaviour
    (blinks, gaze, head, brows, breath); a behaviour that is not named has 1. `life_seed` is its seed, derived
    from the line's name when it is None; `blinks` is a separate seed for blinks. `look_at` is the position of
    the listener's eyes, in metres to the left, up and ahead of the speaker's.
    `closures` hold lips closed, or keep them apart, for spans of time.
    `seed`, `steps` and `guidance` are settings of a model that samples, `model_style` is the style of one
    that has several; the model's own when None.
    `features` is the file of precomputed features of the recording, for a model that was trained on such;
    NAME.features.npy beside the recording when it is None.
    60 frames per second show a closure of 30 ms, which 24 or 30 may miss. `most_frames` is the longest line
    that is animated; it changes nothing else.

    Examples:
        >>> import phonanim
        >>> quiet = phonanim.Options(rig="metahuman", intensity=0.7)
        >>> phonanim.animate("line.TextGrid", quiet, fps=24).rig
        'metahuman'
    """

    rig: str = "arkit"
    model: str = DEFAULT_MODEL
    fps: float = 60.0
    language: str = "auto"
    fallback: str | None = None
    tier: str | None = None
    speaker: str | None = None
    lexicon: str | None = None
    unknown: Literal["error", "nearest", "silence"] = "error"
    unit: str | None = None
    offset: float | None = None
    contacts: bool = True
    retarget: Literal["auto", "articulation", "poses", "direct", "solve"] = "auto"
    intensity: float = 1.0
    jaw: float = 1.0
    lips: float = 1.0
    rounding: float = 1.0
    quickness: float = 1.0
    reduction: float = 1.0
    hold: float = 1.0
    loudness: float = 1.0
    level: float | None = None
    pitch: Literal["builtin", "praat"] = "builtin"
    gains: Mapping[str, float] = field(default_factory=dict)
    smooth: float = 0.0
    overlays: tuple[Overlay, ...] = ()
    blinks: int | None = None
    life: float | Mapping[str, float] = 1.0
    life_seed: int | None = None
    look_at: tuple[float, float, float] | None = None
    emotions: tuple[Emotion, ...] = ()
    closures: tuple[Closure, ...] = ()
    seed: int | None = None
    steps: int | None = None
    guidance: float | None = None
    model_style: int | None = None
    features: str | None = None
    most_frames: int = MOST_FRAMES

    def plain(self) -> dict[str, Any]:
        """The options that change outputs, as JSON values; files appear by name, as on every machine."""
        overlays = [replace(overlay, source=PurePath(overlay.source).name) for overlay in self.overlays]
        lexicon = PurePath(self.lexicon).name if self.lexicon else None
        rig, model = PurePath(self.rig).name, PurePath(self.model).name
        named = {"rig": rig, "model": model, "overlays": overlays, "lexicon": lexicon}
        named["features"] = PurePath(self.features).name if self.features else None
        values = {name: named.get(name, getattr(self, name)) for name in _NAMES}
        rare = (*SAMPLED, "features")  # outputs name them only where they are given
        values = {name: value for name, value in values.items() if value is not None or name not in rare}
        return {name: _plain(value) for name, value in values.items()}


def _plain(value: Any) -> Any:
    """A value as JSON gives it back."""
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(name): _plain(one) for name, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, (tuple, list)) else value


SAMPLED = ("seed", "steps", "guidance", "model_style")
"""Options of models that sample."""

_NAMES = tuple(field.name for field in fields(Options) if field.name != "most_frames")
DEFAULTS = Options()


def make_options(options: Options | None, settings: Mapping[str, Any]) -> Options:
    """Options with some of them set by name.

    Raises OptionError for an unknown name, suggesting the nearest, and for a value of the wrong type.
    """
    known = [field.name for field in fields(Options)]
    for name in settings:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"the options are {', '.join(known)}"
            raise OptionError(f"there is no option {name!r}; {hint}")
    plain: dict[str, Any] = {
        name: str(value) if isinstance(value, PurePath) else value for name, value in settings.items()
    }
    check_types(plain, Options, "options", OptionError)
    return replace(options or DEFAULTS, **plain)
