import pickle
import shutil
from dataclasses import replace
from pathlib import Path, PurePosixPath

import pytest

from phonanim.core import plugins
from phonanim.core.plugins import plugin_packages
from phonanim.dubbing import make as module
from phonanim.dubbing.job import Job
from phonanim.dubbing.line import Line
from phonanim.dubbing.make import make_line
from phonanim.dubbing.provenance import find_extensions, rig_hash
from phonanim.errors import RigError
from phonanim.media.glb import read_glb
from phonanim.options import DEFAULTS
from phonanim.rig.head import load_head
from phonanim.rig.meshes import write_head
from phonanim.rig.morphs import find_morphs
from phonanim.rig.names import read_name_table
from phonanim.rig.read import find_rig, read_document


@pytest.fixture
def job(root, tmp_path):
    line = Line("x", "row 2", root / "examples/line.TextGrid", None, DEFAULTS, PurePosixPath("x"))
    return Job(line, tmp_path, ("csv",), None)


def test_a_fault_of_phonanim_costs_one_line(job, monkeypatch):
    def faulty(*arguments):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(module, "animate_corrected", faulty)
    result = make_line(job)
    assert result.made
    assert result.outcome.error == (
        f"{job.line.alignment}: an error in phonanim, please report it: ZeroDivisionError: division by zero"
    )


def test_a_plugin_that_fails_costs_one_line(job, monkeypatch):
    def faulty(*arguments):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(module, "animate_corrected", faulty)
    monkeypatch.setitem(
        plugins._loaded, __name__.partition(".")[0], "plugin 'x' of phonanim.readers (package y 1.0)"
    )
    assert make_line(job).outcome.error == (
        f"{job.line.alignment}: plugin 'x' of phonanim.readers (package y 1.0) failed: "
        "ZeroDivisionError: division by zero; update or uninstall it"
    )


def test_what_was_made_is_kept(job):
    first = make_line(job)
    assert first.outcome.done
    assert first.made
    again = make_line(Job(job.line, job.folder, job.formats, first.outcome))
    assert not again.made
    assert again.outcome == first.outcome
    other = make_line(Job(job.line, job.folder, ("csv", "npz"), first.outcome))
    assert other.made
    assert set(other.outcome.outputs) == {"x.csv", "x.npz"}


def test_a_language_on_the_path_counts(job, tmp_path, monkeypatch):
    first = make_line(job)
    assert not {"languages", "plugins"} & set(first.outcome.origin)
    monkeypatch.setenv("PHONANIM_PATH", str(tmp_path / "own"))
    table = tmp_path / "own/languages/aaa.toml"
    table.parent.mkdir(parents=True)
    origins = [first.outcome.origin]
    for title in ("One", "Two"):
        table.write_text(f'title = "{title}"\ncode = "qq"\n')
        again = make_line(Job(job.line, job.folder, job.formats, first.outcome, run=title))
        assert again.made
        origins.append(again.outcome.origin)
    assert origins[1] != origins[2]


def test_an_installed_plugin_counts(job, tmp_path, monkeypatch):
    facts = tmp_path / "site/mine-1.0.dist-info"
    facts.mkdir(parents=True)
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[phonanim.sinks]\nmine = mine\n")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    plugin_packages.cache_clear()
    find_extensions.cache_clear()
    assert make_line(job).outcome.origin["plugins"] == ["mine 1.0"]
    monkeypatch.undo()
    plugin_packages.cache_clear()
    find_extensions.cache_clear()
    assert "plugins" not in make_line(job).outcome.origin


def test_an_alignment_that_vanished(job):
    line = Line("x", "row 2", Path("gone.TextGrid"), None, DEFAULTS, PurePosixPath("x"))
    outcome = make_line(Job(line, job.folder, ("csv",), None)).outcome
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


def test_the_hash_of_a_rig_that_goes_through_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text('through = "a.toml"\n')
    with pytest.raises(RigError, match=r"a\.toml: goes through itself; name another rig"):
        rig_hash("a.toml")


def test_a_table_of_names_travels_with_its_line(job, tmp_path):
    head = load_head()
    hero, table = tmp_path / "hero.glb", tmp_path / "hero.csv"
    write_head(
        hero,
        replace(head, targets=("Mund_auf",), deltas=head.deltas[[head.targets.index("jawOpen")]]),
    )
    table.write_text("shape,control\nMund_auf,jawOpen\n", encoding="utf-8")
    line = replace(job.line, exports={"character": hero}, names=read_name_table(table))
    table.unlink()  # as on a worker with another disk
    sent = pickle.loads(pickle.dumps(Job(line, tmp_path, ("glb",), None)))
    made = make_line(sent)
    assert made.outcome.done
    assert made.outcome.origin["names"] == ["hero.csv", line.names.digest]
    glb = read_glb(tmp_path / "x.glb")
    assert [one.names for one in find_morphs(glb)] == [("Mund_auf",)]
    assert glb.tree["animations"]
    unnamed = make_line(replace(sent, line=replace(line, names=None)))
    assert "has no morph target named like" in unnamed.outcome.error
