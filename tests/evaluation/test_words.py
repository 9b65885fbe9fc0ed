"""Words read from lips: pictures as a network wants them, ranks of what was said, and the command."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from animations import line, only
from click.testing import CliRunner, Result

from phonanim.commands.evaluate import command
from phonanim.errors import EvaluationError
from phonanim.evaluation import words
from phonanim.evaluation.word_errors import spell_visemes, word_summary
from phonanim.evaluation.words import (
    FRAMES,
    SIZE,
    WordRead,
    WordReader,
    draw_word,
    load_word_reader,
    read_words,
)
from phonanim.media.espeak import can_speak
from phonanim.speech.alignment import Interval

WORDS = ("closed", "hello", "open")


def by_darkness(pictures: np.ndarray) -> np.ndarray:
    """Reads an open mouth, which is dark inside, as the last word, and a closed one as the first."""
    dark = (pictures[:, 30:70, 25:63] < 40).mean()
    return np.log(np.array([0.9, 0.08, 0.02]) if dark < 0.05 else np.array([0.1, 0.3, 0.6]))


@pytest.fixture
def network(tmp_path: Path) -> Path:
    """A TorchScript file that likes the second of three words whatever it sees."""
    torch = pytest.importorskip("torch")

    class Network(torch.nn.Module):
        def forward(self, pictures: torch.Tensor, frames: torch.Tensor) -> torch.Tensor:
            level = pictures.mean() * 0 + frames.float().mean() * 0
            return torch.stack([level, level + 1, level - 1])[None]

    torch.jit.script(Network()).save(str(tmp_path / "network.pt"))
    (tmp_path / "words.txt").write_text("CLOSED\nHELLO\nOPEN\n")
    return tmp_path / "network.pt"


def test_pictures_follow_the_mouth() -> None:
    pictures = draw_word(only(line(), jawOpen=0.8), 0.5)
    assert pictures.shape == (FRAMES, SIZE, SIZE)
    assert by_darkness(pictures).argmax() == 2
    assert by_darkness(draw_word(only(line()), 0.5)).argmax() == 0


def test_ranks_are_those_of_the_words_said() -> None:
    reader = WordReader(WORDS, by_darkness)
    (opened,) = read_words(only(line(), jawOpen=0.8), reader)
    assert (opened.word, opened.rank, opened.best) == ("hello", 2, "open")
    assert opened.log_p == pytest.approx(np.log(0.3))
    assert read_words(line(), WordReader(("other",), by_darkness)) == []
    said = Interval("“Hello,”", 0.1, 0.7)
    assert read_words(only(line(), jawOpen=0.8), reader, [said]) == [opened]


def test_a_network_is_read_from_its_file(network: Path) -> None:
    reader = load_word_reader(network, network.with_name("words.txt"))
    (found,) = read_words(line(), reader)
    assert (found.word, found.rank) == ("hello", 1)
    (network.with_name("words.txt")).write_text("hello\n")
    with pytest.raises(EvaluationError, match=r"scores \(1, 3\), and .* has 1 words"):
        read_words(line(), load_word_reader(network, network.with_name("words.txt")))
    with pytest.raises(EvaluationError, match="cannot be read as a reader of words"):
        load_word_reader(network.with_name("words.txt"), network.with_name("words.txt"))


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Black pictures, for readers that do not look at them."""
    monkeypatch.setattr(words, "draw_word", lambda take, middle: np.zeros((FRAMES, SIZE, SIZE), np.uint8))


def run(*given: object) -> Result:
    return CliRunner().invoke(command, list(map(str, given)), catch_exceptions=False)


def test_the_command_reads_predictions_and_references(network: Path, tmp_path: Path) -> None:
    line().save(tmp_path / "take.npz")
    only(line(), jawOpen=0.2).save(tmp_path / "capture.npz")
    given = [tmp_path / "take.npz", "--lips-read", network, "--words", network.with_name("words.txt")]
    result = run(*given, "--reference", tmp_path / "capture.npz", "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["predicted"]["summary"]["top1"] == 1
    assert found["reference"]["files"]["take.npz"][0]["word"] == "hello"
    assert "predicted: 1 words read\n" in run(*given).stdout
    assert "--words LIST" in run(*given[:3]).output
    assert "--reference" in run(given[0]).output
    unread = run(*given, "--fps", "25", "--reference-template", network)
    assert "--reference-template and --fps cannot be used with --lips-read" in unread.output
    assert "name it with --lips-read NETWORK" in run(given[0], "--words", given[-1]).output


@pytest.mark.usefixtures("undrawn")
def test_the_command_counts_errors_of_words_letters_and_visemes(network: Path, tmp_path: Path) -> None:
    labels = ["hello", "open", "Closed.", "strawberry", ""]
    times = np.linspace(0, 1, len(labels) + 1)
    said = tuple(Interval(label, *span) for label, span in zip(labels, pairwise(times), strict=False))
    replace(line(), words=said).save(tmp_path / "take.npz")
    given = [tmp_path / "take.npz", "--lips-read", network, "--words", network.with_name("words.txt")]
    found = json.loads(run(*given, "--json").stdout)["predicted"]
    total = found["summary"]
    assert (total["words"], total["words_not_in_list"]) == (3, 1)
    assert total["wer"] == pytest.approx(2 / 3)
    # hello to open: h by o, p added, l by n, l and o dropped
    assert [row["character_errors"] for row in found["files"]["take.npz"]] == [0, 5, 6]
    assert total["cer"] == pytest.approx(11 / 15)
    # hello: tongue open tongue rounded; open: rounded closed open tongue; closed: tongue tongue rounded
    # teeth together, tongue
    assert [row["visemes"] for row in found["files"]["take.npz"]] == [4, 4, 5]
    assert [row["viseme_errors"] for row in found["files"]["take.npz"]] == [0, 3, 3]
    assert total["viseme_error"] == pytest.approx(6 / 13)
    low, high = total["intervals"]["wer"]
    assert low < 2 / 3 < high
    text = run(*given).stdout
    assert "predicted: 3 words read; 1 more are not in the list\n" in text
    assert f"word error rate           67% [{low:.0%}, {high:.0%}]\n" in text
    assert "viseme error rate         46% [" in text


@pytest.mark.usefixtures("undrawn")
def test_words_without_a_pronunciation_are_counted(network: Path, tmp_path: Path) -> None:
    network.with_name("words.txt").write_text("привет\nhello\nhellonium\n")
    said = (Interval("привет", 0.0, 0.5), Interval("hellonium", 0.5, 1.0))
    replace(line(), words=said).save(tmp_path / "take.npz")
    given = [tmp_path / "take.npz", "--lips-read", network, "--words", network.with_name("words.txt")]
    found = json.loads(run(*given, "--json").stdout)["predicted"]
    assert found["summary"]["words_without_pronunciation"] == 1
    assert found["summary"]["words_spelled_by_letters"] == 1
    assert "visemes" not in found["files"]["take.npz"][0]
    assert (
        "1 with visemes by their letters, in no dictionary; 1 without a pronunciation" in run(*given).stdout
    )
    network.with_name("words.txt").write_text("привет\nздравствуй\nпока\n")
    silent = json.loads(run(*given, "--json").stdout)["predicted"]["summary"]
    assert (silent["viseme_error"], silent["words_without_pronunciation"]) == (None, 1)
    if can_speak():
        russian = json.loads(run(*given, "--language", "russian", "--json").stdout)["predicted"]["summary"]
        assert russian["words_without_pronunciation"] == 0
        assert russian["viseme_error"] > 0


def test_a_line_without_words_of_the_list_says_so(network: Path, tmp_path: Path) -> None:
    line().save(tmp_path / "take.npz")
    network.with_name("words.txt").write_text("closed\nred\nopen\n")
    given = [tmp_path / "take.npz", "--lips-read", network, "--words", network.with_name("words.txt")]
    with pytest.raises(EvaluationError, match="none of its 1 words is in .* animate lines that say some"):
        run(*given)
    replace(line(), words=()).save(tmp_path / "take.npz")
    with pytest.raises(EvaluationError, match="give an --alignment with words"):
        run(*given)


def test_visemes_are_those_of_the_lips() -> None:
    spelled = spell_visemes(["move", "father"])
    assert spelled.visemes["move"] == ("closed", "rounded", "lip on teeth")
    assert spelled.visemes["father"] == ("lip on teeth", "open", "tongue", "tongue")
    assert not spelled.by_letters
    homophenes = [WordRead("pat", 2, -1.0, "mat"), WordRead("pat", 9, -3.0, "pat")]
    total = word_summary(homophenes, spell_visemes(["pat", "mat"]))
    assert (total["wer"], total["cer"], total["viseme_error"]) == (0.5, 1 / 6, 0.0)
