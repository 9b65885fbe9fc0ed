"""The weighted mean of regressors, for ensemble.py and late_fusion.py."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import (
    Examples,
    InputModality,
    Progress,
    Regressor,
    Tensors,
    make_config,
    regressor_class,
)
from phonanim.regressors._journal import end_parts, part_of
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Self = TypeVar("Self", bound="MeanOfModels")


@dataclass(frozen=True)
class Config:
    """`members` are tables: kind, weight, and the settings of that kind.

    Members with several styles have the same ones. Raises ModelError where they differ, and for a member
    without a kind.
    """

    members: tuple[dict[str, Any], ...] = ()

    def __post_init__(self) -> None:
        if not all("kind" in member for member in self.members):
            raise ModelError("a member has no kind; give each one, such as kind = 'dnn'")
        for name in ("styles", "style"):
            found = sorted({member.get(name, 0) for member in self._styled})
            if len(found) > 1:
                listed = " and ".join(map(str, found))
                raise ModelError(f"members have {name} = {listed}; give all the same one, or styles = 1")

    @property
    def styles(self) -> int:
        """The number of styles that its members have learned; 1 without any."""
        return max((member["styles"] for member in self._styled), default=1)

    @property
    def style(self) -> int:
        """The style that is predicted."""
        return max((member.get("style", 0) for member in self._styled), default=0)

    @property
    def _styled(self) -> list[dict[str, Any]]:
        return [member for member in self.members if _has_styles(member)]


def _has_styles(member: dict[str, Any]) -> bool:
    """Whether the table of a member has several styles; its types are checked later."""
    styles = member.get("styles", 1)
    return isinstance(styles, int) and styles > 1


@dataclass(frozen=True)
class MeanOfModels:
    """Regressors and their weights, which sum to one."""

    config: Config
    members: tuple[Regressor, ...]
    weights: tuple[float, ...]

    input_modality: ClassVar[InputModality]
    config_class: ClassVar[type] = Config
    resumable: ClassVar[bool] = True

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes)."""
        parts = [m.predict(track, times, sound) for m in self.members]
        return np.asarray(np.average(parts, axis=0, weights=self.weights), np.float32)

    def with_settings(self: Self, **settings: Any) -> Self:
        """The same models in another `style`. Raises ModelError for a style or a setting that they lack."""
        for name in settings:
            if name != "style":
                raise ModelError(f"the model does not sample: leave out --{name}")
        if self.config.styles < 2:
            raise ModelError("the models have no styles: leave out --style")
        tables, members = list(self.config.members), list(self.members)
        for number, table in enumerate(tables):
            if _has_styles(table):
                tables[number] = {**table, **settings}
                members[number] = _with_settings(members[number], table["kind"], settings)
        return replace(self, config=Config(tuple(tables)), members=tuple(members))

    def tensors(self) -> Tensors:
        """Every member's tensors, under its number."""
        return {f"{n}.{k}": t for n, m in enumerate(self.members) for k, t in m.tensors().items()}

    @classmethod
    def from_tensors(cls: type[Self], config: Any, tensors: Tensors) -> Self:
        """Raises KeyError or ValueError when a member's tensors do not match."""
        kinds, configs, weights = _members(config)
        members = [
            regressor_class(kind).from_tensors(
                settings,
                {k.partition(".")[2]: t for k, t in tensors.items() if k.partition(".")[0] == str(number)},
            )
            for number, (kind, settings) in enumerate(zip(kinds, configs, strict=True))
        ]
        return cls(config, tuple(members), weights)

    @classmethod
    def fit(
        cls: type[Self],
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Self:
        """Fit the members one after the other.

        If `journal` is a folder, the states of `resumable` members are saved in folders of it, and an
        interrupted training is continued from them.
        """
        kinds, configs, weights = _members(config)
        members = []
        for number, (kind, settings) in enumerate(zip(kinds, configs, strict=True)):

            def share(done: float, number: int = number) -> None:
                progress((number + done) / len(kinds))

            fit: Any = regressor_class(kind).fit
            if getattr(regressor_class(kind), "resumable", False):
                fit = partial(fit, journal=part_of(journal, f"member{number}"))
            members.append(fit(settings, train, validation, rng, share))
        end_parts(journal, [f"member{number}" for number in range(len(kinds))])
        filled = tuple(
            {"kind": kind, "weight": weight, **asdict(settings)}
            for kind, weight, settings in zip(kinds, weights, configs, strict=True)
        )
        return cls(Config(filled), tuple(members), weights)


def _with_settings(member: Any, kind: str, settings: dict[str, Any]) -> Regressor:
    if not hasattr(member, "with_settings"):
        raise ModelError(f"the member {kind} has no with_settings, by which its style is chosen")
    changed: Regressor = member.with_settings(**settings)
    return changed


def _members(config: Config) -> tuple[list[str], list[Any], tuple[float, ...]]:
    kinds, configs, weights = [], [], []
    for member in config.members:
        settings = {key: value for key, value in member.items() if key not in ("kind", "weight")}
        kinds.append(member["kind"])
        configs.append(make_config(member["kind"], settings, "ensemble"))
        weights.append(float(member.get("weight", 1.0)))
    total = sum(weights)
    return kinds, configs, tuple(weight / total for weight in weights)
