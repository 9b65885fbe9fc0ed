import json

import pytest

from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.dubbing.table import COLUMNS, read_table
from phonanim.errors import OptionError
from phonanim.options import Options

GRID = "x"  # the content is not read here


@pytest.fixture
def folder(tmp_path):
    for name in ("b.TextGrid", "a.TextGrid", "sub/c.textgrid", "a.wav", "notes.txt", "sub/.hidden.TextGrid"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(GRID)
    return tmp_path


def ids(lines):
    return [line.id for line in lines.lines]


def table(folder, text, name="table.csv"):
    (folder / name).write_text(text, "utf-8")
    return str(folder / name)


def test_a_folder(folder):
    lines = read_lines(str(folder), Common())
    assert ids(lines) == ["a", "b", "sub/c"]
    assert lines.lines[0].audio == folder / "a.wav"
    assert lines.lines[1].audio is None
    assert str(lines.lines[2].output) == "sub/c"


def test_a_pattern(folder):
    assert ids(read_lines(f"{folder}/**/*.[tT]ext[gG]rid", Common())) == ["a", "b", "sub/c"]
    assert ids(read_lines(f"{folder}/sub/*", Common())) == ["c"]
    assert ids(read_lines(f"{folder}/n*.txt", Common())) == ["notes"]


def test_a_table_overrides_the_options(folder):
    source = table(
        folder, "ID,Text Grid,Lang,Character,Frame-Rate,jaw\nx,a.TextGrid,english,arkit,29.97,1.5\n"
    )
    lines = read_lines(source, Common(Options(fps=50.0, lips=2.0)))
    (line,) = lines.lines
    assert (line.id, line.alignment, line.audio) == ("x", folder / "a.TextGrid", folder / "a.wav")
    assert line.options == Options(language="english", fps=30000 / 1001, jaw=1.5, lips=2.0)


def test_speakers_and_dictionaries_of_a_table(folder):
    (folder / "words.dict").write_text("")
    source = table(folder, "alignment,Actor,Dictionary\na.TextGrid,Ann,words.dict\n")
    (line,) = read_lines(source, Common()).lines
    assert line.options == Options(speaker="Ann", lexicon=str(folder / "words.dict"))


@pytest.mark.parametrize("name", ["t.csv", "t.tsv", "t.jsonl", "semicolons.csv", "utf16.csv", "excel.csv"])
def test_every_kind_of_table(folder, name):
    rows = [["id", "alignment", "language"], ["x", "a.TextGrid", "english"], ["y", "b.TextGrid", ""]]
    separator = {"t.tsv": "\t", "semicolons.csv": ";"}.get(name, ",")
    text = "\r\n".join(separator.join(row) for row in rows)
    if name == "t.jsonl":
        text = "\n".join(json.dumps(dict(zip(rows[0], row, strict=True))) for row in rows[1:]) + "\n\n"
    encoding = {"utf16.csv": "utf-16", "excel.csv": "utf-8-sig"}.get(name, "utf-8")
    (folder / name).write_text(text, encoding)
    lines = read_lines(str(folder / name), Common())
    assert ids(lines) == ["x", "y"]
    assert [line.options.language for line in lines.lines] == ["english", "auto"]


def test_columns_nobody_knows_are_told(folder):
    lines = read_lines(table(folder, "alignment,Director\na.TextGrid,Ann\n"), Common())
    assert lines.notes == ("table.csv: the column 'Director' is not used",)
    assert ids(lines) == ["a"]


def test_no_column_has_two_meanings():
    names = [name for column, others in COLUMNS.items() for name in (column, *others)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("x,,", "the row names no alignment; fill its cell"),
        ("x,missing.TextGrid,", "missing.TextGrid: does not exist; correct the path"),
        ("a,b.TextGrid,", "the id 'a' is already used by table.csv row 2; give every line another"),
        ("A,b.TextGrid,", "the output 'A' is already used by table.csv row 2; give every line another"),
        ("../x,b.TextGrid,", "the id '../x' is outside the output folder"),
        ("x,b.TextGrid,fast", "'fast' is not a frame rate"),
    ],
)
def test_a_bad_row_is_named_and_the_rest_stays(folder, row, message):
    lines = read_lines(
        table(folder, f"id,alignment,fps\na,a.TextGrid,\n{row}\nc,sub/c.textgrid,25\n"), Common()
    )
    assert ids(lines) == ["a", "c"]
    (fault,) = lines.faults
    assert fault.place == "table.csv row 3"
    assert message in fault.message


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("unknown", "drop", "unknown = 'drop'; choose error, nearest or silence"),
        ("jaw", "wide", "jaw = 'wide'; give a number from 0 to 4"),
        ("lips", "-1", "lips = '-1'; give a number from 0 to 4"),
        ("intensity", "nan", "intensity = 'nan'; give a number from 0 to 4"),
    ],
)
def test_bad_cells(folder, column, value, message):
    lines = read_lines(table(folder, f"alignment,{column}\na.TextGrid,{value}\n"), Common())
    assert [fault.message for fault in lines.faults] == [message]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no lines; give it a header and one row per line"),
        ("alignment\n", "has no lines"),
        ("id,algnment\n1,2\n", "has no column 'alignment', only 'id', 'algnment'; is it 'algnment'?"),
        ("id,mood\n1,2\n", "has no column 'alignment', only 'id', 'mood'$"),
        (
            "textgrid,alignment\n1,2\n",
            "the columns 'textgrid' and 'alignment' both mean 'alignment'; drop one",
        ),
        ("alignment\n" + "x" * 200000, "row 2: is not a row of a table"),
    ],
)
def test_tables_of_no_use(tmp_path, text, message):
    with pytest.raises(OptionError, match=message.replace("?", r"\?")):
        read_table(tmp_path / table(tmp_path, text))


def test_json_lines_of_no_use(tmp_path):
    with pytest.raises(
        OptionError, match=r"t.jsonl: has no lines; row 1: the row is list; it is a table; write"
    ):
        read_table(tmp_path / table(tmp_path, "[1]", "t.jsonl"))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ('{"alignment"', "it is not JSON: Expecting ':' delimiter: line 1 column 13 (char 12)"),
        ("[1]", "the row is list; it is a table"),
        ('{"alignment": "b.TextGrid", "fps": NaN}', "it is not JSON: it has NaN, which is not a number"),
        ('{"alignment": ["b.TextGrid"]}', "alignment is list; it is a text"),
        ('{"alignment": ' + "[" * 100 + "]" * 100 + "}", "it is nested deeper than 64 levels"),
        ('{"alignment": ' + "[" * 100_000, "it is not JSON: it is nested deeper than 64 levels"),
    ],
)
def test_a_damaged_row_costs_that_row_only(folder, row, message):
    good = '{"id": "%s", "alignment": "a.TextGrid", "text": "one\u2028line"}'
    lines = read_lines(table(folder, f"{good % 'x'}\n{row}\n{good % 'y'}\n", "t.jsonl"), Common())
    assert [line.id for line in lines.lines] == ["x", "y"]
    assert [(fault.id, fault.message) for fault in lines.faults] == [
        ("t.jsonl row 2", f"{message}; write one object per line")
    ]


def test_a_damaged_row_of_a_csv(folder):
    text = "id,alignment\nx,a.TextGrid\n" + "z" * 200_000 + ",a.TextGrid\ny,a.TextGrid\n"
    lines = read_lines(table(folder, text), Common())
    assert [line.id for line in lines.lines] == ["x", "y"]
    assert [fault.place for fault in lines.faults] == ["table.csv row 3"]
    assert "is not a row of a table" in lines.faults[0].message


def test_bytes_that_are_no_table(tmp_path):
    (tmp_path / "t.csv").write_bytes(b"alignment\n\xff\xff")
    with pytest.raises(OptionError, match=r"t.csv: is not UTF-8 text \(byte 10\); save it as UTF-8"):
        read_table(tmp_path / "t.csv")
    with pytest.raises(OptionError, match=r"missing.csv: cannot be read: No such file"):
        read_table(tmp_path / "missing.csv")


def test_sources_of_no_use(folder):
    (folder / "empty").mkdir()
    for source, message in [
        (folder / "empty", "empty: has no .textgrid or"),
        (folder / "*.grid", r"\*.grid: matches no alignment"),
        (folder / "notes.txt", "notes.txt: is not a folder or a table"),
        (folder / "missing", "missing: does not exist; name a folder, a pattern in quotes, or a table"),
    ]:
        with pytest.raises(OptionError, match=message):
            read_lines(str(source), Common())


def test_rows_with_the_same_cells_share_their_options(folder):
    rows = "alignment,id,rig,jaw\na.TextGrid,1,arkit,0.5\na.TextGrid,2,arkit,0.5\na.TextGrid,3,arkit,0.6\n"
    first, second, third = read_lines(table(folder, rows), Common()).lines
    assert first.options is second.options
    assert (first.options.jaw, third.options.jaw) == (0.5, 0.6)
