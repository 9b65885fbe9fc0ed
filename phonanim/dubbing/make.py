"""Make one line: the task of a worker."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import cast

from phonanim.animation.provenance import model_hash
from phonanim.core.files import content_hash, make_folder_within
from phonanim.core.plugins import describe_failure
from phonanim.correcting import animate_corrected
from phonanim.dubbing.align_lines import Prepared, prepare_line
from phonanim.dubbing.checks import line_facts
from phonanim.dubbing.format_rigs import rig_of_format, rigs_of_formats
from phonanim.dubbing.job import Job, Result
from phonanim.dubbing.line import Line
from phonanim.dubbing.motion import line_motion
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.provenance import (
    find_extensions,
    is_current,
    options_entry,
    origin_of,
    rig_hash,
    shared_file_entry,
)
from phonanim.dubbing.staging import Copies, forget_copies, open_copies, stage_inputs, upload_outputs
from phonanim.dubbing.stamps import OUTPUTS, stamp_inputs, stamp_outputs
from phonanim.dubbing.storage import forget_listings
from phonanim.errors import OptionError, PhonanimError
from phonanim.exporters import assign_options, save
from phonanim.pipeline import (
    AnimationResult,
    load_cached_model,
    load_cached_rig,
)
from phonanim.rig.names import known_names
from phonanim.speech.pronunciations import load_pronunciations


def make_line(job: Job) -> Result:
    """Animate a line and write its outputs, unless current ones exist already."""
    reset_caches(job.run)
    line = job.line
    with open_copies(job) as near:
        try:
            with known_names(line.names):
                return _made(job, near)
        except PhonanimError as error:
            why = near.restore_urls(str(error))
        except MemoryError:
            why = f"{line.source}: there is not enough memory for it; use fewer --workers, or cut the line"
        except OSError as error:
            why = near.restore_urls(f"{error.filename or line.source}: {error.strerror or error}")
        except Exception as error:  # a bug costs one line, not the whole run
            own = f"an error in phonanim, please report it: {type(error).__name__}: {error}"
            why = f"{line.source}: {describe_failure(error) or own}"
    return Result(Outcome(line.id, line.place, error=why), made=True)


@lru_cache(maxsize=1)
def reset_caches(run: str) -> None:
    """Clear the caches of an earlier run in this process: the files may have changed."""
    for remembered in (
        load_cached_model,
        load_cached_rig,
        load_pronunciations,
        model_hash,
        rig_hash,
        shared_file_entry,
        options_entry,
        find_extensions,
        rig_of_format,
    ):
        remembered.cache_clear()
    forget_listings()
    forget_copies()


def _made(job: Job, near: Copies) -> Result:
    """The result of a line, whose files are downloaded and whose outputs are uploaded if necessary."""
    stamps = stamp_inputs(job.line)  # before the files are read
    here = stage_inputs(job, near)
    origin = origin_of(here.line, job.formats)
    if job.known and is_current(job.known, origin, job.folder):
        stamped = {**stamps, OUTPUTS: stamp_outputs(job.known.outputs, job.folder)}
        return Result(replace(job.known, place=job.line.place, stamps=stamped), made=False)
    folder = cast("Path", here.folder)
    performance, outputs, audio = _written(here.line, folder, job.formats)
    upload_outputs(list(outputs), folder, job.folder)
    facts, motion = line_facts(performance, audio), line_motion(performance, audio)
    stamped = {**stamps, OUTPUTS: stamp_outputs(outputs, job.folder)}
    return Result(
        Outcome(job.line.id, job.line.place, origin, outputs, facts, stamps=stamped, motion=motion), made=True
    )


Written = tuple[AnimationResult, dict[str, str], Path | None]


def _written(line: Line, folder: Path, formats: tuple[str, ...]) -> Written:
    """The animation of a line, the content hashes of the outputs that were written, and its recording."""
    given = prepare_line(line, folder)
    rigs = rigs_of_formats(line, formats)
    paths = [folder / f"{line.output}.{suffix}" for suffix in formats]
    exports, idle = assign_options(line.exports, paths)
    if idle:
        names = ", ".join(path.relative_to(folder).as_posix() for path in paths)
        raise OptionError(f"{line.source}: {idle[0]} has no effect on {names}; leave it out")
    found = {
        rig: _performed(line, replace(given, options=replace(given.options, rig=rig)))
        for rig in dict.fromkeys([line.options.rig, *rigs.values()])
        if rig in rigs.values()
    }
    for path, chosen, rig in zip(paths, exports, rigs.values(), strict=True):
        make_folder_within(path.parent, folder)
        save(found[rig].animation, path, **chosen)
    hashes = {path.relative_to(folder).as_posix(): content_hash(path) for path in (*given.made, *paths)}
    return next(iter(found.values())), hashes, given.audio


def _performed(line: Line, given: Prepared) -> AnimationResult:
    """The animation of a line on one rig, with its edits and corrections."""
    files = cast("list[Path]", [file for file in (line.edits, line.corrections) if file is not None])
    performance = animate_corrected(given.alignment, given.options, given.audio, files)
    return replace(performance, notes=tuple(dict.fromkeys((*given.notes, *performance.notes))))
