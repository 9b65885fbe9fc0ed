from pathlib import PurePosixPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from phonanim.dubbing.output_names import FORBIDDEN, RESERVED, collision_key, safe_name
from phonanim.errors import OptionError


@pytest.mark.parametrize(
    ("id", "name"),
    [
        ("intro_001", "intro_001"),
        ("act1/scene 2/line.3", "act1/scene 2/line.3"),
        ("act1\\line", "act1/line"),
        ("./a//b/", "a/b"),
        ("Ünïcode_日本", "Ünïcode_日本"),
    ],
)
def test_good_ids_stay(id, name):
    assert safe_name(id) == PurePosixPath(name)


@pytest.mark.parametrize(
    "id",
    [
        "take:1",
        "what?",
        "con",
        "NUL.txt",
        "dot.",
        "trailing ",
        ".hidden",
        "x" * 300,
        "a\nb",
        "COM¹",
        "nul .x",
        "CONIN$",
    ],
)
def test_ids_that_some_file_system_refuses_are_changed_and_stay_apart(id):
    name = safe_name(id).name
    assert name != id
    assert len(name.encode()) < 200
    assert safe_name(id) != safe_name(id + "!")


@pytest.mark.parametrize(
    "id", ["../a", "a/../../b", "/etc/passwd", "C:\\a", "c:a", "\\\\server\\a", "a\\..\\b"]
)
def test_ids_that_lead_out_are_refused(id):
    with pytest.raises(OptionError, match="is outside the output folder; use a relative path"):
        safe_name(id)


@pytest.mark.parametrize("id", ["x/" * 501, "é" * 90 + "/" + ("y" * 180 + "/") * 9])
def test_ids_that_are_too_long_for_a_path_are_refused(id):
    with pytest.raises(OptionError, match="is too long for a path; give the line a shorter one"):
        safe_name(id)


def test_ids_that_name_nothing():
    with pytest.raises(OptionError, match="the id is empty; give every line an id"):
        safe_name(" ")
    with pytest.raises(OptionError, match=r"the id './.' is not a file name"):
        safe_name("./.")


@given(st.text(min_size=1, max_size=400))
def test_every_name_is_safe(id):
    try:
        name = safe_name(id)
    except OptionError:
        return
    assert not name.is_absolute()
    for part in name.parts:
        assert part not in ("", ".", "..")
        assert not FORBIDDEN.search(part)
        assert not RESERVED.fullmatch(part)
        assert part == part.rstrip(". ")
        assert len(part.encode()) <= 190


def test_names_that_one_file_system_takes_for_one():
    assert collision_key(PurePosixPath("A/É")) == collision_key(PurePosixPath("a/e\u0301"))
