"""`phonanim compare`: train and score models on the same clips, with intervals, tests and figures."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options


@click.command()
@click.argument("plan", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("comparison"),
    show_default=True,
    help="Folder for benchmark.md; its figures and long tables go to benchmark/ in it.",
)
@click.option(
    "--work",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder that keeps the trained models and all sums (OUTPUT/models).",
)
@click.option(
    "--workers", type=click.IntRange(min=1), help="Number of models trained at once (one per core)."
)
@click.option("--report-only", is_flag=True, help="Write the report again from sums.json of --work.")
@console_options
def command(
    plan: Path, output: Path, work: Path | None, workers: int | None, report_only: bool, console: Console
) -> None:
    """Train or load the models of a plan, score them on the same held-out clips, and write a report.

    The corpus is of landmarks, or of controls, sensors or vertices (`phonanim corpus build`). Trained models
    are kept, so an interrupted comparison continues where it stopped.

    \b
    Examples:
      phonanim compare benchmarks/compare.toml -o docs --work work/compare
      phonanim compare benchmarks/facegood.toml -o work/facegood_compared
      phonanim compare benchmarks/compare.toml -o docs --work work/compare --report-only
    """
    from phonanim.core.threads import use_one_thread

    use_one_thread()
    from phonanim.comparison.figures import check_drawable
    from phonanim.comparison.motion import compare_motion
    from phonanim.comparison.motion_report import write_motion_report
    from phonanim.comparison.plan import read_plan
    from phonanim.comparison.report import read_document, write_document, write_report
    from phonanim.comparison.run import compare
    from phonanim.core.threads import count_cores
    from phonanim.corpus.motion import has_own_motion

    check_drawable()
    found = read_plan(plan)
    own = has_own_motion(found.corpus)
    run, write = (compare_motion, write_motion_report) if own else (compare, write_report)
    work = work or output / "models"
    if report_only:
        document = read_document(work)
    else:
        with console.progress(plan.stem) as bar:
            document = run(found, work, workers or count_cores(), lambda what, done: bar(done, what))
        write_document(document, work)
    written = write(document, found, output)
    console.print(f"wrote {written}")
    console.print_result({"report": str(written), "json": str(output / "benchmark" / "benchmark.json")})
