"""Styles of phone-driven regressors: a column for each, which is 1 for the speaker or emotion that is meant.

As the one-hot speakers of VOCA (Cudeiro et al. 2019). A model of one style has no such columns.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError
from phonanim.regressors import Examples

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
    """Raise ModelError when examples have a style that the configuration does not have."""
    most = max((style for part in examples for style in part.styles), default=0)
    if most >= styles:
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
