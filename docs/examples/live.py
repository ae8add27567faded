"""Watch a recording, and put frames with doubtful tracking results up for review.

    python docs/examples/live.py http://127.0.0.1:8080 TOKEN juggling

The script runs until you stop it, and continues after a restart of the server.
"""

from __future__ import annotations

import sys

from pointbrush.client import Client, Doubt, Job


def main(url: str, token: str, name: str) -> None:
    """Print the events of a recording, and mark doubtful frames."""
    with Client(url, token) as client:
        recording = client[name]
        names = {label.id: label.name for label in recording.labels()}
        print(f"watching {recording.name}", flush=True)
        for happened in recording.watch(after=recording.manifest.revision):
            if isinstance(happened, Doubt):
                label = names.get(happened.label, str(happened.label))
                note = f"{label}: {happened.state}, is it right?"
                recording.review.put(happened.frame, state="review", note=note)
                print(f"frame {happened.frame}: {label} is {happened.state}", flush=True)
            elif isinstance(happened, Job):
                print(f"{happened.kind}: {happened.state} {happened.progress:.0%}", flush=True)
            else:
                print(f"{happened.author}: {happened.summary}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:4])
