"""What a page's scripts allocate in a picture, by V8's sampling heap profiler: whose, and what.

With a sample for every byte each allocation is seen, with its size.  V8 boxes a fractional number
that leaves a register as 12 bytes on its own; whatever has another size is an object.  Objects are
counted in a browser of their own (``SEPARATE``), where each function stands for itself.
"""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from chromium import Tab

NUMBER_BYTES = 12
"""V8 with compressed pointers: a map and a double."""
SELDOM = 0.05
"""Times a picture; what comes less often is V8's notes on code it sees, and what is made once."""
PLACES = 3


SEPARATE = "--js-flags=--no-turbo-inlining --no-maglev-inlining"
"""For the browser: what V8 inlines it counts for the function that it was inlined into."""
Node = dict[str, Any]


@dataclass
class Share:
    """Bytes a picture that one party allocates."""

    objects: float = 0.0
    numbers: float = 0.0
    places: Counter[str] = field(default_factory=Counter[str])
    """Bytes of objects by function."""
    boxing: Counter[str] = field(default_factory=Counter[str])
    """Bytes of numbers by function."""

    def worst(self, numbers: bool = False) -> str:
        """The functions that allocate most, in words."""
        most = (self.boxing if numbers else self.places).most_common(PLACES)
        return ", ".join(f"{name} {size:.0f}" for name, size in most)


def whose(url: str) -> str:
    """``ours``, ``three``, ``libraries``, or ``emulator`` for what a benchmark brings along."""
    name = url.rpartition("/")[2]
    if "/assets/" not in url:
        return "emulator"
    return next((party for party in ("three", "libraries") if name.startswith(party)), "ours")


def allocations(page: Tab, pictures: str, seconds: float) -> dict[str, Share]:
    """Bytes that each party allocates in a picture; ``pictures`` is an expression counting them."""
    page.call("HeapProfiler.enable")
    page.call(
        "HeapProfiler.startSampling",
        samplingInterval=1,
        includeObjectsCollectedByMajorGC=True,
        includeObjectsCollectedByMinorGC=True,
    )
    before = page.run(pictures)
    time.sleep(seconds)
    count = page.run(pictures) - before
    profile = page.call("HeapProfiler.stopSampling")["profile"]
    functions = callers(profile["head"])
    shares = {party: Share() for party in ("ours", "libraries", "three", "emulator")}
    times = Counter((sample["nodeId"], sample["size"]) for sample in profile["samples"])
    for (node, size), number in times.items():
        place = functions[node]
        share = shares[whose(place["url"])]
        name = f"{place['functionName'] or 'anonymous'}:{place['columnNumber']}"
        if size == NUMBER_BYTES:
            share.numbers += size * number / count
            share.boxing[name] += size * number / count
        elif number >= SELDOM * count:
            share.objects += size * number / count
            share.places[name] += size * number / count
    return shares


def callers(node: Node, caller: Node | None = None) -> dict[int, Node]:
    """By node of V8's profile the function of a script: what is built in counts for its caller."""
    built_in = caller is not None and node["callFrame"]["columnNumber"] < 0
    place = caller if caller is not None and built_in else node["callFrame"]
    found = {node["id"]: place}
    for child in node["children"]:
        found |= callers(child, place)
    return found
