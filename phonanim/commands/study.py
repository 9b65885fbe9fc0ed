"""`phonanim study`: ask people which take they prefer, and analyse their answers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from phonanim.commands import Console, console_options
from phonanim.commands._renamed import renamed_option
from phonanim.errors import StudyError

if TYPE_CHECKING:
    from phonanim.study.results import Exclusion, Participant

INTERVALS_SEED = 2017  # of the bootstrap, so that the same answers give the same intervals


@click.group()
def command() -> None:
    """Ask people which take they prefer, and analyse their answers.

    \b
    Example:
      phonanim study make ours/ other/ -o study.html
      phonanim study analyse results/
    """


@command.command()
@click.argument("takes", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(dir_okay=False, path_type=Path), help="HTML file."
)
@click.option(
    "--ours", metavar="SYSTEM", help="Compare this system with each other one; all pairs by default."
)
@click.option(
    "--choices",
    type=click.Choice(["forced", "none", "equal"]),
    default="forced",
    help="Answers besides left and right: none, 'neither fits', or 'both alike'.",
)
@click.option("--rating/--no-rating", default=True, help="Also ask for one to five stars.")
@click.option(
    "--practice", type=click.IntRange(0), default=3, help="Number of practice lines, which are not counted."
)
@click.option(
    "--controls", type=click.IntRange(0), default=3, help="Number of trials with an obviously wrong take."
)
@click.option(
    "--trials",
    type=click.IntRange(0),
    default=0,
    help="Test trials per participant, chosen at random; 0 shows all.",
)
@click.option("--title", default="Which animation fits the speech?", help="Heading of the page.")
@click.option(
    "--question",
    "questions",
    multiple=True,
    default=["In which take does the face fit the speech better?"],
    help="A question about each pair. Repeatable; stars and controls belong to the first.",
)
@click.option("--thanks", default="Thank you. That was all.", help="Text shown at the end.")
@click.option("--post", metavar="URL", default="", help="Address that receives the answers.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the choice of practice lines.")
@console_options
def make(
    takes: tuple[Path, ...],
    output: Path,
    ours: str | None,
    choices: str,
    rating: bool,
    practice: int,
    controls: int,
    trials: int,
    title: str,
    questions: tuple[str, ...],
    thanks: str,
    post: str,
    seed: int,
    console: Console,
) -> None:
    """Write a web page, in one file, that shows takes side by side and asks which is better.

    TAKES are folders of films (MP4 or WebM, with sound), one a system, with the same names in each; or one
    table with the column `item` and a column of paths for each system.

    \b
    Examples:
      phonanim study make ours/ lstm/ tree/ --ours ours -o study.html
      phonanim study make ours/ other/ -o study.html --question "Whose lips fit?" --question "Who is real?"
      phonanim study make takes.csv --choices none --post https://example.org/answers -o study.html
    """
    import numpy as np

    from phonanim.study.page import Wording, write_page
    from phonanim.study.plan import plan_trials
    from phonanim.study.takes import read_takes, systems_of

    lines = read_takes(takes)
    planned = plan_trials(lines, np.random.default_rng(seed), choices, ours, practice, controls)
    words = Wording(title, questions, thanks, choices, rating, trials, post)
    size = write_page(output, planned, words)
    counts = {kind: sum(trial.kind == kind for trial in planned) for kind in ("practice", "test", "control")}
    shown = min(counts["test"], trials or counts["test"]) + counts["practice"] + counts["control"]
    console.print(
        f"wrote {output} ({size / 1e6:.1f} MB): {len(lines)} lines, {', '.join(systems_of(lines))}; "
        f"{shown} trials a participant"
    )
    console.print_result(
        {"page": str(output), "bytes": size, "trials": counts, "trials_a_participant": shown}
    )


@command.command()
@click.argument(
    "lines", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@click.option(
    "--sounds",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder of the recordings, by the names of the lines; beside them by default.",
)
@click.option("--format", "kind", default="mp4", help="Format of the takes.")
@console_options
def tongues(lines: tuple[Path, ...], output: Path, sounds: Path | None, kind: str, console: Console) -> None:
    """Write takes that differ in the tongue alone, for `phonanim study make`.

    LINES are animations with a tongue (--rig arkit_tongue), each with its recording beside it or in --sounds.
    OUTPUT gets three folders: tongue (as it is), mismatch (the tongue of the next line), null (a still one).

    \b
    Example:
      phonanim batch lines/ -o work/lines --rig arkit_tongue --format npz
      phonanim study tongues work/lines/*.npz --sounds lines/ -o takes
      phonanim study make takes/tongue takes/mismatch takes/null -o study.html
    """
    from phonanim.core.files import make_folder_within
    from phonanim.exporters import find_exporter
    from phonanim.study.tongues import SYSTEMS, load_with_sound, partners, tongue_takes

    others = partners(len(lines))
    find_exporter(output / f"x.{kind}")
    read = [load_with_sound(path, sounds) for path in lines]
    for path, animation, other in zip(lines, read, others, strict=True):
        for system, take in tongue_takes(animation, read[other]).items():
            take.save(make_folder_within(output / system, output) / f"{path.stem}.{kind}")
    folders = [str(output / system) for system in SYSTEMS]
    console.print(f"wrote {len(lines)} takes each into {', '.join(folders)}")
    console.print_result({"takes": len(lines), "folders": folders})


@command.command()
@click.argument("results", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--ours", metavar="SYSTEM", help="System that is named first in its pairs.")
@renamed_option(
    "--max-failed-controls",
    "--allow",
    type=click.IntRange(0),
    default=0,
    help="Number of control trials that a participant may fail.",
)
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Markdown file.")
@console_options
def analyse(
    results: tuple[Path, ...], ours: str | None, allow: int, output: Path | None, console: Console
) -> None:
    """Analyse the answers: wins and losses by majority, preferences, ratings, and tests.

    RESULTS are the JSON files that the page made, folders of them, or one CSV with counts by line (columns
    group, ours, other, item, for, against).

    \b
    Examples:
      phonanim study analyse results/ --ours ours -o study.md
      phonanim study analyse examples/taylor2017_judgements.csv
    """
    import numpy as np

    from phonanim.core.files import write_text
    from phonanim.study.analysis import compare_systems, rate_systems
    from phonanim.study.report import markdown
    from phonanim.study.tally import count_answers, read_counts

    rng = np.random.default_rng(INTERVALS_SEED)
    kept: tuple[Participant, ...] = ()
    excluded: tuple[Exclusion, ...] = ()
    if results[0].suffix.lower() == ".csv":
        if len(results) > 1:
            raise StudyError(f"{results[0]}: counts must be in one CSV file; give it alone")
        tallies = read_counts(results[0])
    else:
        kept, excluded = screen_participants(results, allow)
        tallies = count_answers(kept, ours)
    comparisons, ratings = compare_systems(tallies, rng), rate_systems(kept, rng, ours)
    text = markdown(comparisons, ratings, excluded, len(kept))
    if output:
        write_text(output, text + "\n")
        console.print(f"wrote {output}")
    facts = {
        "participants": len(kept),
        "excluded": [asdict(one) for one in excluded],
        "comparisons": [asdict(one) for one in comparisons],
        "ratings": [asdict(one) for one in ratings],
    }
    console.print_result(facts, "" if output else text)


def screen_participants(
    results: tuple[Path, ...], allow: int
) -> tuple[tuple[Participant, ...], tuple[Exclusion, ...]]:
    """Split participants into accepted and excluded. Raises StudyError when none is accepted."""
    from phonanim.study.results import read_results, screen_answers

    kept, excluded = screen_answers(read_results(results), allow)
    if not kept:
        reasons = "; ".join(f"{one.name} {one.reason}" for one in excluded)
        raise StudyError(f"no answers count: {reasons}")
    return kept, excluded
