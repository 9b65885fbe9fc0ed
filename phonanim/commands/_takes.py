"""Several takes of a line, by a model that samples: one seed and one set of files each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phonanim.options import Options

Take = tuple["Options", tuple[Path, ...], "Path | None"]


@dataclass(frozen=True)
class Sources:
    """The files that a line is made from."""

    alignment: Path
    audio: Path | None
    edits: tuple[Path, ...]

    def paths(self, options: Options) -> list[Path]:
        """Those that there are, and those that the options name."""
        features = Path(options.features) if options.features else None
        return [self.alignment, *filter(None, [self.audio, features]), *self.edits]


def list_takes(count: int, options: Options, outputs: Sequence[Path], sheet: Path | None) -> Iterator[Take]:
    """The options, outputs and contact sheet of each take; with several, `.takeN` stands before the suffix.

    The first take has the seed of the options, or the model's. Raises OptionError when the model does not
    sample.
    """
    from phonanim.errors import OptionError
    from phonanim.pipeline import load_model, samples

    if count == 1:
        yield options, tuple(outputs), sheet
        return
    regressor = load_model(options.model).regressor
    if not samples(regressor):
        raise OptionError(f"the model {options.model} does not sample: leave out --takes")
    first = regressor.config.seed if options.seed is None else options.seed
    for number in range(count):
        files = tuple(number_path(path, number + 1) for path in outputs)
        pictures = number_path(sheet, number + 1) if sheet else None
        yield replace(options, seed=first + number), files, pictures


def number_path(path: Path, number: int) -> Path:
    """The file of a take: line.track.json -> line.take2.track.json."""
    stem, dot, suffixes = path.name.partition(".")
    return path.with_name(f"{stem}.take{number}{dot}{suffixes}")
