"""Styles of phone-driven regressors, such as speakers or emotions; a model of one style knows none of this.

Regressors with inputs get a column for each style, which is 1 for the one that is meant, as the one-hot
speakers of VOCA (Cudeiro et al. 2019). Those of statistics alone move the mean of each style (OffsetStyles).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError
from phonanim.regressors import Examples, Tensors

Floats = NDArray[np.float32]
Styled = TypeVar("Styled", bound=Any)


def style_columns(styles: int) -> int:
    """Number of columns that styles add to the inputs."""
    return styles if styles > 1 else 0


def add_style(rows: Floats, style: int, styles: int) -> Floats:
    """Inputs with the columns of their style, (rows, features) -> (rows, features + columns)."""
    columns = np.zeros((len(rows), style_columns(styles)), np.float32)
    if columns.shape[1]:
        columns[:, style] = 1
    return np.concatenate([rows, columns], axis=1) if columns.shape[1] else rows


def styles_of(examples: Examples) -> tuple[int, ...]:
    """The style of each clip; the first where none is given."""
    return examples.styles or (0,) * len(examples)


def layer_of_style(weights: Floats, bias: Floats, config: Any) -> tuple[Floats, Floats]:
    """A first layer with the row of its style in the bias, (features + columns, out) -> (features, out)."""
    columns = style_columns(config.styles)
    if not columns:
        return weights, bias
    return weights[:-columns], bias + weights[config.style - columns]


def check_styles(kind: str, styles: int, *examples: Examples) -> None:
    """Raise ModelError when examples have a style that the configuration does not have.

    With one style, all examples are of it.
    """
    most = max((style for part in examples for style in part.styles), default=0)
    if styles > 1 and most >= styles:
        raise ModelError(f"{kind}: the examples have style {most}; set styles to {most + 1} or more")


def check_style(kind: str, config: Any) -> None:
    """Raise ModelError when the style of a configuration is none of its styles."""
    if not 0 <= config.style < config.styles:
        raise ModelError(f"{kind}: there is no style {config.style}; take 0 to {config.styles - 1}")


def with_style(regressor: Styled, settings: dict[str, Any]) -> Styled:
    """The same regressor with another `style`. Raises ModelError for a style or a setting that it lacks."""
    for name in settings:
        if name != "style":
            raise ModelError(f"the model does not sample: leave out --{name}")
    found: Styled = replace(regressor, config=replace(regressor.config, **settings))
    return found


OFFSETS = "offsets"  # the name of the tensor


@dataclass(frozen=True)
class OffsetStyles:
    """The part of a regressor whose styles differ in their mean alone.

    `config` has `styles` and `style`; `offsets` (styles, modes) is what the mean of each style has beyond
    that of all examples, None with one style.
    """

    config: Any

    def with_settings(self: Styled, **settings: Any) -> Styled:
        """The same model with another `style`. Raises ModelError for a style or setting that it lacks."""
        return with_style(self, settings)

    def in_style(self, rows: Floats, offsets: Floats | None) -> Floats:
        """Predicted rows (times, modes) with the mean of the style."""
        return rows if offsets is None else np.asarray(rows + offsets[self.config.style], np.float32)


def split_offsets(kind: str, styles: int, examples: Examples) -> tuple[Examples, Floats | None]:
    """Examples without the offsets of their styles, and these, (styles, modes), None with one style.

    A style without examples has the offset 0. Raises ModelError for a style beyond `styles`.
    """
    check_styles(kind, styles, examples)
    if styles < 2:
        return examples, None
    count, total = np.zeros((styles, 1)), np.zeros((styles, examples.targets[0].shape[1]))
    for style, target in zip(styles_of(examples), examples.targets, strict=True):
        count[style] += len(target)
        total[style] += target.sum(axis=0, dtype=np.float64)
    mean = total.sum(axis=0) / count.sum()
    offsets = np.where(count > 0, total / np.maximum(count, 1) - mean, 0.0).astype(np.float32)
    pairs = zip(styles_of(examples), examples.targets, strict=True)
    return replace(examples, targets=tuple(target - offsets[style] for style, target in pairs)), offsets


def offset_tensors(offsets: Floats | None) -> Tensors:
    """What a model stores of its offsets."""
    return {} if offsets is None else {OFFSETS: offsets}


def read_offsets(styles: int, modes: int, tensors: Tensors) -> Floats | None:
    """Offsets as they were stored. Raises KeyError or ValueError when they do not match the configuration."""
    if styles < 2:
        return None
    offsets = tensors[OFFSETS]
    if offsets.shape != (styles, modes):
        raise ValueError(f"{OFFSETS} is {offsets.shape}, not {(styles, modes)}")
    return offsets.astype(np.float32)
