"""The tables of benchmarks/audio.py: means of seeds, intervals over clips, and paired tests."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.evaluation.statistics import bootstrap_interval, holm, mean_rows, paired_test

Row = dict[str, Any]  # what one seed of a variant reaches
Seeds = dict[str, Row]  # by seed
Known = dict[str, Seeds]  # by variant


def print_rows(title: str, rows: list[dict[str, str]]) -> None:
    """A table in Markdown."""
    print(f"\n### {title}\n\n| " + " | ".join(rows[0]) + " |\n|---" + "|---:" * (len(rows[0]) - 1) + "|")
    for row in rows:
        print("| " + " | ".join(row.values()) + " |")


def ablation(names: list[str], known: Known) -> list[dict[str, str]]:
    """A row for each variant; the first one is what the others are held against."""
    return [
        {
            **errors,
            "aperture r": f"{mean_of(known[name], 'aperture_r'):.3f}",
            "width r": f"{mean_of(known[name], 'width_r'):.3f}",
        }
        for name, errors in errors_of("variant", names[0], names, known)
    ]


def decoders(base: str, names: list[str], known: Known) -> list[dict[str, str]]:
    """A row for each decoder as Medina (2023) sets Table 3.1, and how far it is from one of them."""
    return [
        {
            **errors,
            "parameters": f"{one_of(known[name])['parameters']:,}",
            "inference, ms": f"{min(row['decoding_ms'] for row in known[name].values()):.1f}",
            "latency, ms": one_of(known[name])["latency_ms"],
        }
        for name, errors in errors_of("decoder", base, names, known)
    ]


def errors_of(title: str, base: str, names: list[str], known: Known) -> Iterator[tuple[str, dict[str, str]]]:
    """Every name with its error, what seeds and clips make of it, and how far it is from `base`."""
    changes = against(base, names, known)
    for name in names:
        yield (
            name,
            {
                title: name,
                "vertex error, mm": error_of(known[name]),
                "seeds": seeds_of(known[name]),
                "95 % interval over clips": interval_of(known[name]),
                f"against {base}": changes[name],
            },
        )


def against(base: str, names: list[str], known: Known) -> dict[str, str]:
    """How far each variant is from another, mm, and p of the clips' differences, after Holm (1979)."""
    others = [name for name in names if name != base]
    own = clip_errors(known[base])
    found = {name: clip_errors(known[name]) for name in others}
    rng = np.random.default_rng(0)
    p = holm([paired_test(mean_rows(own), mean_rows(errors), rng) for errors in found.values()])
    told = {n: f"{(found[n] - own).mean():+.3f}, p {shown(p[i])}" for i, n in enumerate(others)}
    return {base: "", **told}


def shown(p: float) -> str:
    """A p value as the tables show it."""
    return f"{p:.3f}" if p >= 0.001 else "< 0.001"


def clip_errors(seeds: Seeds) -> NDArray[np.float64]:
    """Error of each clip, (clips,) mm, the mean of the seeds."""
    return np.asarray(np.mean([row["errors_mm"] for row in seeds.values()], axis=0))


def seeds_of(seeds: Seeds) -> str:
    """The least and the greatest error of the seeds."""
    errors = [np.mean(row["errors_mm"]) for row in seeds.values()]
    return f"{min(errors):.3f} to {max(errors):.3f}" if len(errors) > 1 else "one"


def interval_of(seeds: Seeds) -> str:
    """Where the mean lies when other clips are drawn."""
    low, high = bootstrap_interval(mean_rows(clip_errors(seeds)), np.random.default_rng(0))
    return f"{low:.3f} to {high:.3f}"


def mean_of(seeds: Seeds, measure: str) -> float:
    """Mean of a number over the seeds."""
    return float(np.mean([row[measure] for row in seeds.values()]))


def one_of(seeds: Seeds) -> Row:
    """The row of any seed, for what no seed changes."""
    return next(iter(seeds.values()))


def error_of(seeds: Seeds) -> str:
    """Mean error of all clips and seeds."""
    return f"{clip_errors(seeds).mean():.3f}"
