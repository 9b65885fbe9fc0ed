"""Triangle-mesh queries by trimesh: normals, adjacency, coincident vertices.

Needs trimesh and scipy (extra `rig`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

SAME = 1e-6  # of a head's size: vertices nearer than this are one vertex, split for textures


def import_trimesh() -> Any:
    """Import trimesh where it is needed. Raises MissingExtraError naming the extra."""
    try:
        import trimesh
    except ImportError as error:
        raise MissingExtraError("working on meshes needs trimesh: pip install 'phonanim[rig]'") from error
    return trimesh


def face_normals(points: Array, triangles: Rows) -> Array:
    """Unit normals of triangles, (triangles, 3); zero for a triangle without area."""
    trimesh = import_trimesh()
    return np.asarray(trimesh.unitize(trimesh.triangles.cross(points[triangles])))


def vertex_normals(points: Array, triangles: Rows) -> Array:
    """Unit normals at the vertices, weighted by area, (vertices, 3)."""
    trimesh = import_trimesh()
    areas = trimesh.triangles.cross(points[triangles])
    return np.asarray(trimesh.geometry.mean_vertex_normals(len(points), triangles, areas))


def weld(points: Array, triangles: Rows) -> tuple[Rows, Rows]:
    """Rows of the distinct vertices of the triangles, and each vertex's index among them, -1 if unused."""
    used = np.unique(triangles)
    grain = SAME * float(np.ptp(points, axis=0).max())
    first, inverse = import_trimesh().grouping.unique_rows(points[used] / grain, digits=0, keep_order=True)
    place = np.full(len(points), -1)
    place[used] = inverse
    return used[first], place


def connected_labels(triangles: Rows, count: int) -> Rows:
    """A component number for each of `count` vertices, the same for vertices that triangles connect."""
    trimesh = import_trimesh()
    edges = trimesh.geometry.faces_to_edges(triangles)
    return np.asarray(trimesh.graph.connected_component_labels(edges, count))


def uniform_laplacian(edges: Rows, count: int) -> Any:
    """Difference of each vertex's value from the mean of its neighbours, sparse (count, count).

    `edges` (n, 2) may name an edge more than once and in either direction.
    """
    from scipy import sparse

    one_way = import_trimesh().graph.edges_to_coo(edges, count).tocsr()
    near = (one_way + one_way.T).astype(np.float64)
    near.data[:] = 1.0
    degree = np.maximum(np.asarray(near.sum(axis=1)).ravel(), 1)
    return sparse.identity(count, format="csr") - sparse.diags(1 / degree) @ near
