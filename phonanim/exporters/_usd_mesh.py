"""The meshes of a USD stage: points, blend shapes, and the share of the head's turn of each point."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from functools import cache
from itertools import chain, count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.head import Head, load_dressed_head
from phonanim.rig.render import vertex_normals

MOVED = 1e-6  # metres; smaller offsets are not stored
ROOT = "/head"
JOINT = "root/head"
IDENTITY = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))"

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
        int[] primvars:skel:jointIndices = [{joints}] (
            elementSize = {size}
            interpolation = "{spread}"
        )
        float[] primvars:skel:jointWeights = [{shares}] (
            elementSize = {size}
            interpolation = "{spread}"
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


@cache
def shipped_meshes() -> str:
    """The meshes of the package's head, which are the same in every file."""
    return meshes_text(load_dressed_head())


def meshes_text(head: Head) -> str:
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
        extent=extent_text(head.vertices[rows]),
        counts=", ".join(["3"] * len(triangles)),
        corners=", ".join(map(str, triangles.ravel().tolist())),
        normals=vectors_text(normals[rows]),
        points=vectors_text(head.vertices[rows]),
        colors=vectors_text(head.colors[rows]),
        names=quoted_names(names),
        targets=", ".join(f"<{ROOT}/{name}/{shapes[target]}>" for target in names),
        shapes="".join(_shape(shapes[head.targets[t]], head.deltas[t, rows], turns[t, rows]) for t in moved),
        root=ROOT,
        identity=IDENTITY,
        **_bound(head, rows),
    )


def _bound(head: Head, rows: slice) -> dict[str, Any]:
    """How the joints move the points of a part: by the root alone, or in shares by root and head."""
    if head.neck is None:
        return {"joints": "0", "shares": "1", "size": 1, "spread": "constant"}
    share = head.neck.share[rows]
    constant = bool(np.ptp(share) == 0)
    pairs = [[1 - one, one] for one in (share[:1] if constant else share).tolist()]
    return {
        "joints": ", ".join(["0, 1"] * len(pairs)),
        "shares": ", ".join(map(row_text, pairs)),
        "size": 2,
        "spread": "constant" if constant else "vertex",
    }


def _shape(name: str, moves: NDArray[np.float64], turns: NDArray[np.float32]) -> str:
    rows = np.flatnonzero(np.abs(moves).max(axis=1) > MOVED)
    return SHAPE.format(
        name=name,
        turns=vectors_text(turns[rows]),
        moves=vectors_text(moves[rows]),
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


def quoted_names(names: Iterable[str]) -> str:
    return ", ".join(json.dumps(name, ensure_ascii=False) for name in names)


def extent_text(points: NDArray[np.float64]) -> str:
    return vectors_text(np.array([points.min(axis=0), points.max(axis=0)]))


def vectors_text(values: NDArray[Any]) -> str:
    plain = (np.asarray(values, float) + 0.0).tolist()  # no minus zeros
    return ", ".join([f"({x:.7g}, {y:.7g}, {z:.7g})" for x, y, z in plain])


def row_text(values: list[float]) -> str:
    return ", ".join([f"{value:.9g}" for value in values])
