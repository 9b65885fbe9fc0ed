"""`phonanim corpus`: recordings to training corpora."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Talk, talk_options


@click.group()
def command() -> None:
    """Make and look at training corpora.

    \b
    Example:
      phonanim corpus build recordings/grid_s1 -o work/corpus
    """


@command.command()
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@talk_options
def build(recordings: Path, output: Path, talk: Talk) -> None:
    """Read a folder of recordings and write a training corpus.

    The folder holds clips.csv, landmarks.npz, textgrid/ and audio/.

    \b
    Example:
      phonanim corpus build recordings/grid_s1 -o work/corpus
    """
    from phonanim.corpus import build_corpus

    with talk.progress("corpus") as progress:
        corpus = build_corpus(recordings, output, progress)
    facts = {
        "corpus": str(output),
        "clips": len(corpus.clips),
        "frames": int(corpus.frames.sum()),
        "fps": corpus.fps,
        "landmarks": len(corpus.indices),
    }
    talk.say(
        f"wrote {output}: {facts['clips']} clips, {facts['frames']} frames, {facts['landmarks']} landmarks"
    )
    talk.result(facts)
