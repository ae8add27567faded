"""Count the points of each class in all recordings of a server, twenty at a time.

python docs/examples/many_recordings.py http://127.0.0.1:8080 TOKEN
"""

from __future__ import annotations

import asyncio
import sys
from collections import Counter

import numpy as np

from pointbrush.client import AsyncClient, Recording
from pointbrush.client.steps import AsyncLink

AT_ONCE = 20


async def classes_in(recording: Recording[AsyncLink]) -> Counter[str]:
    """Count the points of each class in all frames."""
    names = {label.id: label.category or label.name for label in await recording.labels()}
    found: Counter[str] = Counter()
    for frame in recording.frames:
        labels, counts = np.unique(await frame.annotation(), return_counts=True)
        for label, count in zip(labels.tolist(), counts.tolist(), strict=True):
            if label:
                found[names[label]] += count
    return found


async def main(url: str, token: str) -> None:
    """Print a line for each class."""
    limit = asyncio.Semaphore(AT_ONCE)

    async def counted(recording: Recording[AsyncLink]) -> Counter[str]:
        async with limit:
            return await classes_in(recording)

    async with AsyncClient(url, token) as client:
        recordings = await client.sequences()
        found = await asyncio.gather(*map(counted, recordings))
    total: Counter[str] = sum(found, Counter())
    print(f"{len(recordings)} recordings")
    for name, count in total.most_common():
        print(f"{count:>12,} {name}, in {sum(name in each for each in found)} recordings")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:3]))
