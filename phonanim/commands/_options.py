"""The options that `animate` and `batch` share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any

import click

from phonanim.errors import OptionError
from phonanim.options import DEFAULTS, Options, Overlay
from phonanim.rates import parse_rate
from phonanim.threads import one_thread


def rate(ctx: click.Context, param: click.Parameter, value: str) -> float:
    """Frames per second; NTSC rates are taken exactly."""
    try:
        return parse_rate(value)
    except OptionError as error:
        raise click.BadParameter(str(error)) from error


class Gain(click.FloatRange):
    """A number within limits; click lets NaN through its ranges."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number itself."""
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


GAIN = Gain(0, 4)
SECONDS = Gain(0)


def gains(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> dict[str, float]:
    """Gains by control, from CONTROL=NUMBER."""
    found = {}
    for value in values:
        control, sign, number = value.partition("=")
        if not (control and sign):
            raise click.BadParameter(f"{value!r} is not CONTROL=NUMBER, such as jawOpen=1.2")
        if control in found:
            raise click.BadParameter(f"{control} has two gains; give it one")
        found[control] = GAIN.convert(number, param, ctx)
    return found


LAID = re.compile(r"(?P<source>.+?)(=(?P<gain>[\d.]+))?(@(?P<start>[\d.]+)-(?P<end>[\d.]+))?")


def overlays(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> tuple[Overlay, ...]:
    """Overlays, from FILE, FILE=GAIN, FILE@START-END or FILE=GAIN@START-END."""
    found = []
    for value in values:
        parts = LAID.fullmatch(value)
        if parts is None:
            raise click.BadParameter("names no file; write FILE=GAIN@START-END, such as smile=0.5@1.2-3")
        gain = GAIN.convert(parts["gain"] or "1", param, ctx)
        span = tuple(SECONDS.convert(parts[end], param, ctx) for end in ("start", "end") if parts[end])
        if span and span[0] >= span[1]:
            raise click.BadParameter(f"{value}: its span must end after it starts, such as @1.2-3")
        found.append(Overlay(parts["source"], gain, (span[0], span[1]) if span else None))
    return tuple(found)


def smoothing(ctx: click.Context, param: click.Parameter, value: str) -> float:
    """Seconds of smoothing, from seconds or from the frequency in Hz that it halves the power of."""
    from phonanim.smooth import LONGEST, width_of

    number = value.lower().removesuffix("hz")
    hertz = number != value.lower()
    try:
        seconds = width_of(float(number)) if hertz else float(number)
    except (ValueError, ZeroDivisionError):
        seconds = math.nan
    if not 0 <= seconds <= LONGEST:
        raise click.BadParameter(f"{value!r} is neither 0 to {LONGEST:g} seconds nor a rate such as 8Hz")
    return seconds


OPTIONS = (
    click.option("--rig", default=DEFAULTS.rig, help="Rig, by name or TOML file."),
    click.option("--model", default=DEFAULTS.model, help="Model, by name or folder."),
    click.option(
        "--fps",
        metavar="RATE",
        callback=rate,
        default=f"{DEFAULTS.fps:g}",
        help="Frames per second: 25, 29.97, ...",
    ),
    click.option("--language", default=DEFAULTS.language, help="Label set of the phone tier."),
    click.option("--tier", help="Phone tier, by name; found by name and content otherwise."),
    click.option("--speaker", help="Who is animated, in a file of several speakers."),
    click.option(
        "--lexicon",
        type=click.Path(exists=True, dir_okay=False),
        help="Pronunciation dictionary (CMU or MFA form) for a file of words alone.",
    ),
    click.option(
        "--unknown",
        type=click.Choice(["error", "nearest", "silence"]),
        default=DEFAULTS.unknown,
        help="What becomes of a label that the language lacks.",
    ),
    click.option(
        "--contacts/--no-contacts",
        default=DEFAULTS.contacts,
        help="Make lips and teeth really meet on p b m f v.",
    ),
    click.option(
        "--retarget",
        type=click.Choice(["auto", "poses", "direct", "solve"]),
        default=DEFAULTS.retarget,
        help="Map to the rig by its eight poses, by its direct map, or solve each frame on its head.",
    ),
    click.option("--intensity", type=GAIN, default=DEFAULTS.intensity, help="Scale all motion."),
    click.option("--jaw", type=GAIN, default=DEFAULTS.jaw, help="Scale the motion of the jaw."),
    click.option("--lips", type=GAIN, default=DEFAULTS.lips, help="Scale the motion of the lips."),
    click.option(
        "--gain",
        "gains",
        metavar="CONTROL=NUMBER",
        multiple=True,
        callback=gains,
        help="Scale the motion of one control; more than one is fine.",
    ),
    click.option(
        "--smooth",
        metavar="SECONDS|RATE",
        callback=smoothing,
        default="0",
        help="Smooth the curves but keep closures: 0.05 or 6Hz.",
    ),
    click.option(
        "--overlay",
        "overlays",
        metavar="FILE[=GAIN][@START-END]",
        multiple=True,
        callback=overlays,
        help="Lay a pose or an animation over the speech; more than one is fine.",
    ),
    click.option("--blinks", type=click.IntRange(min=0), metavar="SEED", help="Blink, by this seed."),
)


def animation_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of an animation, handed to the command as `options`."""

    @wraps(function)
    def wrapped(*args: Any, **given: Any) -> Any:
        one_thread()
        options = Options(**{field.name: given.pop(field.name) for field in fields(Options)})
        return function(*args, options=options, **given)

    decorated: Callable[..., Any] = wrapped
    for add in reversed(OPTIONS):
        decorated = add(decorated)
    return decorated
