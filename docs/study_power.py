"""Print the power table of docs/study-measures.md: ``python docs/study_power.py``."""

from __future__ import annotations

import numpy as np
from scipy import stats

SIZES = (0.3, 0.5, 0.8, 1.0, 1.2)
COUNTS = (8, 12, 16, 20, 24, 32, 42)
RUNS = 4_000
LEVEL = 0.05


def power(participants: int, d: float, *, paired: bool) -> float:
    """Return the share of simulated studies in which a two-sided t-test finds an effect of ``d``.

    ``participants``: of the study; in a study between participants half of them in each group.
    """
    random = np.random.default_rng(1)
    if paired:
        p = stats.ttest_1samp(random.normal(d, 1, (RUNS, participants)), 0, axis=1).pvalue
    else:
        shape = (RUNS, participants // 2)
        p = stats.ttest_ind(random.normal(0, 1, shape), random.normal(d, 1, shape), axis=1).pvalue
    return float(np.mean(p < LEVEL))


def table() -> str:
    """Return the share of simulated studies that find an effect, by size and participants."""
    lines = ["| participants | " + " | ".join(f"d = {size:g}" for size in SIZES) + " |"]
    lines.append("|---" * (len(SIZES) + 1) + "|")
    for count in COUNTS:
        cells = [
            f"{power(count, size, paired=True):.2f} / {power(count, size, paired=False):.2f}"
            for size in SIZES
        ]
        lines.append(f"| {count} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
