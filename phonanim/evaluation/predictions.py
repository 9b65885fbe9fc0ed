"""Motion of any tool for scoring: curves of controls, or the vertices of a mesh over time.

Curves come from every format that `phonanim convert` reads (its own formats, Live Link CSV, GLB, USD,
OpenFaceFX tracks); vertices come from the .npy layouts of VOCA, FaceFormer, CodeTalker and FaceDiffuser.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import read_array
from phonanim.errors import EvaluationError
from phonanim.exporters import load, readable_suffixes, suffixes

Array = NDArray[np.float64]
# Meshes whose frames are stored flat, by their number of vertices.
FLAT_MESHES = {
    5023: "FLAME: VOCASET, FaceFormer, CodeTalker",
    23370: "BIWI: FaceFormer, CodeTalker, FaceDiffuser",
    6172: "Multiface: FaceDiffuser",
}
MOST_CONTROLS = 1000  # flat frames with more values, and of no known mesh, are not a rig's controls
REPORT = "report.json"  # of `phonanim batch`
MESHES = (".npy", ".obj", ".ply", ".off")
PICKLES = (".pkl", ".pickle")
NPY_FPS = 30.0  # default for .npy, which has no rate: VOCASET at FaceFormer's rate, and FaceDiffuser's rigs


@dataclass(frozen=True)
class Vertices:
    """A mesh over time: `points` (frames, vertices, 3) at `start` + n / `fps` seconds, in the file's unit."""

    points: Array
    fps: float
    start: float = 0.0

    @property
    def times(self) -> Array:
        """(frames,) seconds."""
        return self.start + np.arange(len(self.points)) / self.fps


Motion = Animation | Vertices


def read_motion(path: Path, fps: float | None = None, template: Array | None = None) -> Motion:
    """Read a file of motion. `fps` is the rate of a .npy, `template` (vertices, 3) is its mesh at rest.

    Raises EvaluationError when the layout is unknown or a value is not finite, and OutputError or RigError as
    the reader of the format does.
    """
    if path.suffix.lower() == ".npy":
        return motion_from_array(_load(path), str(path), fps or NPY_FPS, template)
    return load(path)


def motion_from_array(array: NDArray[Any], source: str, fps: float, template: Array | None = None) -> Motion:
    """Motion from an array, by its shape.

    (frames, vertices, 3) is a mesh. (frames, 3 vertices) is a mesh if `template` or FLAT_MESHES has as many
    vertices. (frames, controls) are curves without names: "0", "1", ... A leading axis of size one is
    dropped. Raises EvaluationError.
    """
    if array.ndim > 2 and array.shape[0] == 1:
        array = array[0]
    real = np.issubdtype(array.dtype, np.floating) or np.issubdtype(array.dtype, np.integer)
    if not real or array.size == 0 or array.ndim == 0:
        raise EvaluationError(
            f"{source}: has {array.dtype} of shape {array.shape}, not the numbers of frames"
        )
    check_finite(array.reshape(len(array), -1), source)
    if array.ndim == 3 and array.shape[2] == 3:
        return Vertices(array.astype(np.float64), fps)
    if array.ndim != 2:
        raise EvaluationError(_unknown(source, array.shape))
    known = [*FLAT_MESHES, *([len(template)] if template is not None else [])]
    if array.shape[1] in [3 * count for count in known]:
        return Vertices(array.reshape(len(array), -1, 3).astype(np.float64), fps)
    if array.shape[1] > MOST_CONTROLS:
        raise EvaluationError(_unknown(source, array.shape))
    names = tuple(map(str, range(array.shape[1])))
    return Animation(array.astype(np.float32), names, fps, rig="")


def read_template(path: Path) -> Array:
    """Vertices of a mesh at rest, (vertices, 3), in the order of the .npy, .obj, .ply or .off (extra `rig`).

    Raises EvaluationError, RigError, MissingExtraError.
    """
    suffix = path.suffix.lower()
    if suffix == ".npy":
        points = _load(path)
    elif suffix in MESHES:
        from phonanim.rig.mesh_file import read_mesh

        points = read_mesh(path)[0]
    else:
        raise EvaluationError(f"{path}: a template is a .ply, an .obj, an .off or a .npy of vertices")
    return _mesh_at_rest(points, str(path))


def read_templates(path: Path) -> dict[str, Array]:
    """Meshes at rest by subject: the files of a folder, or a pickle of arrays by subject (VOCASET, BIWI).

    One mesh is of every subject, and its name is "". Raises EvaluationError, CorpusError, RigError,
    MissingExtraError.
    """
    if path.suffix.lower() in PICKLES:
        from phonanim.datasets._pickles import read_pickle

        tree = read_pickle(path)
        if not isinstance(tree, dict) or not tree:
            raise EvaluationError(f"{path}: is not a set of templates; give a .pkl of arrays by subject")
        return {
            str(name): _mesh_at_rest(np.asarray(points), f"{path}, {name}") for name, points in tree.items()
        }
    if not path.is_dir():
        return {"": read_template(path)}
    found = {one.stem: read_template(one) for one in sorted(path.iterdir()) if one.suffix.lower() in MESHES}
    if not found:
        raise EvaluationError(f"{path}: has no {', '.join(MESHES)}; name each after its subject")
    return found


def template_of(templates: dict[str, Array], line: Path) -> Array:
    """The template of a line's subject: the longest name that the file's name begins with.

    Raises EvaluationError when no subject fits.
    """
    name = line_name(line)
    fits = [
        one
        for one in templates
        if not one or name == one or name.startswith((f"{one}_", f"{one}-", f"{one}."))
    ]
    if not fits:
        raise EvaluationError(
            f"{line}: has no subject with a template ({', '.join(sorted(templates)[:4])}, ...); "
            "name templates after subjects and files SUBJECT_LINE"
        )
    return templates[max(fits, key=len)]


def resample_motion(motion: Motion, times: Array) -> Motion:
    """The same motion at other, evenly spaced instants within it, interpolated linearly."""
    fps = 1 / float(np.diff(times).mean())
    if isinstance(motion, Vertices):
        flat = interpolate_rows(motion.points.reshape(len(motion.points), -1), motion, times)
        return Vertices(flat.reshape(len(times), -1, 3), fps, float(times[0]))
    values = interpolate_rows(motion.values.astype(np.float64), motion, times).astype(np.float32)
    mouth = motion.articulation
    if mouth is not None:
        mouth = interpolate_rows(mouth.astype(np.float64), motion, times).astype(np.float32)
    return replace(motion, values=values, articulation=mouth, fps=fps, start=float(times[0]))


def interpolate_rows(values: Array, motion: Motion, times: Array) -> Array:
    """Rows (frames, n) of a motion at instants, (times,) -> (times, n)."""
    places = np.clip((times - motion.start) * motion.fps, 0, len(values) - 1)
    first = np.minimum(places.astype(np.int64), max(len(values) - 2, 0))
    share = (places - first)[:, None]
    return np.asarray((1 - share) * values[first] + share * values[np.minimum(first + 1, len(values) - 1)])


def pair_files(predictions: Path, reference: Path) -> list[tuple[Path, Path]]:
    """Pairs of prediction and reference, sorted by name: two files, or the files of two folders by stem.

    The stem of a prediction may end in `_condition_...`, as FaceFormer, CodeTalker and FaceDiffuser name the
    styles of a line, so a reference can have several. Raises EvaluationError when there are no pairs.
    """
    if predictions.is_dir() != reference.is_dir():
        raise EvaluationError(f"{predictions} and {reference}: give two files or two folders")
    if not predictions.is_dir():
        return [(predictions, reference)]
    references = {line_name(path): path for path in motions_of(reference)}
    found = [
        (path, references[line])
        for path in motions_of(predictions)
        if (line := line_name(path)) in references
    ]
    if not found:
        raise EvaluationError(f"{predictions}: no file has the stem of a file in {reference}; rename them")
    return found


def line_name(path: Path) -> str:
    """The name of a line: without the suffix of its format and without `_condition_...`."""
    name = path.name
    suffix = max((s for s in suffixes() if name.lower().endswith(s)), key=len, default=path.suffix)
    return name.removesuffix(name[len(name) - len(suffix) :]).split("_condition_")[0]


def motions_of(folder: Path) -> list[Path]:
    """Files that may be motion in a folder: no pages, no videos, no reports of `batch`."""
    known = (".npy", *readable_suffixes())
    return sorted(
        path
        for path in folder.iterdir()
        if path.name.lower().endswith(known) and not path.name.startswith(".") and path.name != REPORT
    )


def check_finite(values: NDArray[Any], source: str) -> None:
    """Raise EvaluationError, which names the first value, (rows, columns), that is not a number."""
    wrong = np.argwhere(~np.isfinite(values))
    if len(wrong):
        row, column = wrong[0]
        raise EvaluationError(
            f"{source}: {values[row, column]} in frame {row}, value {column} ({len(wrong)} such); correct it"
        )


def _mesh_at_rest(points: NDArray[Any], source: str) -> Array:
    if points.ndim != 2 or points.shape[1] != 3 or not np.issubdtype(points.dtype, np.number):
        raise EvaluationError(f"{source}: a template has shape (vertices, 3), this one {points.shape}")
    check_finite(points, source)
    return points.astype(np.float64)


def _unknown(source: str, shape: tuple[int, ...]) -> str:
    meshes = ", ".join(f"(frames, {3 * count}) of {what}" for count, what in FLAT_MESHES.items())
    return (
        f"{source}: shape {shape} is not a known layout; known are (frames, vertices, 3), {meshes}; "
        "for another mesh give its --template"
    )


def _load(path: Path) -> NDArray[Any]:
    try:
        return read_array(path)
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read: {error}") from error
