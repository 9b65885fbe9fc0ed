"""Write and read a model folder."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from phonanim.core.catalog import find_model
from phonanim.core.decode import DAMAGE, DecodeError, read_json, read_tensors
from phonanim.core.files import atomic_path
from phonanim.errors import ModelError
from phonanim.face.model import FaceModel
from phonanim.recognition.network import load_network
from phonanim.regressors._kinds import kind_of, make_config, regressor_class
from phonanim.regressors._model import Model
from phonanim.regressors._protocol import Regressor, Tensors
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import silent_track
from phonanim.targets import StoredTarget, Target, target_class

FORMAT = 1
RECOGNITION = "recognition"  # the kind of a model that recognizes phones and animates them by another model
MAX_CARD = 1 << 24  # bytes of a model.json
TRIAL = 0.1  # seconds of silence that a model of phones is tried out with


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
