"""Print the power table of docs/howto/study.md: ``python docs/study_power.py``."""

from __future__ import annotations

from pointbrush.work.studies.statistics import power

SIZES = (0.3, 0.5, 0.8, 1.0, 1.2)
COUNTS = (8, 12, 16, 20, 24, 32, 42)


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
