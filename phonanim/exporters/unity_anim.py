"""Unity AnimationClip: a text asset (YAML) with a curve for each blend shape of a SkinnedMeshRenderer.

The fields are those that Unity writes with Force Text serialization. Weights are percents there. Tangents are
straight on both sides of each key, as mode and as slopes.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, DecodeError, decode_rate, read_utf8
from phonanim.core.files import write_pieces
from phonanim.errors import OutputError
from phonanim.exporters._curves import merge_target_curves, rig_of_channels, sample_tangents
from phonanim.exporters._shapes import KEYS, ShapeCurve, curve_keys, head_turn, node_path, shape_curves
from phonanim.exporters._take import build_take, check_times, take_grid

SUMMARY = "Unity AnimationClip (YAML) for the blend shapes of a SkinnedMeshRenderer"
STRAIGHT = 69  # tangent mode of keys: broken, linear on both sides
RENDERER, SHAPE = 137, 20  # the class of a SkinnedMeshRenderer; the kind of binding of a blend shape
TRANSFORM, QUATERNION = 4, 2  # the class of a Transform; what a binding calls its rotation
MIRRORED = (1.0, -1.0, -1.0, 1.0)  # glTF's rotations in Unity's axes, which mirror x
NO_TURNS_ALONE = "turns no head, because no --character shows its bone"
PLAIN = re.compile(r"[A-Za-z_][\w./ -]*", re.ASCII)

PREFIX = "blendShape."
_SECTION = re.compile(r"^  m_FloatCurves:\n(.*?)^  [A-Za-z_]", re.MULTILINE | re.DOTALL)
_ATTRIBUTE = re.compile(r"^    attribute: ([^\n]*)$", re.MULTILINE)
_KEY = re.compile(r"time: (\S+)\s+value: (\S+)\s+inSlope: (\S+)\s+outSlope: (\S+)")
_RATE = re.compile(r"^  m_SampleRate: (\S+)", re.MULTILINE)
_STOP = re.compile(r"^    m_StopTime: (\S+)", re.MULTILINE)

CLIP = """%YAML 1.1
%TAG !u! tag:unity3d.com,2011:
--- !u!74 &7400000
AnimationClip:
  m_ObjectHideFlags: 0
  m_CorrespondingSourceObject: {{fileID: 0}}
  m_PrefabInstance: {{fileID: 0}}
  m_PrefabAsset: {{fileID: 0}}
  m_Name: {name}
  serializedVersion: 6
  m_Legacy: 0
  m_Compressed: 0
  m_UseHighQualityCurve: 1
  m_RotationCurves:{rotations}
  m_CompressedRotationCurves: []
  m_EulerCurves: []
  m_PositionCurves: []
  m_ScaleCurves: []
  m_FloatCurves:
{curves}  m_PPtrCurves: []
  m_SampleRate: {rate}
  m_WrapMode: 0
  m_Bounds:
    m_Center: {{x: 0, y: 0, z: 0}}
    m_Extent: {{x: 0, y: 0, z: 0}}
  m_ClipBindingConstant:
    genericBindings:
{bindings}    pptrCurveMapping: []
  m_AnimationClipSettings:
    serializedVersion: 2
    m_AdditiveReferencePoseClip: {{fileID: 0}}
    m_AdditiveReferencePoseTime: 0
    m_StartTime: 0
    m_StopTime: {stop}
    m_OrientationOffsetY: 0
    m_Level: 0
    m_CycleOffset: 0
    m_HasAdditiveReferencePose: 0
    m_LoopTime: 0
    m_LoopBlend: 0
    m_LoopBlendOrientation: 0
    m_LoopBlendPositionY: 0
    m_LoopBlendPositionXZ: 0
    m_KeepOriginalOrientation: 0
    m_KeepOriginalPositionY: 1
    m_KeepOriginalPositionXZ: 0
    m_HeightFromFeet: 0
    m_Mirror: 0
  m_EditorCurves:
{curves}{turns}  m_EulerEditorCurves: []
  m_HasGenericRootTransform: 0
  m_HasMotionFloatCurves: 0
  m_Events: []
"""
CURVE = """  - curve:
      serializedVersion: 2
      m_Curve:
{keys}      m_PreInfinity: 2
      m_PostInfinity: 2
      m_RotationOrder: 4
    attribute: {attribute}
    path: {path}
    classID: {renderer}
    script: {{fileID: 0}}
"""
KEY = """      - serializedVersion: 3
        time: %.9g
        value: %.7g
        inSlope: %.7g
        outSlope: %.7g
        tangentMode: {}
        weightedMode: 0
        inWeight: 0
        outWeight: 0
"""
ROTATION = """
  - curve:
      serializedVersion: 2
      m_Curve:
{keys}      m_PreInfinity: 2
      m_PostInfinity: 2
      m_RotationOrder: 4
    path: {path}"""
TURN_KEY = """      - serializedVersion: 3
        time: {:.9g}
        value: {}
        inSlope: {}
        outSlope: {}
        tangentMode: 0
        weightedMode: 0
        inWeight: {{x: 0, y: 0, z: 0, w: 0}}
        outWeight: {{x: 0, y: 0, z: 0, w: 0}}
"""
BINDING = """    - serializedVersion: 2
      path: {path}
      attribute: {attribute}
      script: {{fileID: 0}}
      typeID: {renderer}
      customType: {shape}
      isPPtrCurve: 0
"""


def write(
    animation: Animation,
    path: Path,
    node: str | None = None,
    character: Path | None = None,
    keys: float = KEYS,
) -> None:
    """Write a clip; `node` is the path of the renderer below the Animator, such as `Body/Face`.

    With a `character`, a GLB or VRM, the clip moves its meshes by the names of their shapes. Frames are
    left out if linear interpolation is within the error `keys`. The bone of the character's head turns, in
    the axes of importers of glTF that mirror x, as glTFast and UniVRM 1.0 do.
    Raises RigError when the character cannot be used, OutputError when the destination cannot be written.
    """
    found = shape_curves(animation, node, character)
    turn = head_turn(animation, character)
    place, keyed = (
        ("", None) if turn is None else (node_path(turn.glb, turn.node), turn.keys(animation, keys))
    )
    clip = CLIP.format(
        rotations=" []" if keyed is None else _rotation(place, *keyed),
        turns="" if keyed is None else _turn_curves(place, *keyed),
        name=_text(path.name.split(".")[0]),
        rate=f"{animation.fps:.9g}",
        stop=f"{(len(animation.values) - 1) / animation.fps + max(0.0, animation.start):.9g}",
        curves="\0",
        bindings="".join(
            [_bound(one.node, f"{PREFIX}{one.shape}", RENDERER, SHAPE) for one in found]
            + ([] if turn is None else [_bound(place, QUATERNION, TRANSFORM, 0)])
        ),
    )
    first, *rest = clip.split("\0")
    curves = [_curve(animation, one, keys) for one in found]  # stand in the clip twice
    write_pieces(path, chain([first], *(chain(curves, [part]) for part in rest)))


def read(path: Path) -> Animation:
    """Read the curves of blend shapes of a clip that is saved as text, as Unity evaluates them.

    Curves of anything else are left out. Raises OutputError when there are none, or two meshes disagree.
    """
    try:
        text = read_utf8(path)
        section, rate = _SECTION.search(text), _RATE.search(text)
        found = list(_read_curves(section[1])) if section else []
        if not found or rate is None:
            raise DecodeError(
                "it has no curves of blend shapes in m_FloatCurves; save it as text (Force Text)"
            )
        fps = decode_rate(float(rate[1]), "m_SampleRate")
        for name, keys in found:
            check_times(keys[0], name)
        stop = _STOP.search(text)
        last = max([keys[0][-1] for _, keys in found] + ([float(stop[1])] if stop else []))
        grid = take_grid(0.0, last, fps, len(found), path)
        curves: dict[str, NDArray[np.floating]] = {}
        for name, (times, values, before, after) in found:
            curve = sample_tangents(grid, times, values, before, after) / 100
            curves[name] = merge_target_curves(curves.get(name), curve, name, path)
        names = list(curves)
        about = {"provenance": {"input": path.name}}
        values = np.stack(list(curves.values()), axis=1)
        return build_take(values, names, fps, 0.0, about, path, rig_of_channels(names))
    except (OSError, *DAMAGE) as error:
        raise OutputError(f"{path}: is not a readable animation clip: {error}") from error


def _read_curves(section: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """The shape, and times, values and slopes before and after of the keys, (4, k), of each curve."""
    for part in section.split("m_Curve:")[1:]:
        found = _ATTRIBUTE.search(part)
        if found is None:
            continue
        body, attribute = part[: found.start()], found[1]
        name = json.loads(attribute) if attribute.startswith('"') else attribute.strip().strip("'")
        keys = [[float(number) for number in key] for key in _KEY.findall(body)]
        if name.startswith(PREFIX) and keys:
            yield name.removeprefix(PREFIX), np.array(keys).T


def _curve(animation: Animation, one: ShapeCurve, keys: float) -> str:
    times, values = curve_keys(animation, 100 * one.curve, 100 * keys)
    return _float_curve(one.node, f"{PREFIX}{one.shape}", RENDERER, times, values)


def _float_curve(
    node: str, attribute: str, kind: int, times: NDArray[np.float64], values: NDArray[np.float64]
) -> str:
    before, after = _slopes(times, values)
    numbers = np.stack([times, values, before, after], axis=1)
    return CURVE.format(
        keys=KEY.format(STRAIGHT) * len(times) % tuple(numbers.ravel().tolist()),
        attribute=_text(attribute),
        path=_text(node),
        renderer=kind,
    )


def _rotation(node: str, times: NDArray[np.float64], rotations: NDArray[np.float64]) -> str:
    turned = rotations * MIRRORED + 0.0
    slopes = [np.column_stack(side) for side in zip(*(_slopes(times, p) for p in turned.T), strict=True)]
    rows = zip(times.tolist(), turned.tolist(), *(side.tolist() for side in slopes), strict=True)
    return ROTATION.format(
        keys="".join(TURN_KEY.format(time, *map(_vector, parts)) for time, *parts in rows), path=_text(node)
    )


def _turn_curves(node: str, times: NDArray[np.float64], rotations: NDArray[np.float64]) -> str:
    """What the Animation window shows: a curve for each part of the rotation."""
    return "".join(
        _float_curve(node, f"m_LocalRotation.{part}", TRANSFORM, times, values)
        for part, values in zip("xyzw", (rotations * MIRRORED + 0.0).T, strict=True)
    )


def _vector(values: list[float]) -> str:
    return "{" + ", ".join(f"{part}: {value:.7g}" for part, value in zip("xyzw", values, strict=True)) + "}"


def _slopes(
    times: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Percents per second before and after each key, (k,) each; the ends are flat outside."""
    rise = np.diff(values) / np.diff(times)
    return np.concatenate([[0.0], rise]), np.concatenate([rise, [0.0]])


def _bound(node: str, attribute: str | int, kind: int, shape: int) -> str:
    return BINDING.format(
        path=zlib.crc32(node.encode()),
        attribute=attribute if isinstance(attribute, int) else zlib.crc32(attribute.encode()),
        renderer=kind,
        shape=shape,
    )


def _text(value: str) -> str:
    """A YAML text, quoted where it needs to be."""
    return value if PLAIN.fullmatch(value) and value == value.strip() else json.dumps(value)
