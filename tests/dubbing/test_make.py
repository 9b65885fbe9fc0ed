import shutil
from pathlib import Path, PurePosixPath

import pytest

from phonanim.dubbing import make as module
from phonanim.dubbing.job import Job
from phonanim.dubbing.line import Line
from phonanim.dubbing.make import make
from phonanim.dubbing.origin import rig_hash
from phonanim.options import DEFAULTS
from phonanim.rig.read import find_rig, read_document


@pytest.fixture
def job(root, tmp_path):
    line = Line("x", "row 2", root / "examples/line.TextGrid", None, DEFAULTS, PurePosixPath("x"))
    return Job(line, tmp_path, ("csv",), None)


def test_a_fault_of_phonanim_costs_one_line(job, monkeypatch):
    def faulty(*arguments):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(module, "perform", faulty)
    result = make(job)
    assert result.made
    assert result.outcome.error == (
        f"{job.line.alignment}: a fault of phonanim, please report it: ZeroDivisionError: division by zero"
    )


def test_what_was_made_is_kept(job):
    first = make(job)
    assert first.outcome.done
    assert first.made
    again = make(Job(job.line, job.folder, job.formats, first.outcome))
    assert not again.made
    assert again.outcome == first.outcome
    other = make(Job(job.line, job.folder, ("csv", "npz"), first.outcome))
    assert other.made
    assert set(other.outcome.outputs) == {"x.csv", "x.npz"}


def test_an_alignment_that_vanished(job):
    line = Line("x", "row 2", Path("gone.TextGrid"), None, DEFAULTS, PurePosixPath("x"))
    outcome = make(Job(line, job.folder, ("csv",), None)).outcome
    assert outcome.error == "gone.TextGrid: No such file or directory"


@pytest.mark.parametrize("name", ["arkit", "oculus15", "arkit_tongue"])
def test_every_file_of_a_rig_counts(name, tmp_path):
    shutil.copytree(find_rig(name).parent.parent, tmp_path / "lexicon")
    path = tmp_path / f"lexicon/rigs/{name}.toml"
    hashes = [rig_hash(str(path))]
    files = [path.parent / value for value in read_document(path).values() if str(value).endswith(".csv")]
    assert files
    for file in (path, *files):
        file.write_text(file.read_text("utf-8") + "\n", "utf-8")
        rig_hash.cache_clear()
        hashes.append(rig_hash(str(path)))
    assert len(set(hashes)) == len(files) + 2
