"""Regressors: phones (or audio) in, modes of the reference face out. One file each; its stem is its kind.

Models of other targets (phonanim/targets) learn rows of numbers of those in place of modes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, ClassVar, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from phonanim.core.catalog import find_model
from phonanim.core.decode import DAMAGE, DecodeError, read_json, read_tensors
from phonanim.core.files import atomic_path
from phonanim.core.plugins import Registry
from phonanim.core.typed import check_types
from phonanim.errors import ModelError
from phonanim.face.model import FaceModel
from phonanim.inputs.speech_input import InputModality as InputModality
from phonanim.media.audio import Sound
from phonanim.recognition.network import load_network
from phonanim.regressors._contract import check_class, check_required
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.targets import StoredTarget, Target, target_class

REGRESSORS = Registry("phonanim.regressors", needs=("REGRESSOR",))

Tensors = dict[str, NDArray[Any]]
Progress = Callable[[float], None]
NEEDS = {
    "phones": "an alignment",
    "audio": "a recording",
    "both": "an alignment and a recording",
    "recognized": "an alignment or a recording",
}
FORMAT = 1
RECOGNITION = "recognition"  # the kind of a model that recognizes phones and animates them by another model
CHECKPOINT = "checkpoint.pt"  # the state of a training, in the model's folder until it ends


@dataclass(frozen=True)
class Examples:
    """Training data of a regressor: per clip the phones, instants (frames,) s, and modes (frames, m).

    Of targets other than landmarks, rows of numbers (frames, m) stand for modes; they may be made on demand.
    `weights` (clips,) scale the clips' squared errors. `sounds` (clips,) are the recordings, for audio-driven
    regressors; `styles` (clips,) are numbers from 0, for clips in several speaking styles.
    """

    tracks: tuple[PhoneTrack, ...]
    times: tuple[NDArray[np.float64], ...]
    targets: Sequence[NDArray[np.float32]]
    weights: tuple[float, ...]
    sounds: tuple[Sound, ...] = ()
    styles: tuple[int, ...] = ()

    def __add__(self, other: Examples) -> Examples:
        return Examples(
            self.tracks + other.tracks,
            self.times + other.times,
            (*self.targets, *other.targets),
            self.weights + other.weights,
            self.sounds + other.sounds,
            self.styles + other.styles,
        )

    def __len__(self) -> int:
        return len(self.tracks)


class Regressor(Protocol):
    """The class that each file of this folder, or a plugin of `phonanim.regressors`, has as `REGRESSOR`.

    A regressor is usually a frozen dataclass of its `config` and the arrays that it has learned. It is
    written as `tensors()` and `config`, and read by `from_tensors`: there is no `save` or `load` to write.
    `fit` must take chance from `rng` alone, so that the same recipe gives the same bytes. `phonanim train`
    tries out what `fit` returns, and says in one line what does not keep this contract.

    Attributes:
        input_modality: The input that is used: "phones" ignores the sound, "audio" ignores the track, "both"
            needs both.
        config_class: A frozen dataclass of numbers, texts, truth values and tuples of them: the keys of
            [settings] in a recipe. A field without a default must be given there.
        config: The settings that it was trained with.
    """

    input_modality: ClassVar[InputModality]
    config_class: ClassVar[type]
    config: Any

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
    ) -> Regressor:
        """Learn from examples; `validation` is used for early stopping only. `progress` takes 0 to 1."""

    def predict(
        self, track: PhoneTrack, times: NDArray[np.float64], sound: Sound | None = None
    ) -> NDArray[np.float32]:
        """Modes at instants of a track or a sound, (times,) seconds -> (times, modes) float32.

        Instants are of any rate, and may lie beyond the ends, where there is silence. None at all give (0,
        modes).
        """

    def tensors(self) -> Tensors:
        """Everything learned: NumPy arrays by name, which weights.safetensors holds."""

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Regressor:
        """The regressor that `tensors` describes. Raises KeyError or ValueError when they do not match."""


@dataclass(frozen=True)
class Model:
    """A trained regressor with what it moves, the face of its modes, and its card (model.json).

    `target` is the reference face, or one of phonanim.targets.

    `articulation` is what phonanim.articulation.from_audio has learned with it, for audio-driven models.
    `recognizer` is the file of the network that recognizes the phones of a recording, for models that do.

    Examples:
        >>> import phonanim
        >>> model = phonanim.load_model("default")
        >>> model.regressor.input_modality
        'phones'
        >>> phonanim.animate("line.TextGrid", model="default").save("line.csv")
    """

    regressor: Regressor
    target: Target
    card: dict[str, Any]
    articulation: Tensors | None = None
    recognizer: Path | None = None

    @property
    def input_modality(self) -> InputModality:
        """The input that is used, as of its regressor; "recognized" where a recording may be read."""
        return self.regressor.input_modality if self.recognizer is None else "recognized"

    @property
    def face(self) -> FaceModel:
        """The reference face of a model of landmarks. Raises ModelError for another target."""
        if isinstance(self.target, FaceModel):
            return self.target
        raise ModelError(
            f"the model moves {self.target.kind}, not landmarks of a face: use phonanim animate or "
            "phonanim corpus score with it"
        )

    def predict(
        self,
        track: PhoneTrack | None,
        fps: float,
        frames: int,
        start: float = 0.0,
        sound: Sound | None = None,
    ) -> NDArray[np.float32]:
        """Modes at the instants start + n / fps, -> (frames, modes) float32.

        Raises ModelError when the input that the model needs is missing.
        """
        modality = self.regressor.input_modality
        if track is None and sound is not None and modality == "audio":
            track = silent_track(sound.duration)
        if track is None or (sound is None and modality != "phones"):
            raise ModelError(f"a model of kind {kind_of(self.regressor)} needs {NEEDS[modality]}")
        return self.regressor.predict(track, start + np.arange(frames) / fps, sound)


def in_style(model: Model, names: Iterable[str]) -> Regressor:
    """The regressor of a model in the first of these styles that it has learned, else in the one it has."""
    known, regressor = model.card.get("styles", []), model.regressor
    for name in names:
        if name in known and hasattr(regressor, "with_settings"):
            styled: Regressor = regressor.with_settings(style=known.index(name))
            return styled
    return regressor


SIZES = (
    *("networks", "reach", "width", "widths", "window", "ahead", "states", "depth", "heads", "kernels"),
    *("dilations", "channels", "hidden", "units"),
)
"""Settings that say how much a model computes."""

MAX_SIZE, MAX_NUMBER, MAX_CARD = 4096, 1e9, 1 << 24
"""Largest of these settings, and of all others, and bytes of a model.json."""

TRIAL = 0.1
"""Seconds of silence that a model of phones is tried out with."""


def kinds() -> tuple[str, ...]:
    """Every kind of regressor: the stems of this folder's files, and the plugins."""
    return REGRESSORS.names()


def kind_of(regressor: Regressor) -> str:
    """The name of a regressor's kind: that of the file or of the plugin whose module defines its class."""
    return REGRESSORS.name_of(type(regressor).__module__)


def regressor_class(kind: str) -> type[Regressor]:
    """The class of a kind. Raises ModelError, which suggests the nearest name, when there is none."""
    found = REGRESSORS.find(kind)
    if found is not None:
        check_class(found, kind)
    else:
        near = get_close_matches(kind, kinds(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ModelError(f"there is no regressor {kind!r}{hint} (known: {', '.join(kinds())})")
    regressor: type[Regressor] = found.REGRESSOR
    return regressor


def make_config(kind: str, values: dict[str, Any], where: str) -> Any:
    """The Config of a kind from a table of values. Raises ModelError, which names an invalid key."""
    config = regressor_class(kind).config_class
    known = [field.name for field in fields(config)]
    for key in values:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(known)}"
            raise ModelError(f"{where}: {kind} has no setting {key!r}; {hint}")
    check_types(values, config, where)
    check_required(config, values, where)
    for key, value in values.items():
        most = MAX_SIZE if key in SIZES else MAX_NUMBER
        listed = value if isinstance(value, (list, tuple)) else [value]
        if any(isinstance(item, (int, float)) and not abs(item) <= most for item in listed):  # nor is NaN
            raise ModelError(f"{where}: {key} is {value!r:.40}; the most is {most:g}")
    return config(**{key: tuple(v) if isinstance(v, list) else v for key, v in values.items()})


def save(model: Model, folder: Path) -> None:
    """Write a model folder: weights.safetensors, face.safetensors, and model.json last.

    Audio-driven models also have articulation.safetensors.
    """
    from safetensors.numpy import save as serialized

    folder.mkdir(parents=True, exist_ok=True)
    learned = {"weights": model.regressor.tensors(), "articulation": model.articulation}
    moved: dict[str, Any] = {}
    if isinstance(model.target, FaceModel):
        save_face(model.target, folder / "face.safetensors")
        moved = {"face": model.target.id}
    else:
        target = cast("StoredTarget", model.target)
        learned["target"] = target.tensors()
        moved = {"target": {"kind": target.kind, **target.facts()}}
    for stem, tensors in learned.items():
        if tensors is not None:
            with atomic_path(folder / f"{stem}.safetensors") as path:
                path.write_bytes(serialized({name: np.ascontiguousarray(t) for name, t in tensors.items()}))
    card = {
        "format": FORMAT,
        "kind": kind_of(model.regressor),
        "config": asdict(model.regressor.config),
        "inventory": list(INVENTORY.phones),
        **moved,
        **model.card,
    }
    with atomic_path(folder / "model.json") as path:
        path.write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")


def save_face(face: FaceModel, path: Path) -> None:
    """Write the reference face of a model folder."""
    from safetensors.numpy import save as serialized

    parts = {"mean": face.mean, "modes": face.modes, "std": face.std}
    shape: Tensors = {name: part.astype(np.float32) for name, part in parts.items()}
    with atomic_path(path) as unfinished:
        unfinished.write_bytes(serialized(shape | {"indices": face.indices}))


def load(folder: Path) -> Model:
    """Read a model folder. Raises ModelError, which names the file when anything in it is invalid.

    Nothing in a model is executed: weights are safetensors, the rest is JSON.
    """
    card = _load_card(folder)
    if card["kind"] == RECOGNITION:
        return _load_recognizer(folder, card)
    target = _load_target(card, folder)
    tensors = _load_tensors(folder / "weights.safetensors")
    kind = card["kind"]
    config = make_config(kind, card["config"], str(folder / "model.json"))
    try:
        regressor = regressor_class(kind).from_tensors(config, tensors)
        _try_out(regressor, target.size)
    except DAMAGE as error:
        raise ModelError(
            f"{folder / 'weights.safetensors'}: does not match its model.json ({error}); train it again"
        ) from error
    articulation = folder / "articulation.safetensors"
    return Model(regressor, target, card, _load_tensors(articulation) if articulation.is_file() else None)


def _load_target(card: dict[str, Any], folder: Path) -> Target:
    """What the model moves: landmarks where the card names nothing else."""
    facts = card.get("target", {"kind": FaceModel.kind})
    if facts == {"kind": FaceModel.kind}:
        return load_face(folder / "face.safetensors")
    path = folder / "target.safetensors"
    try:
        return target_class(str(facts["kind"])).from_parts(facts, _load_tensors(path))
    except (*DAMAGE, AttributeError) as error:
        raise ModelError(f"{path}: does not match model.json ({error}); train the model again") from error


def _load_recognizer(folder: Path, card: dict[str, Any]) -> Model:
    """A model that recognizes phones: the one that animates them, and the file of the network."""
    name = card["config"].get("animated_by")
    other = find_model(name) if isinstance(name, str) else folder
    animated = None if _load_card(other)["kind"] == RECOGNITION else load(other)
    if animated is None or animated.input_modality != "phones":
        raise ModelError(
            f"{folder / 'model.json'}: animated_by is not a phone-driven model; name one, such as default"
        )
    network = folder / "recognizer.safetensors"
    load_network(network)
    return replace(animated, card=card, recognizer=network)


def _try_out(regressor: Regressor, n_modes: int) -> None:
    """Raise DecodeError where a model of phones does not make modes of a moment of silence."""
    if regressor.input_modality != "phones":
        return
    modes = regressor.predict(silent_track(TRIAL), np.array([0.0, TRIAL / 2, TRIAL]))
    if modes.shape != (3, n_modes) or not np.isfinite(modes).all():
        raise DecodeError(f"it makes {modes.shape} modes of 3 frames, and its face has {n_modes}")


def load_face(path: Path) -> FaceModel:
    """The reference face of a model folder. Raises ModelError when it is damaged."""
    tensors = _load_tensors(path)
    try:
        mean, modes, std = (tensors[name].astype(np.float64) for name in ("mean", "modes", "std"))
        indices = tensors["indices"].astype(np.int64)
    except KeyError as error:
        raise ModelError(f"{path}: lacks the tensor {error}; fetch or train the model again") from error
    if mean.ndim != 2 or modes.shape != (len(std), *mean.shape) or indices.shape != mean.shape[:1]:
        raise ModelError(f"{path}: its shapes do not match; fetch or train the model again")
    if not (std > 0).all() or not np.abs(modes).sum(axis=(1, 2)).all():
        raise ModelError(f"{path}: some of its modes move nothing; fetch or train the model again")
    return FaceModel(mean, modes, std, indices)


def _load_card(folder: Path) -> dict[str, Any]:
    path = folder / "model.json"
    try:
        card = read_json(path, MAX_CARD)
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{path}: cannot be read as a model ({error}); `phonanim models` lists the available ones"
        ) from error
    if not isinstance(card, dict) or card.get("format") != FORMAT:
        raise ModelError(f"{path}: is not a model of format {FORMAT}; train it again with this version")
    if card.get("inventory") != list(INVENTORY.phones):
        raise ModelError(f"{path}: was made for another phone inventory; train it again with this version")
    for key, kind in (("kind", str), ("config", dict)):
        if not isinstance(card.get(key), kind):
            raise ModelError(f"{path}: lacks {key!r}, or it is not a {kind.__name__}; fetch the model again")
    return card


def _load_tensors(path: Path) -> Tensors:
    try:
        tensors: Tensors = read_tensors(path)
    except (OSError, DecodeError) as error:
        raise ModelError(f"{path}: cannot be read ({error}); fetch or train the model again") from error
    for name, tensor in tensors.items():
        if tensor.dtype.kind == "f" and not np.isfinite(tensor).all():
            raise ModelError(f"{path}: the tensor {name!r} has numbers that are not finite; train it again")
    return tensors
