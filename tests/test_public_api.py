"""The public interface: its names, their signatures, and an example of each that runs.

`python tests/test_public_api.py > tests/public_api.txt` accepts a change of the interface. Such a change
belongs in CHANGELOG.md as well.
"""

from __future__ import annotations

import doctest
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import phonanim
from phonanim.errors import AlignmentError, EvaluationError, OptionError

LIST = Path(__file__).with_name("public_api.txt")
UPDATE = "python tests/test_public_api.py > tests/public_api.txt"


def signatures() -> Iterator[str]:
    """Every public function, class, field and method, one a line."""
    for name in phonanim.__all__:
        thing = getattr(phonanim, name)
        if not inspect.isclass(thing):
            yield name + plain(inspect.signature(thing))
            continue
        yield f"class {name}"
        for parameter in inspect.signature(thing).parameters.values():
            yield f"    {plain(parameter)}"
        yield from members(thing)


def members(kind: type) -> Iterator[str]:
    """The public methods and properties that a class defines."""
    for name, member in vars(kind).items():
        if name.startswith("_"):
            continue
        if isinstance(member, property):
            yield f"    .{name} -> {inspect.signature(member.fget).return_annotation}"
        elif isinstance(member, classmethod) or inspect.isfunction(member):
            yield f"    .{name}{plain(inspect.signature(getattr(kind, name)))}"


def plain(signature: inspect.Signature | inspect.Parameter) -> str:
    """As it is written, without quotes around the annotations."""
    return re.sub(r"(: |-> )([\"'])(.+?)\2(?=,|\)| =|$)", r"\1\3", str(signature))


def test_nothing_public_changes_unnoticed() -> None:
    assert "\n".join(signatures()) + "\n" == LIST.read_text("utf-8"), f"to accept the change: {UPDATE}"


@pytest.mark.parametrize("name", phonanim.__all__)
def test_every_public_name_has_an_example_that_runs(name: str, line: Path) -> None:
    (line / "a.TextGrid").rename("line.TextGrid")
    (line / "a.wav").rename("line.wav")
    thing = getattr(phonanim, name)
    (found,) = doctest.DocTestFinder(recurse=False).find(thing, name, globs={})
    assert len(found.examples) >= 2
    output: list[str] = []
    assert doctest.DocTestRunner().run(found, out=output.append).failed == 0, "".join(output)


def test_the_reference_shows_every_public_name(root: Path) -> None:
    page = (root / "docs/api.md").read_text("utf-8")
    shown = {line.rpartition(".")[2] for line in page.splitlines() if line.startswith("::: phonanim.")}
    assert set(phonanim.__all__) <= shown


def test_names_are_found_and_others_are_not() -> None:
    assert set(phonanim.__all__) <= set(dir(phonanim))
    assert set(phonanim._MODULES) == set(phonanim.__all__)
    with pytest.raises(
        AttributeError, match=r"module 'phonanim' has no attribute 'animat'; it has Alignment, "
    ):
        phonanim.animat  # noqa: B018


def test_importing_it_imports_nothing_heavy() -> None:
    place = str(Path(phonanim.__file__).parents[1])
    code = f"import sys; sys.path.insert(0, {place!r}); import phonanim; print(*sys.modules)"
    command = [sys.executable, "-I", "-S", "-c", code]
    names = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    own = [name for name in names if name.startswith("phonanim")]
    assert sorted(own) == ["phonanim", "phonanim.core", "phonanim.core.version"]
    assert not {"numpy", "click", "dataclasses", "pathlib"} & set(names)


def test_the_readme_in_one_line(line: Path) -> None:
    phonanim.animate("a.TextGrid", rig="arkit", fps=30).save("line.csv")
    phonanim.save(phonanim.animate(line / "a.TextGrid", phonanim.Options(rig="arkit", fps=30)), "b.csv")
    assert (line / "line.csv").read_bytes() == (line / "b.csv").read_bytes()


def test_settings_override_options(line: Path) -> None:
    animation = phonanim.animate("a.TextGrid", phonanim.Options(rig="vrm", fps=30), rig="metahuman")
    assert (animation.rig, animation.fps) == ("metahuman", 30)


def test_paths_stand_for_names(root: Path, line: Path) -> None:
    rig = root / "lexicon/rigs/arkit.toml"
    model = root / "phonanim/models/default"
    named = phonanim.animate("a.TextGrid", audio="a.wav", fps=30)
    found = phonanim.animate(line / "a.TextGrid", rig=rig, model=model, audio="a.wav", fps=30)
    assert (found.values == named.values).all()
    assert found.audio == Path("a.wav")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"intensty": 1}, "there is no option 'intensty'; did you mean 'intensity'?"),
        ({"qqq": 1}, "there is no option 'qqq'; the options are rig, model, fps, "),
        ({"fps": "30"}, "options: fps is '30'; take a number"),
        ({"unknown": "no"}, "options: unknown is 'no'; take 'error', 'nearest', 'silence'"),
        (
            {"gains": {"jawOpen": "x"}},
            "options: gains is {'jawOpen': 'x'}; take a table, each value a number",
        ),
        ({"overlays": ("smile",)}, "options: overlays is ('smile',); take a list, each a table"),
        ({"fps": 0}, "0 frames per second: the rate must lie from 1 to 1000"),
        ({"fps": float("nan")}, "nan frames per second: the rate must lie from 1 to 1000"),
    ],
)
def test_a_wrong_option_is_named(settings: dict[str, Any], message: str, line: Path) -> None:
    with pytest.raises(OptionError) as error:
        phonanim.animate("a.TextGrid", **settings)
    assert str(error.value).startswith(message)


def test_evaluate_is_what_the_command_prints(line: Path) -> None:
    import json

    from click.testing import CliRunner

    from phonanim.__main__ import commands

    for name, share in (("ours.csv", 0.5), ("theirs.csv", 1.0)):
        phonanim.animate("a.TextGrid", fps=30, intensity=share).save(name)
    words = ["evaluate", "ours.csv", "--reference", "theirs.csv", "--alignment", "a.TextGrid", "--json"]
    printed = json.loads(CliRunner().invoke(commands, words).stdout)["files"]["ours.csv"]
    scores = phonanim.evaluate("ours.csv", "theirs.csv", alignment="a.TextGrid")
    assert printed["measures"] == pytest.approx(scores.measures, nan_ok=True)
    assert printed["phones"] == [vars(row) for row in scores.phones] != []
    alignment = phonanim.read_alignment("a.TextGrid")
    assert phonanim.evaluate("ours.csv", "theirs.csv", alignment=alignment).phones == scores.phones


def test_what_cannot_be_scored_is_named(line: Path) -> None:
    phonanim.animate("a.TextGrid", fps=30).save("a.csv")
    phonanim.animate("a.TextGrid", rig="rhubarb").save("b.json")
    with pytest.raises(EvaluationError, match=r"a\.csv against b\.json: "):
        phonanim.evaluate("a.csv", "b.json")
    with pytest.raises(AlignmentError, match=r"c\.TextGrid: cannot be read"):
        phonanim.evaluate("a.csv", "a.csv", alignment="c.TextGrid")


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    print("\n".join(signatures()))
