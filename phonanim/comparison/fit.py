"""Train the models of a comparison in parallel, each once; cached models are not trained again."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import re
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from phonanim import regressors
from phonanim.comparison.plan import Plan
from phonanim.core.decode import DAMAGE, decode_number, decode_table, decode_text, read_json
from phonanim.core.files import content_hash, write_text
from phonanim.core.plugins import describe_failure
from phonanim.core.threads import use_one_thread
from phonanim.core.version import __version__
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.motion import (
    INDEX,
    TEMPLATES,
    MotionCorpus,
    has_own_motion,
    load_motion_corpus,
)
from phonanim.errors import ModelError, PhonanimError
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel

JOB = "job.json"
MAX_JOB = 1 << 20  # bytes
LONGEST = 1e9  # seconds of a training
READ = 1 << 24  # bytes of a file at a time
CLIPS = "clips"  # the sweep setting that is the share of the training clips


@dataclass(frozen=True)
class Job:
    """A recipe to train on some clips of a corpus, with changed settings, into a folder.

    `face_clips` are the clips of the model's reference face; several jobs share one face, so that their
    parameters can be compared; there are none for a corpus of other motion than landmarks. `mouth`: train on
    the joint modes of shape and appearance. `seed` replaces that of the recipe.
    """

    recipe: Path
    corpus: Path
    clips: tuple[int, ...]
    face_clips: tuple[int, ...]
    folder: Path
    settings: dict[str, Any] = field(default_factory=dict)
    mouth: bool = False
    seed: int | None = None

    @property
    def key(self) -> str:
        """A hash of everything that the model depends on."""
        facts = {
            "recipe": self.recipe.read_text(encoding="utf-8"),
            "settings": self.settings,
            "clips": self.clips,
            "corpus": _corpus_hash(self.corpus),
            "version": __version__,
            **({"seed": self.seed} if self.seed is not None else {}),
            **({"face": self.face_clips} if self._own_face else {}),
            **({"appearance": content_hash(self.corpus / "appearance")} if self.mouth else {}),
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()

    @property
    def _own_face(self) -> bool:
        """Whether the face is another one than that of all training clips."""
        return bool(self.face_clips) and self.face_clips != _training_clips(self.corpus)


@dataclass(frozen=True)
class Trained:
    """A model with the processor seconds of its training, if it was trained here."""

    model: regressors.Model
    seconds: float | None


@lru_cache(maxsize=2)
def load_cached_corpus(folder: Path) -> Corpus:
    """A corpus, read once per process."""
    return load_corpus(folder)


@lru_cache(maxsize=2)
def load_cached_motion(folder: Path) -> MotionCorpus:
    """A corpus of controls, sensors or vertices, read once per process."""
    return load_motion_corpus(folder)


@lru_cache(maxsize=8)
def reference_face(folder: Path, clips: tuple[int, ...]) -> FaceModel:
    """The reference face of some clips of a corpus; these must not be test clips."""
    corpus = load_cached_corpus(folder)
    return fit_face(corpus.landmarks[corpus.rows(clips)], corpus.indices)


def _training_clips(folder: Path) -> tuple[int, ...]:
    return tuple(load_cached_corpus(folder).clips_of("train").tolist())


@lru_cache(maxsize=8)
def _corpus_hash(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in _files(folder):
        with path.open("rb") as file:
            while part := file.read(READ):
                digest.update(part)
    return digest.hexdigest()


def _files(folder: Path) -> list[Path]:
    """The files of a corpus that a training reads."""
    if not has_own_motion(folder):
        return [folder / INDEX, folder / "landmarks.safetensors"]
    clips = load_cached_motion(folder).clips
    own = [path for path in (folder / INDEX, folder / TEMPLATES) if path.is_file()]
    return [*own, *(clip.motion for clip in clips), *(clip.audio for clip in clips if clip.audio)]


def fit_all(jobs: Sequence[Job], workers: int, progress: Callable[[float], None]) -> None:
    """Train every job whose model is not cached, in `workers` processes of one thread each.

    Each folder is written atomically, so an interrupted comparison continues where it stopped.
    """
    waiting = [job for job in jobs if not is_cached(job)]
    if not waiting:
        return
    use_one_thread()  # in the workers, which inherit it
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn) as pool:
        for done, future in enumerate(
            as_completed([pool.submit(train_in_worker, job) for job in waiting]), 1
        ):
            future.result()
            progress(done / len(waiting))


def is_cached(job: Job) -> bool:
    """Whether the folder of a job has the model that it would train."""
    return job.folder.joinpath(JOB).is_file() and read_job(job.folder)["key"] == job.key


def train_in_worker(job: Job) -> None:
    """`train_job`; an error in the code of a plugin is named, because its trace ends with the process."""
    try:
        train_job(job)
    except PhonanimError:
        raise
    except Exception as error:
        failure = describe_failure(error)
        if failure is None:
            raise
        raise ModelError(f"{job.recipe}: {failure}") from error


def train_job(job: Job) -> None:
    """Train one job and write its model folder, job.json last."""
    from phonanim.comparison.motion_folds import training_part
    from phonanim.corpus.pictures import load_captured
    from phonanim.training.motion import fit_motion
    from phonanim.training.mouth import fit_mouth, save_mouth
    from phonanim.training.recipe import read_recipe
    from phonanim.training.recipes import fit_recipe

    recipe = read_recipe(job.recipe)
    recipe = replace(recipe, settings={**(recipe.settings or {}), **job.settings})
    if job.seed is not None:
        recipe = replace(recipe, seed=job.seed)
    load: Callable[[Path], Any] = load_cached_motion if has_own_motion(job.corpus) else load_cached_corpus
    corpus, begin = load(job.corpus), time.process_time()
    if isinstance(corpus, MotionCorpus):
        part = training_part(corpus, job.clips)
        regressors.save(
            fit_motion(recipe, part, recipe.seed, job.recipe, lambda done: None, None), job.folder
        )
    elif job.mouth:
        mouth = fit_mouth(recipe, corpus, load_captured(job.corpus), job.recipe)
        save_mouth(mouth, job.folder)
    else:
        face = reference_face(job.corpus, job.face_clips)
        model = fit_recipe(recipe, corpus, np.array(job.clips), recipe.seed, job.recipe, face=face)
        regressors.save(model, job.folder)
    seconds = time.process_time() - begin
    facts = {"key": job.key, "seconds": round(seconds, 1), "settings": job.settings}
    write_text(job.folder / JOB, json.dumps(facts, indent=1) + "\n")


def read_job(folder: Path) -> dict[str, Any]:
    """The facts that `train_job` wrote into a folder. Raises ModelError."""
    path = folder / JOB
    try:
        facts = decode_table(read_json(path, MAX_JOB), "the file")
        decode_text(facts["key"], "key")
        decode_number(facts["seconds"], "seconds", 0, LONGEST)
    except (OSError, *DAMAGE) as error:
        raise ModelError(
            f"{path}: is damaged ({error}); delete its folder, and the model is trained again"
        ) from error
    return facts


def folder_name(name: str) -> str:
    """A model's name as a folder name."""
    return re.sub(r"[^\w.+-]+", "_", name)


def seed_folders(plan: Plan, name: str, folder: Path) -> list[tuple[int | None, Path]]:
    """The folder of a model's trainings for each of its seeds, None where the seed is the recipe's own."""
    seeds = plan.seeds[:1] if name in plan.one_seed else plan.seeds
    return [(seed, folder / f"seed{seed}") for seed in seeds] or [(None, folder)]


def load_trained(folder: Path) -> Trained:
    """A model folder, with the seconds of its training if `train_job` trained it."""
    seconds = read_job(folder)["seconds"] if (folder / JOB).is_file() else None
    return Trained(regressors.load(folder), seconds)


def describe_model(model: regressors.Model) -> dict[str, Any]:
    """Kind, input, number of parameters and bytes of a model."""
    tensors = model.regressor.tensors().values()
    return {
        "kind": model.card.get("kind", ""),
        "driven_by": model.regressor.input_modality,
        "numbers": int(sum(t.size for t in tensors)),
        "bytes": int(sum(t.nbytes for t in tensors)),
        "config": asdict(model.regressor.config),
    }
