"""The parts that need the USD library: binary stages, and reading."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, decode_rate, decode_table, parse_json
from phonanim.core.files import atomic_path
from phonanim.errors import MissingExtraError, OutputError
from phonanim.exporters._curves import merge_target_curves
from phonanim.exporters._take import build_take, check_times, take_grid
from phonanim.exporters._usd_mesh import JOINT
from phonanim.rig.neck import TURNS, angles

Weights = tuple[NDArray[np.float64], tuple[str, ...], float, float, dict[str, Any]]


def library() -> Any:
    """The `pxr` package. Raises MissingExtraError."""
    try:
        import pxr.Sdf
        import pxr.Usd
        import pxr.UsdSkel
    except ImportError as error:
        raise MissingExtraError("binary USD needs the USD library: pip install 'phonanim[usd]'") from error
    return pxr


def write_binary(text: str, path: Path) -> None:
    """Write a stage given as text in the binary form. Raises OutputError, MissingExtraError."""
    pxr = library()
    layer = pxr.Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    with tempfile.TemporaryDirectory() as folder, atomic_path(path) as partial:
        made = Path(folder) / "stage.usdc"
        try:
            layer.Export(str(made))
        except pxr.Tf.ErrorException as error:
            message = f"{path}: the USD library cannot write to {folder}; free space there, or set TMPDIR"
            raise OutputError(message) from error
        partial.write_bytes(made.read_bytes())


def read_weights(path: Path) -> Weights:
    """Weights (frames, targets), names, start in seconds, frames per second, and phonanim's own metadata."""
    pxr = library()
    try:
        stage = pxr.Usd.Stage.Open(str(path))
    except pxr.Tf.ErrorException as error:
        raise OutputError(f"{path}: is not a readable USD stage") from error
    for prim in stage.Traverse():
        animation = pxr.UsdSkel.Animation(prim)
        if animation and animation.GetBlendShapeWeightsAttr().GetNumTimeSamples():
            try:
                return _sampled(stage, animation, path)
            except DAMAGE as error:
                raise OutputError(f"{path}: its animation is damaged: {error}; export it again") from error
    raise OutputError(f"{path}: has no SkelAnimation of blend shape weights; export it with its shape keys")


def _sampled(stage: Any, animation: Any, path: Path) -> Weights:
    """The weights at every whole time code between the first and the last sample."""
    known = _shape_names(stage)
    names = tuple(known.get(str(name), str(name)) for name in animation.GetBlendShapesAttr().Get() or ())
    attribute = animation.GetBlendShapeWeightsAttr()
    rate = decode_rate(float(stage.GetTimeCodesPerSecond()), "timeCodesPerSecond")
    times = np.array(attribute.GetTimeSamples(), float)
    check_times(times / rate, "its animation")
    codes = take_grid(times[0] / rate, times[-1] / rate, rate, len(names), path) * rate
    values = np.array([attribute.Get(code) for code in codes], float)
    if values.shape != (len(codes), len(names)):
        raise OutputError(
            f"{path}: {len(names)} blend shapes have {values.shape[-1]} weights; export it again"
        )
    note = animation.GetPrim().GetCustomDataByKey("phonanim")
    about = decode_table(parse_json(str(note)), "what phonanim left there") if note else {}
    turns = _head_turns(animation, codes) if about else {}
    values = np.concatenate([values, *(curve[:, None] for curve in turns.values())], axis=1)
    return values, (*names, *turns), float(times[0]) / rate, rate, about


def _head_turns(animation: Any, codes: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Degrees of the head at time codes, by channel, where phonanim has written its joint."""
    rotations = animation.GetRotationsAttr()
    joints = [str(joint) for joint in animation.GetJointsAttr().Get() or ()]
    if joints != [JOINT] or not rotations.GetNumTimeSamples():
        return {}
    found = [rotations.Get(code)[0] for code in codes]
    rows = np.array([[*rotation.GetImaginary(), rotation.GetReal()] for rotation in found], float)
    turns = angles(rows / np.linalg.norm(rows, axis=1, keepdims=True))
    return dict(zip(TURNS, turns.T, strict=True))


def _shape_names(stage: Any) -> dict[str, str]:
    """The shape that a weight moves, where weights were numbered (jawOpen2) because meshes share names."""
    found = {}
    for prim in stage.Traverse():
        binding = library().UsdSkel.BindingAPI(prim)
        tokens = binding.GetBlendShapesAttr().Get() or ()
        for token, target in zip(
            map(str, tokens), binding.GetBlendShapeTargetsRel().GetTargets(), strict=False
        ):
            if re.fullmatch(re.escape(target.name) + r"_?\d+", token):
                found[token] = str(target.name)
    return found


def read(path: Path) -> Animation:
    """Read the blend shape weights of the first SkelAnimation that has any, in a stage of any program.

    Needs the extra `usd`. Raises OutputError when there are none or two meshes disagree, MissingExtraError.
    """
    weights, names, start, fps, about = read_weights(path)
    curves: dict[str, NDArray[np.floating]] = {}
    for name, curve in zip(names, weights.T, strict=True):
        curves[name] = merge_target_curves(curves.get(name), curve, name, path)
    values = np.stack(list(curves.values()), axis=1)
    about = {"provenance": {"input": path.name}, **about, "audio": None}
    try:
        return build_take(values, list(curves), fps, start, about, path)
    except DAMAGE as error:
        raise OutputError(f"{path}: what phonanim left there is damaged: {error}; export it again") from error
