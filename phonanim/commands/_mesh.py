"""`phonanim animate` with a model of vertices: a mesh that moves, in place of curves of a rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console
from phonanim.commands._outputs import check_outputs
from phonanim.commands._takes import list_takes

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from phonanim.animation.mesh_motion import MeshMotion
    from phonanim.options import Options


def moves_mesh(options: Options, template: Path | None) -> bool:
    """Whether the model of the options moves vertices. Raises UsageError for a template of another model."""
    from phonanim.pipeline import load_model

    found = load_model(options.model).target.kind == "vertices"
    if template and not found:
        raise click.UsageError("--template is the face of a model of vertices, which this model is not")
    return found


def check_mesh_options(
    edits: Sequence[Path], sheet: Path | None, view: bool, exports: Mapping[str, object]
) -> None:
    """Raise UsageError for an option of curves, which a moving mesh is not."""
    given = {"--edits": bool(edits), "--contact-sheet": sheet, "--view": view}
    named = [name for name, value in given.items() if value] + [f"--{name}" for name in exports]
    if named:
        raise click.UsageError(f"{', '.join(named)}: the model moves vertices, not curves; leave it out")


def write_mesh(
    path: Path,
    outputs: Sequence[Path],
    options: Options,
    takes: int,
    audio: Path | None,
    template: Path | None,
    console: Console,
) -> None:
    """Predict the mesh of a line, on a subject's face or on that of `template`, and write its takes.

    Raises OptionError for several takes of a model that does not sample.
    """
    planned = list(list_takes(takes, options, outputs or (path.with_suffix(".glb"),), None))
    named = [output for _, files, _ in planned for output in files]
    check_outputs(named, [one for one in (path, audio, template) if one])
    made = [
        write_mesh_take(path, files, settings, audio, template, console) for settings, files, _ in planned
    ]
    console.print_result({"takes": made} if takes > 1 else made[0])


def write_mesh_take(
    path: Path,
    outputs: Sequence[Path],
    options: Options,
    audio: Path | None,
    template: Path | None,
    console: Console,
) -> dict[str, Any]:
    """Write a take of a mesh; -> the result as data."""
    motion, notes = predict_mesh(path, outputs, options, audio, template)
    for output in outputs:
        notes += motion.save(output)
        console.print(f"wrote {output}: {len(motion.points)} frames of {len(motion.rest)} vertices")
    for note in notes:
        console.print(note)
    return {
        "alignment": str(path),
        "model": options.model,
        "frames": len(motion.points),
        "fps": motion.fps,
        "vertices": len(motion.rest),
        "notes": list(notes),
        "outputs": [str(output) for output in outputs],
    }


def predict_mesh(
    path: Path, outputs: Sequence[Path], options: Options, audio: Path | None, template: Path | None
) -> tuple[MeshMotion, tuple[str, ...]]:
    """The motion of a line, and notes.

    Raises ModelError for another mesh, and OutputError where an output cannot be written, before all else.
    """
    from phonanim.animation.mesh_motion import MeshMotion, check_mesh_output
    from phonanim.animation.own_motion import unused_own_options
    from phonanim.animation.rates import frame_count
    from phonanim.inputs.speech_input import read_speech_input
    from phonanim.media.audio import find_audio
    from phonanim.pipeline import model_with_settings
    from phonanim.targets.vertices import Vertices as VerticesTarget

    model = model_with_settings(options)
    target = model.target
    assert isinstance(target, VerticesTarget)
    rest, triangles = target.rest_in_style(model.style_name(options.model_style)), target.triangles
    if template:
        rest, own = read_face(template, len(rest))
        triangles = triangles if own is None else own
    for output in outputs:
        check_mesh_output(output, triangles)
    line = read_speech_input(path, options, audio or find_audio(path), model.regressor.input_modality)
    frames = frame_count(line.track.duration, options.fps)
    rows = model.predict(line.track, options.fps, frames, sound=line.sound)
    motion = MeshMotion(target.decode(rows, rest), options.fps, rest, triangles, target.unit)
    return motion, (*line.notes, *unused_own_options(options))


def read_face(path: Path, vertices: int) -> tuple[NDArray[np.float64], NDArray[np.int64] | None]:
    """A face at rest (vertices, 3), with the triangles (n, 3) of a mesh, None of an .npy.

    Raises ModelError for another shape, RigError for a damaged mesh.
    """
    import numpy as np

    from phonanim.core.decode import DAMAGE, read_array
    from phonanim.errors import ModelError
    from phonanim.rig.mesh_file import MESHES, read_mesh

    triangles = None
    try:
        if path.suffix.lower() in MESHES:
            rest, triangles, _ = read_mesh(path)
        else:
            rest = read_array(path).astype(np.float64)
    except (OSError, *DAMAGE) as error:
        raise ModelError(f"{path}: is not an .npy of a face at rest ({error})") from error
    if rest.shape != (vertices, 3) or not np.isfinite(rest).all():
        raise ModelError(f"{path}: is {rest.shape} of numbers, and the model has {vertices} vertices")
    return rest, triangles
