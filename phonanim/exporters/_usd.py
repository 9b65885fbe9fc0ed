"""What needs the USD library: binary stages, and reading."""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.files import atomic_path
from phonanim.errors import MissingExtraError, OutputError
from phonanim.exporters._curves import merge_target_curves
from phonanim.speech.alignment import unpack_intervals

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
    """Weights (frames, targets), names, start in seconds, frames per second, and what phonanim left there."""
    pxr = library()
    try:
        stage = pxr.Usd.Stage.Open(str(path))
    except pxr.Tf.ErrorException as error:
        raise OutputError(f"{path}: is no USD stage that can be read") from error
    for prim in stage.Traverse():
        animation = pxr.UsdSkel.Animation(prim)
        if animation and animation.GetBlendShapeWeightsAttr().GetNumTimeSamples():
            return _sampled(stage, animation, path)
    raise OutputError(f"{path}: has no SkelAnimation of blend shape weights; export it with its shape keys")


def _sampled(stage: Any, animation: Any, path: Path) -> Weights:
    """The weights at every whole time code between the first and the last sample."""
    known = _shape_names(stage)
    names = tuple(known.get(str(name), str(name)) for name in animation.GetBlendShapesAttr().Get() or ())
    attribute = animation.GetBlendShapeWeightsAttr()
    times = attribute.GetTimeSamples()
    codes = np.arange(round(times[-1] - times[0]) + 1) + times[0]
    values = np.array([attribute.Get(code) for code in codes], float)
    if values.shape != (len(codes), len(names)):
        raise OutputError(
            f"{path}: {len(names)} blend shapes have {values.shape[-1]} weights; export it again"
        )
    rate = float(stage.GetTimeCodesPerSecond())
    note = animation.GetPrim().GetCustomDataByKey("phonanim")
    return values, names, float(codes[0]) / rate, rate, json.loads(note) if note else {}


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
    """Read the blend shape weights of the first SkelAnimation that has any, in a stage of any writer.

    Needs the extra `usd`. Raises OutputError when there is none or two meshes disagree, MissingExtraError.
    """
    weights, names, start, fps, about = read_weights(path)
    curves: dict[str, NDArray[np.float64]] = {}
    for name, curve in zip(names, weights.T, strict=True):
        curves[name] = merge_target_curves(curves.get(name), curve, name, path)
    return Animation(
        values=np.stack(list(curves.values()), axis=1).astype(np.float32),
        channels=tuple(curves),
        fps=fps,
        rig=str(about.get("rig", "arkit")),
        start=start,
        phones=unpack_intervals(about.get("phones", [])),
        words=unpack_intervals(about.get("words", [])),
        provenance=dict(about.get("provenance", {"input": path.name})),
    )
