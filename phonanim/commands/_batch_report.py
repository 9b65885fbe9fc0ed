"""What `phonanim batch` tells while it runs and at its end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from phonanim.commands import Console

if TYPE_CHECKING:
    from phonanim.dubbing.job import Result
    from phonanim.dubbing.lines import Lines
    from phonanim.dubbing.outcome import Outcome
    from phonanim.dubbing.storage import Place

MOST_FAILURES = 30  # causes at the end of a run
MOST_CAUSES = 5  # of flags, on the terminal; the report has all


@dataclass
class RunReporter:
    """Reports each line as it ends, the first failure of each reason at once, and the run at its end."""

    count: int
    console: Console
    progress: Callable[[float], None]
    verbose: bool = False
    statuses: Counter[str] = field(default_factory=Counter)
    told: set[str] = field(default_factory=set)

    def tell(self, result: Result) -> None:
        """Report one line."""
        from phonanim.dubbing.causes import failure_reason

        outcome = result.outcome
        status = "failed" if not outcome.done else "made" if result.made else "kept"
        self.statuses[status] += 1
        done = sum(self.statuses.values())
        self.progress(done / self.count)
        facts = {"error": outcome.error, "done": done, "lines": self.count}
        self.console.print_event("line", id=outcome.id, status=status, **facts)
        if outcome.done:
            if self.verbose:
                self.console.print(f"{status}  {outcome.id}")
            return
        reason = failure_reason(outcome)
        if self.verbose or reason not in self.told:
            self.console.print(f"{outcome.id}: {outcome.error}")
        self.told.add(reason)

    def finish(self, outcomes: Sequence[Outcome], report: Place, seconds: float) -> int:
        """Report the run: what is wrong by cause, then the totals. Returns the number of failed lines."""
        from phonanim.dubbing.causes import FAILED, find_causes
        from phonanim.dubbing.report import count_totals, headline

        totals = count_totals(outcomes)
        causes = find_causes(outcomes)
        failed = [cause for cause in causes if cause.check == FAILED]
        for cause in [one for one in failed if len(one.ids) > 1 or one.what not in self.told][:MOST_FAILURES]:
            self.console.print(str(cause))
        for cause in [cause for cause in causes if cause.check != FAILED][:MOST_CAUSES]:
            self.console.print(str(cause))
        counts = {status: self.statuses[status] for status in ("made", "kept")}
        rounded = round(seconds, 3)
        self.console.print_event("end", **totals, **counts, wall_seconds=rounded, report=report)
        self.console.print(headline(totals, f"{counts['made']} made, {counts['kept']} kept"))
        self.console.print(f"read {report}; it has the worst lines first")
        return int(totals["failed"])


def report_dry_run(
    lines: Lines, folder: Place, formats: tuple[str, ...], console: Console, verbose: bool
) -> int:
    """Report what a run would do; returns the number of lines that it could not make."""
    from phonanim.dubbing.causes import find_causes
    from phonanim.dubbing.outcome import Outcome
    from phonanim.dubbing.run import fault_outcomes, plan_run

    kinds: Counter[str] = Counter()
    faults = fault_outcomes(lines)
    places = {line.id: line.place for line in lines.lines}
    for id, what in plan_run(lines, folder, formats):
        if what in ("make", "keep"):
            kinds[what] += 1
            console.print_event("line", id=id, would=what)
            if verbose:
                console.print(f"{what}  {id}")
        else:
            faults.append(Outcome(id, places[id], error=what))
    for fault in faults:
        console.print_event("line", id=fault.id, would="fail", error=fault.error)
        if verbose:
            console.print(f"fail  {fault.id}: {fault.error}")
    for cause in find_causes(faults):
        console.print(str(cause))
    console.print(f"{kinds['make']} to make, {kinds['keep']} to keep, {len(faults)} invalid")
    return len(faults)
