"""Characters by name, and formats that need other rigs, in one run."""

import shutil

import pytest

from phonanim.__main__ import run
from phonanim.dubbing.characters import read_characters
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.errors import OptionError, RigError
from phonanim.exporters import load
from phonanim.rig.head import SHIPPED
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

PHONES = [Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]
TOML = """
[Ann]
rig = "metahuman"
style = "clear"
jaw = 1.5

["Old Bob"]
mesh = "bob.glb"
voice = -25
language = "english"
"""
CSV = """name;rig;mesh;style;language;voice;jaw
Ann;metahuman;;clear;;;1.5
Old Bob;;bob.glb;;english;-25;
"""


@pytest.fixture
def show(tmp_path, monkeypatch, root):
    """Lines, a table and two characters in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root))
    write_textgrid(tmp_path / "a.TextGrid", {"phones": PHONES}, 1.5)
    shutil.copy(SHIPPED, tmp_path / "bob.glb")
    (tmp_path / "show.toml").write_text(TOML)
    (tmp_path / "show.csv").write_text(CSV)
    return tmp_path


def table(folder, *rows, columns="id,alignment,character"):
    (folder / "t.csv").write_text("\n".join([columns, *rows]))
    return "t.csv"


@pytest.mark.parametrize("name", ["show.toml", "show.csv"])
def test_a_name_stands_for_rig_mesh_style_language_and_voice(show, name):
    source = table(show, "1,a.TextGrid,ANN", "2,a.TextGrid,old bob", "3,a.TextGrid,vrm", "4,a.TextGrid,")
    ann, bob, rig, plain = read_lines(source, Common(characters=read_characters(show / name))).lines
    assert (ann.options.rig, ann.options.jaw) == ("metahuman", 1.5)
    assert ann.options.reduction != plain.options.reduction or ann.options.hold != plain.options.hold
    assert (bob.options.rig, bob.options.level, bob.options.language) == ("arkit", -25.0, "english")
    assert bob.exports == {"character": show / "bob.glb"}
    assert rig.options.rig == "vrm"
    assert plain.options == Common().options


def test_a_cell_stands_before_its_character(show):
    source = table(show, "1,a.TextGrid,Ann,vrm,0.5", columns="id,alignment,character,rig,jaw")
    (line,) = read_lines(source, Common(characters=read_characters(show / "show.toml"))).lines
    assert (line.options.rig, line.options.jaw) == ("vrm", 0.5)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("[A]\nrigg = 'vrm'\n", OptionError, "A: has an unknown key 'rigg'; did you mean 'rig'?"),
        ("[A]\nrig = 'vmr'\n", RigError, "there is no rig 'vmr'; did you mean 'vrm'?"),
        ("[A]\nmesh = 'no.glb'\n", OptionError, "no.glb does not exist; correct the path"),
        ("[A]\nmesh = ['a']\n", OptionError, "is not a text or a number"),
        ("A = 1\n", OptionError, "'A' is not a character; write [A]"),
        ("[A]\n[a]\n", OptionError, "a: appears twice"),
        ("", OptionError, "has no character"),
        ("[A", OptionError, "it is not TOML"),
    ],
)
def test_files_of_no_use(tmp_path, text, error, message):
    (tmp_path / "show.toml").write_text(text)
    with pytest.raises(error) as caught:
        read_characters(tmp_path / "show.toml")
    assert message in str(caught.value)


def test_a_name_that_is_nobody_is_one_line_for_all_rows(show, capsys):
    source = table(show, *(f"{n},a.TextGrid,Zed" for n in range(200)), "x,a.TextGrid,Ann")
    arguments = [source, "-o", "out", "--format", "metahuman.csv", "--characters", "show.toml"]
    assert run(["batch", *arguments, "--fps", "10", "--workers", "1"]) == 1
    err = capsys.readouterr().err
    said = "200 lines failed: there is no character or rig 'Zed'; add it to show.toml, or name a rig"
    assert err.count("Zed") == 1
    assert said in err
    assert "(t.csv rows 2-201)" in err
    assert "201 lines: 1 made, 0 kept" in err


def test_every_format_has_the_rig_that_it_needs(show, capsys):
    source = table(show, "x,a.TextGrid,Ann", "y,a.TextGrid,old bob", "z,a.TextGrid,arkit")
    formats = [part for name in ("metahuman.csv", "csv", "npz") for part in ("--format", name)]
    arguments = ["batch", source, "-o", "out", *formats, "--characters", "show.toml", "--workers", "1"]
    assert run([*arguments, "--fps", "10", "-q"]) == 0  # a mesh has no place in these formats
    for name, rig in (("x", "metahuman"), ("y", "arkit"), ("z", "arkit")):
        assert load(show / f"out/{name}.npz").rig == rig
        assert load(show / f"out/{name}.metahuman.csv").rig == "metahuman"
        assert "jawOpen" in load(show / f"out/{name}.csv").channels
    style = ["--style", "clear", "--jaw", "1.5"]
    single = ["animate", "a.TextGrid", "-o", "x.csv", "--rig", "arkit", "--fps", "10", *style, "-q"]
    assert run(single) == 0
    assert (show / "out/x.csv").read_bytes() == (show / "x.csv").read_bytes()
    assert run([*arguments, "--fps", "10"]) == 0
    assert "3 lines: 0 made, 3 kept" in capsys.readouterr().err
    assert run(["audit", source, "--outputs", "out", "--characters", "show.toml", "-q"]) == 0
