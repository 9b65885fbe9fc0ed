"""What holds for every command: help, errors, exit codes, and what is imported."""

import json
import re
import subprocess
import sys
from importlib import import_module

import click
import pytest

from phonanim.__main__ import CommandFolder, commands, run
from phonanim.core.version import __version__

HEAVY = {
    "torch",
    "scipy",
    "sklearn",
    "matplotlib",
    "trimesh",
    "pandas",
    "PIL",
    "soundfile",
    "pocketsphinx",
    "dask",
}
NAMES = commands.list_commands(click.Context(commands))


def all_commands():
    """Every command with its words: ("corpus", "build") and so on."""
    for name in NAMES:
        command = import_module(f"phonanim.commands.{name}").command
        yield (name,), command
        if isinstance(command, click.Group):
            for child in command.list_commands(click.Context(command)):
                yield (name, child), command.get_command(click.Context(command), child)


@pytest.mark.parametrize(("words", "command"), list(all_commands()), ids=lambda value: str(value))
def test_help_has_an_example_that_the_command_takes(words, command, capsys):
    assert run([*words, "--help"]) == 0
    text = capsys.readouterr().out
    examples = re.findall(rf"^ +phonanim {' '.join(words)}\b.*$", text, re.MULTILINE)
    assert examples, text
    options = {
        option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)
    }
    if not isinstance(command, click.Group):
        used = {word for example in examples for word in re.findall(r"(?<=\s)--?[a-z][\w-]*", example)}
        assert used <= options


@pytest.mark.parametrize(("words", "command"), list(all_commands()), ids=lambda value: str(value))
def test_every_command_talks_the_same_way(words, command):
    if not isinstance(command, click.Group):
        assert {"as_json", "quiet"} <= {parameter.name for parameter in command.params}


def test_the_folder_is_the_registry(root):
    files = {path.stem for path in (root / "phonanim" / "commands").glob("*.py")}
    assert set(NAMES) == {name for name in files if not name.startswith("_")}
    assert isinstance(commands, CommandFolder)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["animte"], "phonanim: No such command 'animte'"),
        (["animate"], "phonanim animate: give an ALIGNMENT, a recording, or --text; see"),
        (["animate", "missing.TextGrid"], "'missing.TextGrid' does not exist"),
        (["models", "--colour"], "phonanim models: No such option"),
        (["corpus", "build", "missing", "-o", "x"], "Directory 'missing' does not exist"),
    ],
)
def test_usage_errors_are_one_line_and_exit_2(arguments, line, capsys):
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert line in err
    assert err.count("\n") == 1


def test_without_a_command_there_is_help(capsys):
    assert run([]) == 2
    assert "Commands:" in capsys.readouterr().err


def test_version(capsys):
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"phonanim {__version__}\n"


def test_an_interrupt_is_130(monkeypatch):
    command = import_module("phonanim.commands.models").command

    def interrupted(**arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "callback", interrupted)
    assert run(["models"]) == 130


@pytest.mark.parametrize("start", [["-m", "phonanim"], ["cli.py"]])
def test_both_ways_to_start(start, root):
    done = subprocess.run([sys.executable, *start, "--version"], cwd=root, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"phonanim {__version__}\n")


def test_from_a_clone_in_another_folder(root, tmp_path):
    command = [sys.executable, str(root / "cli.py"), "models", "--json"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "default" in {model["name"] for model in json.loads(done.stdout)}


def test_a_closed_pipe_is_quiet(root):
    command = f"{sys.executable} cli.py info --language english | head -1"
    done = subprocess.run(command, shell=True, cwd=root, capture_output=True, text=True)
    assert done.stderr == ""


def imported(arguments, root):
    code = (
        "import sys; from phonanim.__main__ import run; code = run(sys.argv[1:]); "
        "print('MODULES', *{name.partition('.')[0] for name in sys.modules}); sys.exit(code)"
    )
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.partition("MODULES")[2].split())


def test_help_imports_nothing_heavier_than_click(root):
    for arguments in (["--help"], ["animate", "--help"], ["batch", "--help"]):
        assert not imported(arguments, root) & (HEAVY | {"numpy", "rich", "praatio", "pygltflib"})


def test_animate_imports_nothing_heavier_than_numpy(root, tmp_path):
    line = str(root / "examples" / "line.TextGrid")
    outputs = [
        argument for suffix in ("csv", "npz", "glb") for argument in ("-o", str(tmp_path / f"a.{suffix}"))
    ]
    assert not imported(["animate", line, *outputs], root) & (HEAVY | {"rich", "praatio"})
