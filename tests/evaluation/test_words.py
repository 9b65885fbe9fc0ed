"""Words read from lips: pictures as a network wants them, ranks of what was said, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from animations import line, only
from click.testing import CliRunner

from phonanim.commands.evaluate import command
from phonanim.errors import EvaluationError
from phonanim.evaluation.words import (
    FRAMES,
    SIZE,
    WordReader,
    draw_word,
    load_word_reader,
    read_words,
    word_summary,
)

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
    assert word_summary([opened, opened])["top1"] == 0
    assert word_summary([opened])["top5"] == 1


def test_a_network_is_read_from_its_file(network: Path) -> None:
    reader = load_word_reader(network, network.with_name("words.txt"))
    (found,) = read_words(line(), reader)
    assert (found.word, found.rank) == ("hello", 1)
    (network.with_name("words.txt")).write_text("hello\n")
    with pytest.raises(EvaluationError, match=r"scores \(1, 3\), and .* has 1 words"):
        read_words(line(), load_word_reader(network, network.with_name("words.txt")))
    with pytest.raises(EvaluationError, match="cannot be read as a reader of words"):
        load_word_reader(network.with_name("words.txt"), network.with_name("words.txt"))


def test_the_command_reads_predictions_and_references(network: Path, tmp_path: Path) -> None:
    line().save(tmp_path / "take.npz")
    only(line(), jawOpen=0.2).save(tmp_path / "capture.npz")
    given = [str(tmp_path / "take.npz"), "--lips-read", str(network)]
    listed = ["--words", str(network.with_name("words.txt"))]
    both = ["--reference", str(tmp_path / "capture.npz")]
    result = CliRunner().invoke(command, [*given, *listed, *both, "--json"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["predicted"]["summary"]["top1"] == 1
    assert found["reference"]["files"]["take.npz"][0]["word"] == "hello"
    assert "predicted: 1 words; read first 100%" in CliRunner().invoke(command, [*given, *listed]).stdout
    assert "--words LIST" in CliRunner().invoke(command, given).output
    assert "--reference" in CliRunner().invoke(command, given[:1]).output
