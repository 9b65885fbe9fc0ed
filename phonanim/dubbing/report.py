"""Reports of a run: report.json for programs, summary.txt and report.html for people."""

from __future__ import annotations

import html
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import prod
from typing import Any

from phonanim.core.pages import fill_page
from phonanim.core.version import __version__
from phonanim.dubbing.causes import Cause, chance_seen, find_causes
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.storage import Place, write

FILES = ("report.json", "report.html", "summary.txt")
WORST = 20  # lines in the summary
CAUSES = 30  # in the summary and on the page

PAGE = "{{head}}\n<body>\n{{body}}\n</body>\n</html>\n"
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: .35rem .6rem; border-bottom: 1px solid #ddd; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
tr.failed td:first-child { border-left: 4px solid #c0392b; }
tr.flagged td:first-child { border-left: 4px solid #e0a030; }
tr.good td:first-child { border-left: 4px solid #4a9a5a; }
@media (prefers-color-scheme: dark) {
  body { background: #181818; color: #ddd; }
  th, td { border-color: #444; }
}
"""


def write_reports(folder: Place, outcomes: Sequence[Outcome], remarks: Sequence[str]) -> None:
    """Write report.json, summary.txt and report.html. The same outcomes give the same bytes."""
    ordered = worst_first(outcomes)
    totals = count_totals(ordered)
    document = {
        "tool": f"phonanim {__version__}",
        "totals": totals,
        "remarks": list(remarks),
        "causes": [_cause(cause) for cause in find_causes(ordered)],
    }
    write(folder / "report.json", _report_json(document, map(_entry, ordered)))
    write(folder / "summary.txt", text_summary(totals, ordered, remarks))
    write(folder / "report.html", html_page(totals, ordered, remarks))


def _report_json(document: Mapping[str, Any], entries: Iterable[Mapping[str, Any]]) -> str:
    """The report as JSON; each line of the run is one line of text, fast to write and easy to compare."""
    head = json.dumps(document, indent=1, ensure_ascii=False).removesuffix("\n}")
    lines = ",\n".join(f"  {json.dumps(entry, ensure_ascii=False)}" for entry in entries)
    return f'{head},\n "lines": [\n{lines}\n ]\n}}\n'


def worst_first(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Failed lines, then flagged ones by how likely a flag is seen, then the others; ties by id."""
    return sorted(outcomes, key=lambda outcome: (outcome.done, -_badness(outcome), outcome.id))


def count_totals(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Counts of a run: lines, done, failed and flagged lines, seconds, frames, flags by check, languages."""
    done = [outcome for outcome in outcomes if outcome.done]
    flags = Counter(flag["check"] for outcome in done for flag in outcome.facts["flags"])
    spoken = [outcome.facts.get("language") for outcome in done]
    languages = Counter(facts["name"] for facts in spoken if facts)
    return {
        "lines": len(outcomes),
        "done": len(done),
        "failed": len(outcomes) - len(done),
        "flagged": sum(bool(outcome.facts["flags"]) for outcome in done),
        "seconds": round(sum(outcome.facts["seconds"] for outcome in done), 3),
        "frames": sum(outcome.facts["frames"] for outcome in done),
        "flags": dict(sorted(flags.items())),
        "languages": dict(sorted(languages.items())),
    }


def headline(totals: dict[str, Any], done: str = "") -> str:
    """The totals in one line; `done` says how lines came to be done, such as "3 made, 2 kept"."""
    flags = ", ".join(f"{name} {count}" for name, count in totals["flags"].items())
    languages = ", ".join(f"{name} {count}" for name, count in totals["languages"].items())
    done = done or f"{totals['done']} done"
    return (
        f"{totals['lines']} lines: {done} ({totals['seconds'] / 60:.1f} min, "
        f"{totals['frames']} frames), {totals['failed']} failed, {totals['flagged']} flagged"
        + (f" ({flags})" if flags else "")
        + (f"; language: {languages}" if languages else "")
    )


def text_summary(totals: dict[str, Any], ordered: Sequence[Outcome], remarks: Sequence[str]) -> str:
    """The run as plain text: the totals, remarks, causes, and the worst flagged lines."""
    bad = [outcome for outcome in ordered if outcome.done and _trouble(outcome)]
    lines = [headline(totals), *remarks, *told_causes(ordered)]
    if bad:
        lines += ["", "the worst lines:", *(f"{outcome.id}: {_trouble(outcome)}" for outcome in bad[:WORST])]
    if len(bad) > WORST:
        lines.append(f"... and {len(bad) - WORST} more: see report.html")
    return "\n".join(lines) + "\n"


def told_causes(outcomes: Sequence[Outcome]) -> list[str]:
    """The first causes of failures and of flags as text; report.json has all."""
    causes = find_causes(outcomes)
    more = [f"... and {len(causes) - CAUSES} more causes: see report.json"] if len(causes) > CAUSES else []
    return [*map(str, causes[:CAUSES]), *more]


def html_page(totals: dict[str, Any], ordered: Sequence[Outcome], remarks: Sequence[str]) -> str:
    """The run as one HTML page without scripts, the worst lines first."""
    rows = "\n".join(map(_row, ordered))
    notes = "".join(f"<p>{html.escape(remark)}</p>\n" for remark in remarks)
    notes += "".join(f'<p class="cause">{html.escape(cause)}</p>\n' for cause in told_causes(ordered))
    body = f"""<h1>phonanim batch</h1>
<p>{html.escape(headline(totals))}</p>
{notes}<table>
<tr><th>line</th><th>seconds</th><th>language</th><th>what to look at</th><th>from</th></tr>
{rows}
</table>"""
    return fill_page(PAGE, {"title": "phonanim batch", "style": STYLE.strip(), "body": body})


def _entry(outcome: Outcome) -> dict[str, Any]:
    """A line of the report: an outcome without what only the ledger needs."""
    return {name: getattr(outcome, name) for name in ("id", "place", "outputs", "facts", "error")}


def _cause(cause: Cause) -> dict[str, Any]:
    named = {"check": cause.check, "cause": cause.what, "lines": len(cause.ids)}
    return {**named, "ids": cause.ids, "example": cause.example}


def _row(outcome: Outcome) -> str:
    kind = "failed" if not outcome.done else "flagged" if outcome.facts["flags"] else "good"
    seconds = f"{outcome.facts['seconds']:.2f}" if outcome.done else ""
    cells = [
        f"<td>{html.escape(outcome.id)}</td>",
        f'<td class="number">{seconds}</td>',
        f"<td>{html.escape(_spoken(outcome))}</td>",
        f"<td>{html.escape(_trouble(outcome))}</td>",
        f"<td>{html.escape(outcome.place)}</td>",
    ]
    return f'<tr class="{kind}">{"".join(cells)}</tr>'


def _spoken(outcome: Outcome) -> str:
    """The language of a line, with how sure it is where the labels decided."""
    facts = outcome.facts.get("language")
    if not facts:
        return ""
    told = {"labels": f" ({facts['certainty']:.0%})", "fallback": f" (there is no {facts.get('asked')})"}
    return str(facts["name"]) + told.get(facts["by"], "")


def _trouble(outcome: Outcome) -> str:
    if not outcome.done:
        return f"failed: {outcome.error}"
    return "; ".join(f"{flag['check']}: {flag['text']}" for flag in outcome.facts["flags"])


def _badness(outcome: Outcome) -> float:
    """How likely a viewer sees one of the flags."""
    return 1.0 - prod(1.0 - chance_seen(flag) for flag in outcome.facts.get("flags", ()))
