"""The options of recordings of articulography, which `corpus build` and `ema report` share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands._numbers import Number
from phonanim.commands._renamed import renamed_option

if TYPE_CHECKING:
    from phonanim.ema.posture import Posture
    from phonanim.ema.report import Preparation

PLATE = 3  # sensors
OPTIONS = (
    click.option("--axes", help="Directions of x, y and z of sensors in the files, such as left,back,up."),
    click.option(
        "--names",
        help="Names of sensors or controls in order: separated by commas, or a file with one a line; "
        "- leaves a sensor out.",
    ),
    click.option(
        "--reference", help="Sensors on the skull, separated by commas: remove head motion by them."
    ),
    renamed_option(
        "--bite-plate",
        "--bite",
        type=click.Path(exists=True, dir_okay=False, path_type=Path),
        help="A recording with a plate between the teeth: rotate to its plane.",
    ),
    click.option("--plate", default="front,left,right", help="Sensors of the plate, separated by commas."),
    click.option("--origin", default="", help="Sensor of the plate's recording that becomes the origin."),
    click.option("--rate", type=Number(10, 2000), help="Resample all sensors to this rate, in hertz."),
)


@dataclass(frozen=True)
class SensorOptions:
    """What the options say; `axes` and `rate` are None where they are not given."""

    axes: str | None
    names: tuple[str, ...]
    references: tuple[str, ...]
    bite: Path | None
    plate: tuple[str, ...]
    origin: str
    rate: float | None

    def given(self) -> list[str]:
        """The options that are given, but --names and --rate."""
        found = {"axes": self.axes, "reference": self.references, "bite-plate": self.bite}
        return [f"--{name}" for name, value in found.items() if value]

    def preparation(self, folder: Path, rate: float | None = None) -> Preparation:
        """How to prepare the recordings of a folder, at `rate` where no other is given.

        Raises UsageError for options that do not fit together, CorpusError, OptionError.
        """
        from phonanim.ema.report import Preparation

        plate = self.bite.stem if self.bite else ""
        return Preparation(self.names, self.axes, self.posture(folder), self.rate or rate, plate)

    def posture(self, folder: Path) -> Posture | None:
        """The head at rest: from the recording of the plate, or from the folder's first recording."""
        from phonanim.ema.articulation import rename_sensors
        from phonanim.ema.posture import bite_posture, rest_posture
        from phonanim.ema.readers import read_articulation
        from phonanim.ema.utterances import find_spoken

        if not self.references:
            if self.bite:
                raise click.UsageError(
                    "--bite-plate needs --reference: sensors on the skull that both recordings have"
                )
            return None
        raw = read_articulation(self.bite) if self.bite else find_spoken(folder)[0].sensors()
        named = rename_sensors(raw, self.names) if self.names else raw
        if self.bite is None:
            return rest_posture(named, self.references)
        if len(self.plate) != PLATE:
            raise click.UsageError(f"--plate names {len(self.plate)} sensors; give front, left and right")
        front, left, right = self.plate
        return bite_posture(named, self.references, (front, left, right), self.origin)


def sensor_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of sensors, passed to the command as `sensors`."""

    @wraps(function)
    def wrapped(*args: Any, **given: Any) -> Any:
        sensors = SensorOptions(
            given.pop("axes"),
            parse_names(given.pop("names")),
            split_words(given.pop("reference")),
            given.pop("bite"),
            split_words(given.pop("plate")),
            given.pop("origin"),
            given.pop("rate"),
        )
        return function(*args, sensors=sensors, **given)

    decorated: Callable[..., Any] = wrapped
    for add in reversed(OPTIONS):
        decorated = add(decorated)
    return decorated


def parse_names(text: str | None) -> tuple[str, ...]:
    """Names separated by commas, or the lines of a file. Raises UsageError for a file that is not text."""
    if not text or not Path(text).is_file():
        return split_words(text)
    from phonanim.core.decode import DecodeError, read_utf8

    try:
        lines = read_utf8(Path(text)).removeprefix("\ufeff").splitlines()
    except (OSError, DecodeError) as error:
        raise click.UsageError(f"--names {text}: cannot be read ({error}); give a name a line") from error
    return tuple(line.strip() for line in lines if line.strip())


def split_words(text: str | None) -> tuple[str, ...]:
    """Words separated by commas."""
    return tuple(word.strip() for word in text.split(",")) if text else ()
