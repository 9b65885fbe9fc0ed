"""The stage of `.usda` (text) and `.usdc` (binary): the head, and a UsdSkel animation."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from functools import cache
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.exporters._head import load_drawable_head
from phonanim.rig.head import SHIPPED, Head, load_head
from phonanim.rig.render import vertex_normals
from phonanim.speech.alignment import pack_intervals

MOVED = 1e-6  # metres; smaller offsets are not stored
ROOT = "/head"
IDENTITY = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))"
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
        uniform matrix4d[] bindTransforms = [{identity}]
        uniform token[] joints = ["root"]
        uniform matrix4d[] restTransforms = [{identity}]
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
    }}

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

MESH = """
    def Mesh "{name}" (
        prepend apiSchemas = ["MaterialBindingAPI", "SkelBindingAPI"]
    )
    {{
        uniform bool doubleSided = 1
        float3[] extent = [{extent}]
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{corners}]
        rel material:binding = <{root}/material>
        normal3f[] normals = [{normals}] (
            interpolation = "vertex"
        )
        point3f[] points = [{points}]
        color3f[] primvars:displayColor = [{colors}] (
            interpolation = "vertex"
        )
        matrix4d primvars:skel:geomBindTransform = {identity}
        int[] primvars:skel:jointIndices = [0] (
            elementSize = 1
            interpolation = "constant"
        )
        float[] primvars:skel:jointWeights = [1] (
            elementSize = 1
            interpolation = "constant"
        )
        uniform token[] skel:blendShapes = [{names}]
        rel skel:blendShapeTargets = [{targets}]
        rel skel:skeleton = <{root}/skeleton>
        uniform token subdivisionScheme = "none"
{shapes}    }}
"""

SHAPE = """
        def BlendShape "{name}"
        {{
            uniform vector3f[] normalOffsets = [{turns}]
            uniform vector3f[] offsets = [{moves}]
            uniform int[] pointIndices = [{rows}]
        }}
"""


def stage_text(animation: Animation, character: Path = SHIPPED) -> str:
    """The stage as text. The same input gives the same text."""
    head = load_drawable_head(character)
    weights = head.weights(animation.values, animation.channels)
    frames = animation.times * animation.fps
    samples = [
        f"            {frame:.9g}: [{_row(values)}],"
        for frame, values in zip(frames, weights.tolist(), strict=True)
    ]
    return STAGE.format(
        fps=animation.fps,
        first=frames[0],
        last=frames[-1],
        about=json.dumps(json.dumps(_about(animation), ensure_ascii=False), ensure_ascii=False),
        names=_names(head.targets),
        samples="\n".join(samples),
        extent=_extent(head.vertices),
        meshes=_shipped_meshes() if character == SHIPPED else _meshes(head),
        root=ROOT,
        identity=IDENTITY,
    )


def _about(animation: Animation) -> dict[str, Any]:
    return {
        "rig": animation.rig,
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "provenance": animation.provenance,
    }


@cache
def _shipped_meshes() -> str:
    """The meshes of the package's head, which are the same in every file."""
    return _meshes(load_head())


def _meshes(head: Head) -> str:
    """All meshes of a head, part by part."""
    normals = vertex_normals(head.vertices.astype(np.float32), head.triangles)
    turned = [
        vertex_normals((head.vertices + d).astype(np.float32), head.triangles) - normals for d in head.deltas
    ]
    prims = _identifiers(head.parts)
    return "".join(_mesh(head, part, prims[part], normals, np.array(turned)) for part in head.parts)


def _mesh(head: Head, part: str, name: str, normals: NDArray[np.float32], turns: NDArray[np.float32]) -> str:
    rows = head.parts[part]
    shapes = _identifiers(head.targets)
    inside = ((head.triangles >= rows.start) & (head.triangles < rows.stop)).all(axis=1)
    triangles = head.triangles[inside] - rows.start
    moved = [t for t in range(len(head.targets)) if np.abs(head.deltas[t, rows]).max() > MOVED]
    names = [head.targets[t] for t in moved]
    return MESH.format(
        name=name,
        extent=_extent(head.vertices[rows]),
        counts=", ".join(["3"] * len(triangles)),
        corners=", ".join(map(str, triangles.ravel().tolist())),
        normals=_vectors(normals[rows]),
        points=_vectors(head.vertices[rows]),
        colors=_vectors(head.colors[rows]),
        names=_names(names),
        targets=", ".join(f"<{ROOT}/{name}/{shapes[target]}>" for target in names),
        shapes="".join(_shape(shapes[head.targets[t]], head.deltas[t, rows], turns[t, rows]) for t in moved),
        root=ROOT,
        identity=IDENTITY,
    )


def _shape(name: str, moves: NDArray[np.float64], turns: NDArray[np.float32]) -> str:
    rows = np.flatnonzero(np.abs(moves).max(axis=1) > MOVED)
    return SHAPE.format(
        name=name,
        turns=_vectors(turns[rows]),
        moves=_vectors(moves[rows]),
        rows=", ".join(map(str, rows.tolist())),
    )


def _identifier(name: str) -> str:
    """A prim name: letters, digits and underscores."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"


def _identifiers(names: Iterable[str]) -> dict[str, str]:
    """A prim name for each name, all of them different."""
    found: dict[str, str] = {}
    for name in names:
        plain = _identifier(name)
        spellings = chain([plain], (f"{plain}_{number}" for number in count(2)))
        found[name] = next(spelling for spelling in spellings if spelling not in found.values())
    return found


def _names(names: Iterable[str]) -> str:
    return ", ".join(json.dumps(name, ensure_ascii=False) for name in names)


def _extent(points: NDArray[np.float64]) -> str:
    return _vectors(np.array([points.min(axis=0), points.max(axis=0)]))


def _vectors(values: NDArray[Any]) -> str:
    plain = (np.asarray(values, float) + 0.0).tolist()  # no minus zeros
    return ", ".join([f"({x:.7g}, {y:.7g}, {z:.7g})" for x, y, z in plain])


def _row(values: list[float]) -> str:
    return ", ".join([f"{value:.9g}" for value in values])
