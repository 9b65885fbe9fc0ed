"""The options that `animate` and `batch` share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from phonanim.animation.option_parsing import (
    LARGEST,
    parse_closures,
    parse_gains,
    parse_smoothing,
)
from phonanim.animation.rates import parse_rate
from phonanim.commands import Console
from phonanim.commands._numbers import Number
from phonanim.commands._option_values import (
    option_callback,
    parse_overlays,
    read_emotions,
    read_level,
    read_life,
    read_look_at,
    read_unit,
)
from phonanim.commands._renamed import renamed_option
from phonanim.core.threads import use_one_thread
from phonanim.options import DEFAULTS, Options

if TYPE_CHECKING:
    from phonanim.articulation.styles import ChosenStyle


GAIN = Number(0, LARGEST)

OPTIONS = (
    click.option("--rig", metavar="RIG", default=DEFAULTS.rig, help="Rig, by name or TOML file."),
    click.option("--model", metavar="MODEL", default=DEFAULTS.model, help="Model, by name or folder."),
    click.option(
        "--fps",
        metavar="RATE",
        callback=option_callback(parse_rate),
        default=f"{DEFAULTS.fps:g}",
        help="Frames per second, such as 25 or 29.97.",
    ),
    click.option(
        "--most-frames",
        metavar="COUNT",
        type=click.IntRange(1, 100_000_000),
        default=DEFAULTS.most_frames,
        help="Longest line that is animated; longer ones take minutes.",
    ),
    click.option(
        "--language", metavar="LANGUAGE", default=DEFAULTS.language, help="Label set of the phone tier."
    ),
    renamed_option(
        "--fallback-language",
        "--fallback",
        metavar="LANGUAGE",
        help="Label set to use where --language names one that does not exist, such as ipa.",
    ),
    click.option(
        "--tier", metavar="TIER", help="Name of the phone tier; detected by name and content by default."
    ),
    click.option("--speaker", metavar="SPEAKER", help="Speaker to animate, in a file of several speakers."),
    click.option(
        "--lexicon",
        type=click.Path(exists=True, dir_okay=False),
        help="Pronunciation dictionary (CMU or MFA format) for words without phones; for English, CMU's.",
    ),
    renamed_option(
        "--on-unknown-label",
        "--unknown",
        type=click.Choice(["error", "nearest", "silence"]),
        default=DEFAULTS.unknown,
        help="How to handle a label that is not in the label set, or a word that cannot be spelled.",
    ),
    click.option(
        "--unit",
        metavar="UNIT",
        callback=option_callback(read_unit),
        help="Unit of the alignment's times: s, ms, 100ns or samples@RATE; that of its format by default.",
        show_default=False,
    ),
    click.option(
        "--offset",
        type=Number(0, 86_400),
        metavar="SECONDS",
        help="Time of the alignment that is 0 of the animation.",
        show_default=False,
    ),
    click.option(
        "--contacts/--no-contacts",
        default=DEFAULTS.contacts,
        help="Enforce full lip contact on p b m and lip-teeth contact on f v.",
    ),
    click.option(
        "--retarget",
        type=click.Choice(["auto", "articulation", "poses", "direct", "solve"]),
        default=DEFAULTS.retarget,
        help="How controls are computed: by articulation, eight poses, a direct map, or frame by frame.",
    ),
    click.option("--intensity", type=GAIN, default=DEFAULTS.intensity, help="Scale all motion."),
    click.option("--jaw", type=GAIN, default=DEFAULTS.jaw, help="Scale the motion of the jaw."),
    click.option("--lips", type=GAIN, default=DEFAULTS.lips, help="Scale the motion of the lips."),
    click.option(
        "--rounding",
        type=GAIN,
        default=DEFAULTS.rounding,
        help="Scale the protrusion and narrowing of the lips.",
    ),
    click.option(
        "--quickness",
        type=Number(0.5, 2),
        default=DEFAULTS.quickness,
        help="Speed of the transitions between phones.",
    ),
    click.option(
        "--reduction",
        type=GAIN,
        default=DEFAULTS.reduction,
        help="Scale the effect of stress and speech rate.",
    ),
    click.option(
        "--hold", type=GAIN, default=DEFAULTS.hold, help="Scale the variation of the mouth in held vowels."
    ),
    click.option(
        "--loudness",
        type=GAIN,
        default=DEFAULTS.loudness,
        help="How much the mouth follows the level of the recording; 0 not at all.",
    ),
    click.option(
        "--level",
        metavar="DB|FILE",
        callback=option_callback(read_level),
        help="Usual speech level, in dB of full scale or as a recording; the line's own mean by default.",
        show_default=False,
    ),
    click.option(
        "--pitch",
        type=click.Choice(["builtin", "praat"]),
        default=DEFAULTS.pitch,
        help="How the pitch of the recording is found; praat needs phonanim[pitch].",
    ),
    click.option(
        "--style",
        metavar="STYLE",
        help="mumbled, casual, neutral, clear, shouted, whispered, sung, quiet: named settings of "
        "the scaling options; or a style that a model has learned, by name (learned:NAME where the name "
        "alone means another) or number.",
        show_default=False,
    ),
    click.option(
        "--gain",
        "gains",
        metavar="CONTROL=NUMBER",
        multiple=True,
        callback=option_callback(parse_gains),
        help="Scale the motion of one control. Repeatable.",
    ),
    click.option(
        "--smooth",
        metavar="SECONDS|RATE",
        callback=option_callback(parse_smoothing),
        default="0",
        help="Smooth the curves but keep closures; seconds or hertz, such as 0.05 or 6Hz.",
    ),
    click.option(
        "--overlay",
        "overlays",
        metavar="FILE[=GAIN][@START-END]",
        multiple=True,
        callback=option_callback(parse_overlays),
        help="Add a pose or an animation to the speech. Repeatable.",
    ),
    click.option(
        "--life",
        metavar="GAIN|NAME=GAIN,...",
        callback=option_callback(read_life),
        default="1",
        help="Motion besides speech (blinks, gaze, head, brows, breath); 0 animates only the mouth.",
    ),
    click.option(
        "--life-seed",
        type=click.IntRange(min=0),
        metavar="SEED",
        help="Seed of the motion besides speech; by default derived from the line's name.",
        show_default=False,
    ),
    click.option(
        "--blinks", type=click.IntRange(min=0), metavar="SEED", help="Separate seed for the blinks."
    ),
    click.option(
        "--look-at",
        metavar="X,Y,Z",
        callback=option_callback(read_look_at),
        help="Position of the listener's eyes, in metres to the speaker's left, up and ahead.",
    ),
    click.option(
        "--emotion",
        "emotions",
        metavar="NAME[=WEIGHT][@START-END]|FILE.csv",
        multiple=True,
        callback=option_callback(read_emotions),
        help="Show an emotion: joy, sadness, anger, fear, disgust, surprise. Repeatable.",
    ),
    click.option(
        "--closure",
        "closures",
        metavar="hold|release@START-END",
        multiple=True,
        callback=option_callback(parse_closures),
        help="Hold the lips closed, or keep them apart, for a span of seconds. Repeatable.",
    ),
    click.option(
        "--seed",
        type=click.IntRange(0),
        help="Random seed of a sampling model; each seed gives another take.",
    ),
    click.option("--steps", type=click.IntRange(1), help="Sampling steps of a sampling model."),
    click.option(
        "--guidance",
        type=Number(0, LARGEST),
        help="Weight of the audio in a sampling model; 1 uses the prediction with audio alone.",
    ),
)


def read_style(style: str | None, model: str, styles: Path | None) -> ChosenStyle:
    """A style with the dials that are not given directly. Raises OptionError for an unknown one."""
    from phonanim.articulation.styles import ChosenStyle, choose_style, read_styles

    if style is None:
        return ChosenStyle()
    source = click.get_current_context().get_parameter_source
    chosen = choose_style(style, model, read_styles(styles))
    free = {dial: gain for dial, gain in chosen.dials.items() if source(dial) is ParameterSource.DEFAULT}
    return replace(chosen, dials=free)


def animation_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of an animation, passed to the command as `options`."""
    use_one_thread()  # before the options are parsed, because some of them import NumPy

    @wraps(function)
    def wrapped(*args: Any, **given: Any) -> Any:
        chosen = read_style(given.pop("style"), given["model"], given.get("styles"))
        given |= {**chosen.dials, "model_style": chosen.number}
        if "styles" in given:  # lines of a table may set their own styles
            given["styled"] = chosen
        if chosen.note:
            Console(given["as_json"], given["quiet"]).print(f"--style {chosen.name}: {chosen.note}")
        options = Options(
            **{field.name: given.pop(field.name) for field in fields(Options) if field.name in given}
        )
        return function(*args, options=options, **given)

    decorated: Callable[..., Any] = wrapped
    for add in reversed(OPTIONS):
        decorated = add(decorated)
    return decorated
