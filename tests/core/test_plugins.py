"""Parts of other packages, found by entry points: the example package, and packages that are broken."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from phonanim.core.plugins import Registry, _entries
from phonanim.datasets import DATASETS
from phonanim.encoders import ENCODERS
from phonanim.exporters import EXPORTERS
from phonanim.readers import READERS
from phonanim.regressors import REGRESSORS
from phonanim.stream.sinks import SINKS

FIT = """
import numpy as np
from pathlib import Path
from phonanim.inputs.alignment import read_alignment
from phonanim.pipeline import load_model
from phonanim.regressors import Examples, Model, make_config, regressor_class, save
from phonanim.speech.language import to_phones

track, _ = to_phones(read_alignment(Path("a.TextGrid")))
times = np.arange(0, track.duration, 0.02)
taught = load_model("default")
modes = taught.regressor.predict(track, times)
examples = Examples((track,), (times,), (modes,), (1.0,))
config = make_config("held_mean", {"gain": 2.0}, "test")
rng = np.random.default_rng(0)
learned = regressor_class("held_mean").fit(config, examples, examples, rng, lambda done: None)
save(Model(learned, taught.face, {"fps": 50.0}), Path("held"))
"""


@pytest.fixture(scope="module")
def example(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the example package installed in it."""
    folder = tmp_path_factory.mktemp("example")
    shutil.copytree(root / "examples/plugin", folder / "source")
    command = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
    command += ["--no-index", "--target", str(folder / "site"), str(folder / "source")]
    subprocess.run(command, check=True, timeout=300)
    return folder / "site"


def python(site: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the packages of a folder as well."""
    paths = [str(site), os.environ.get("PYTHONPATH", ""), str(Path(__file__).parents[2])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))} | variables
    command = [sys.executable, *arguments]
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)


def phonanim(site: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return python(site, "-m", "phonanim", *arguments, **variables)


def package(site: Path, name: str, group: str, entry: str, code: str) -> None:
    """Write an installed package of one module with one entry point."""
    facts = site / f"{name}-1.0.dist-info"
    facts.mkdir(parents=True)
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text(f"[{group}]\n{entry} = {name}\n")
    (site / f"{name}.py").write_text(code)


def complaint(done: subprocess.CompletedProcess[str]) -> str:
    """The one line of a command that failed."""
    assert done.returncode == 2, done
    (line,) = done.stderr.splitlines()
    return line


@pytest.mark.parametrize(
    ("registry", "group"),
    [
        (READERS, "phonanim.readers"),
        (EXPORTERS, "phonanim.exporters"),
        (REGRESSORS, "phonanim.regressors"),
        (ENCODERS, "phonanim.encoders"),
        (DATASETS, "phonanim.datasets"),
        (SINKS, "phonanim.sinks"),
    ],
)
def test_every_group_finds_plugins(
    registry: Registry, group: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = "part_of_" + group.partition(".")[2]
    package(tmp_path, module, group, "mine", "\n".join(f"{name} = 1" for name in registry.needs))
    monkeypatch.syspath_prepend(str(tmp_path))
    _entries.cache_clear()
    assert registry.names() == (*registry.built_in(), "mine")
    assert registry.find("mine").__name__ == module
    assert registry.name_of(module) == "mine"
    _entries.cache_clear()


def test_info_lists_the_parts_of_an_installed_package(example: Path) -> None:
    facts = json.loads(phonanim(example, "info", "--json").stdout)
    assert facts["reads"]["durations"] == "durations, a label and its seconds in each line"
    assert facts["writes"][".servo"] == "Angles of a jaw servo in degrees, one line per frame"


def test_its_reader_and_its_exporter_animate_a_line(example: Path, tmp_path: Path) -> None:
    (tmp_path / "line.durations").write_text("# durations\nsil 0.2\nAA1 0.2\nM 0.1\nsil 0.2\n")
    done = phonanim(
        example, "animate", f"{tmp_path}/line.durations", "-o", f"{tmp_path}/line.servo", "--fps", "50"
    )
    assert done.returncode == 0, done.stderr
    angles = [float(line) for line in (tmp_path / "line.servo").read_text().splitlines()]
    assert len(angles) == 36
    assert max(angles) == max(angles[10:20]) > 1.5 * angles[0] > 0


def test_the_errors_of_its_parts_are_one_line(example: Path, tmp_path: Path) -> None:
    bad, good = tmp_path / "bad.durations", tmp_path / "good.durations"
    bad.write_text("# durations\nsil 0.2 s\n")
    good.write_text("# durations\nsil 0.2\nM 0.1\n")
    line = complaint(phonanim(example, "animate", str(bad)))
    assert line.endswith("bad.durations: line 2 is 'sil 0.2 s'; write a label and its seconds")
    done = phonanim(example, "animate", str(good), "-o", f"{tmp_path}/a.servo", "--rig", "rhubarb")
    assert complaint(done).endswith("a.servo: the rig rhubarb has no jawOpen; use --rig arkit")


def test_its_regressor_is_stored_and_animates(example: Path, line: Path) -> None:
    done = python(example, "-c", FIT)
    assert done.returncode == 0, done.stderr
    assert json.loads((line / "held/model.json").read_text())["kind"] == "held_mean"
    done = phonanim(example, "animate", "a.TextGrid", "-o", "a.npz", "--model", "held")
    assert done.returncode == 0, done.stderr
    assert "moved arkit by held" in done.stderr


def test_without_the_package_its_model_names_the_known_kinds(example: Path, line: Path) -> None:
    assert python(example, "-c", FIT).returncode == 0
    text = complaint(phonanim(line, "animate", "a.TextGrid", "-o", "a.npz", "--model", "held"))
    assert text.startswith("phonanim: there is no regressor 'held_mean'; did you mean 'phone_mean'? (known: ")


def test_its_language_is_found_on_the_path(example: Path, root: Path, tmp_path: Path) -> None:
    folder = str(root / "examples/plugin/lexicon")
    done = phonanim(example, "info", "--language", "hawaiian", "--json", PHONANIM_PATH=folder)
    facts = json.loads(done.stdout)
    assert facts["title"] == "Hawaiian: its orthography, one letter for each sound"
    assert (facts["labels"]["ā"], facts["labels"]["p"]) == ("aa", "p")


def test_built_in_parts_cost_no_look_at_packages(line: Path) -> None:
    code = (
        "import sys; from phonanim.__main__ import run; code = run(sys.argv[1:]);"
        "print(code, 'importlib.metadata' in sys.modules)"
    )
    done = python(line, "-c", code, "animate", "a.TextGrid", "-o", "a.csv", "-o", "a.glb")
    assert done.stdout.split() == ["0", "False"], done


def test_a_plugin_that_cannot_be_loaded_is_named(line: Path) -> None:
    package(line / "site", "torn", "phonanim.exporters", "abc", "import nothing_of_this_name")
    text = complaint(phonanim(line / "site", "animate", "a.TextGrid", "-o", "a.abc"))
    assert text == (
        "phonanim: plugin 'abc' of phonanim.exporters (package torn 1.0): cannot be loaded: "
        "ModuleNotFoundError: No module named 'nothing_of_this_name'; update or uninstall the package"
    )
    assert phonanim(line / "site", "animate", "a.TextGrid", "-o", "a.csv").returncode == 0


def test_a_plugin_that_lacks_a_part_is_named(line: Path) -> None:
    package(line / "site", "half", "phonanim.sinks", "radio", "SUMMARY = 'Radio'")
    done = phonanim(line / "site", "stream", "a.TextGrid", "--to", "radio")
    assert complaint(done) == (
        "phonanim: plugin 'radio' of phonanim.sinks (package half 1.0): has no ADDRESS; "
        "phonanim.sinks needs SUMMARY, ADDRESS, open_sink"
    )


def test_two_packages_with_one_name_are_named(line: Path) -> None:
    for name in ("one", "two"):
        package(line / "site", name, "phonanim.readers", "same", "")
    (line / "a.txt").write_text("?")
    assert complaint(phonanim(line / "site", "animate", "a.txt")) == (
        "phonanim: two packages have a plugin 'same' of phonanim.readers: one 1.0 and two 1.0; uninstall one"
    )


def test_a_built_in_name_wins(line: Path) -> None:
    package(line / "site", "greedy", "phonanim.exporters", "csv", "raise RuntimeError")
    assert phonanim(line / "site", "animate", "a.TextGrid", "-o", "a.csv").returncode == 0
    done = phonanim(line / "site", "animate", "a.TextGrid", "-o", "a.xyz")
    assert "a.xyz: no format has this suffix" in complaint(done)


def test_a_plugin_that_fails_in_use_is_named(line: Path) -> None:
    code = "SUMMARY = 'Fails'\ndef write(animation, path):\n    raise ZeroDivisionError('no luck')\n"
    package(line / "site", "unlucky", "phonanim.exporters", "abc", code)
    assert complaint(phonanim(line / "site", "animate", "a.TextGrid", "-o", "a.abc")) == (
        "phonanim: plugin 'abc' of phonanim.exporters (package unlucky 1.0) failed: "
        "ZeroDivisionError: no luck; update or uninstall it"
    )
