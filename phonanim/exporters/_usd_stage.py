"""The stage of `.usda` (text) and `.usdc` (binary): the head, and a UsdSkel animation."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.exporters._head import load_drawable_head
from phonanim.exporters._usd_mesh import (
    IDENTITY,
    JOINT,
    ROOT,
    extent_text,
    meshes_text,
    quoted_names,
    row_text,
    shipped_meshes,
    vectors_text,
)
from phonanim.rig.head import SHIPPED, Head
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS as NECK_TURNS
from phonanim.rig.neck import quaternions, turns_of
from phonanim.speech.alignment import pack_intervals

STAGE = """#usda 1.0
(
    defaultPrim = "head"
    doc = "Written by phonanim"
    endTimeCode = {last:.9g}
    framesPerSecond = {fps:.9g}
    metersPerUnit = 1
    startTimeCode = {first:.9g}
    timeCodesPerSecond = {fps:.9g}
    upAxis = "Y"
)

def SkelRoot "head" (
    prepend apiSchemas = ["SkelBindingAPI"]
)
{{
    float3[] extent = [{extent}]
    rel skel:animationSource = <{root}/speech>
    rel skel:skeleton = <{root}/skeleton>

    def Skeleton "skeleton" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform matrix4d[] bindTransforms = [{binds}]
        uniform token[] joints = [{joints}]
        uniform matrix4d[] restTransforms = [{binds}]
        rel skel:animationSource = <{root}/speech>
    }}

    def SkelAnimation "speech" (
        customData = {{
            string phonanim = {about}
        }}
    )
    {{
        uniform token[] blendShapes = [{names}]
        float[] blendShapeWeights.timeSamples = {{
{samples}
        }}
{turns}    }}

    def Material "material"
    {{
        token outputs:surface.connect = <{root}/material/surface.outputs:surface>

        def Shader "surface"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = <{root}/material/color.outputs:result>
            float inputs:roughness = 0.5
            token outputs:surface
        }}

        def Shader "color"
        {{
            uniform token info:id = "UsdPrimvarReader_float3"
            string inputs:varname = "displayColor"
            float3 outputs:result
        }}
    }}
{meshes}}}
"""

CURVES = """#usda 1.0
(
    defaultPrim = "speech"
    doc = "Written by phonanim"
    endTimeCode = {last:.9g}
    framesPerSecond = {fps:.9g}
    startTimeCode = {first:.9g}
    timeCodesPerSecond = {fps:.9g}
)

def SkelAnimation "speech" (
    customData = {{
        string phonanim = {about}
    }}
)
{{
    uniform token[] blendShapes = [{names}]
    float[] blendShapeWeights.timeSamples = {{
{samples}
    }}
}}
"""

TURNS = """        uniform token[] joints = ["{joint}"]
        quatf[] rotations.timeSamples = {{
{samples}
        }}
        half3[] scales = [(1, 1, 1)]
        float3[] translations = [{pivot}]
"""


HERE = "\0"  # in the place of what is written piece by piece
PIECE = 4096  # frames


def stage_text(animation: Animation, character: Path = SHIPPED) -> Iterator[str]:
    """The stage as text, piece by piece. The same input gives the same text."""
    head = load_drawable_head(character)
    weights = head.weights(animation.values, animation.channels)
    frames = animation.times * animation.fps
    binds, joints = [IDENTITY], ["root"]
    if head.neck is not None:
        x, y, z = head.neck.pivot.tolist()
        binds.append(f"((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), ({x:.7g}, {y:.7g}, {z:.7g}, 1))")
        joints.append(JOINT)
    before, after = STAGE.format(
        fps=animation.fps,
        first=frames[0],
        last=frames[-1],
        about=_about_text(animation),
        names=quoted_names(head.targets),
        samples=HERE,
        turns=_turns(animation, head, frames),
        extent=extent_text(head.vertices),
        meshes=shipped_meshes() if character == SHIPPED else meshes_text(head),
        root=ROOT,
        binds=", ".join(binds),
        joints=quoted_names(joints),
    ).split(HERE)
    yield before
    yield from _weight_samples(frames, weights)
    yield after


def curves_text(animation: Animation) -> Iterator[str]:
    """A stage of the animation alone, as text, piece by piece."""
    turned = set(map(plain_name, NECK_TURNS))
    shapes = [name for name in animation.channels if plain_name(name) not in turned]
    weights = animation.values[:, [animation.channels.index(name) for name in shapes]]
    frames = animation.times * animation.fps
    before, after = CURVES.format(
        fps=animation.fps,
        first=frames[0],
        last=frames[-1],
        about=_about_text(animation),
        names=quoted_names(shapes),
        samples=HERE,
    ).split(HERE)
    yield before
    yield from _weight_samples(frames, weights)
    yield after


def _turns(animation: Animation, head: Head, frames: NDArray[np.float64]) -> str:
    """The rotations of the head's joint, empty where it keeps still."""
    turns = turns_of(animation.values, animation.channels)
    if turns is None or head.neck is None:
        return ""
    rows = (quaternions(turns)[:, [3, 0, 1, 2]] + 0.0).tolist()  # real part first, no minus zeros
    return TURNS.format(
        joint=JOINT,
        samples=_samples(frames, [f"[({row_text(row)})]" for row in rows]),
        pivot=vectors_text(head.neck.pivot[None]),
    )


def _weight_samples(frames: NDArray[np.float64], weights: NDArray[np.floating]) -> Iterator[str]:
    """The samples of weights (frames, shapes), PIECE at a time."""
    for start in range(0, len(frames), PIECE):
        block = slice(start, start + PIECE)
        rows = [f"[{row_text(values)}]" for values in weights[block].tolist()]
        yield ("\n" if start else "") + _samples(frames[block], rows)


def _samples(frames: NDArray[np.float64], values: list[str]) -> str:
    return "\n".join(
        f"            {frame:.9g}: {value}," for frame, value in zip(frames, values, strict=True)
    )


def _about_text(animation: Animation) -> str:
    """What is kept for reading back, as a USD string."""
    return json.dumps(json.dumps(_about(animation), ensure_ascii=False), ensure_ascii=False)


def _about(animation: Animation) -> dict[str, Any]:
    return {
        "rig": animation.rig,
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "provenance": animation.provenance,
    }
