import pytest

from phonanim.errors import OptionError
from phonanim.life.parsing import parse_emotions, parse_life, parse_look_at, parse_seed, read_emotions
from phonanim.options import Emotion


def test_life_is_a_number_or_one_for_each_behaviour():
    assert parse_life("0") == 0.0
    assert parse_life(" 0.5 ") == 0.5
    assert parse_life("brows=0, head=0.5") == {"brows": 0.0, "head": 0.5}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "life = ''; give a number from 0 to 4"),
        ("much", "life = 'much'; give a number from 0 to 4"),
        ("5", "life = '5'; give a number from 0 to 4"),
        ("brow=1", "life: there is no behaviour 'brow'; did you mean brows?"),
        ("ears=1", "life: there is no behaviour 'ears'; choose blinks, gaze, head, brows, breath"),
        ("brows=x", "life brows = 'x'; give a number from 0 to 4"),
    ],
)
def test_life_that_makes_no_sense(text, message):
    with pytest.raises(OptionError) as caught:
        parse_life(text)
    assert message in str(caught.value)


def test_a_place_to_look_at():
    assert parse_look_at("0.3,-0.1,1.2") == (0.3, -0.1, 1.2)


@pytest.mark.parametrize("text", ["1,2", "a,b,c", "0,0,0", "0,0,-1", "nan,0,1", "0,inf,1"])
def test_places_that_are_none(text):
    with pytest.raises(OptionError, match=r"is not X,Y,Z in metres to the speaker's left, up and ahead"):
        parse_look_at(text)


def test_seeds():
    assert parse_seed(" 7 ") == 7
    with pytest.raises(OptionError, match="seed '-1'; give a whole number from 0"):
        parse_seed("-1")


def test_emotions_of_a_line(tmp_path):
    path = tmp_path / "mood.csv"
    path.write_text("emotion,weight,start,end\nanger,0.3,1,2.5\n\nsadness,1,3,4\n")
    found = parse_emotions(["joy=0.4@1.2-3", "surprise", str(path)])
    assert found == (
        Emotion("joy", 0.4, (1.2, 3.0)),
        Emotion("surprise", 1.0, None),
        Emotion("anger", 0.3, (1.0, 2.5)),
        Emotion("sadness", 1.0, (3.0, 4.0)),
    )


def test_an_emotion_that_is_none():
    with pytest.raises(OptionError, match="there is no emotion 'joi'; did you mean joy"):
        parse_emotions(["joi=0.4"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n", "its first row must be emotion,weight,start,end"),
        ("", "its first row must be emotion,weight,start,end"),
        ("emotion,weight,start,end\njoy,1,2\n", "row 2: has 3 cells; give emotion, weight, start, end"),
        ("emotion,weight,start,end\njoy,1,2,1\n", "row 2: start '2' and end '1' must be seconds, and rise"),
        ("emotion,weight,start,end\njoy,1,a,1\n", "row 2: start 'a' and end '1' must be seconds, and rise"),
        ("emotion,weight,start,end\njoy,x,0,1\n", "row 2: weight = 'x'; give a number from 0 to 4"),
        ("emotion,weight,start,end\nglee,1,0,1\n", "row 2: there is no emotion 'glee'"),
    ],
)
def test_spans_that_make_no_sense(tmp_path, text, message):
    path = tmp_path / "mood.csv"
    path.write_text(text)
    with pytest.raises(OptionError) as caught:
        read_emotions(path)
    assert f"{path}" in str(caught.value)
    assert message in str(caught.value)


def test_spans_that_cannot_be_read(tmp_path):
    with pytest.raises(OptionError, match=r"none\.csv: cannot be read"):
        read_emotions(tmp_path / "none.csv")
