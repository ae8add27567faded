"""The first minutes: `make demo` to "ready", the first object click, the first run of tracking.

python benchmarks/bench_first_hour.py [CHECKOUT]

Makes a copy of the files of a checkout, without compiled loops, sample and page, and uses the
installed packages of this environment, so that downloads do not count.  The times after "ready"
begin there: a client clicks on a pin, paints it and tracks it, as fast as it is answered.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.object_clicks import middle
from pointbrush.client import Client, Frame
from pointbrush.errors import ConflictError
from pointbrush.samples import generate

CHECKOUT = Path(__file__).parent.parent
INSTALLED = ("venv", "nodejs", "runtime", "node")
"""Steps of the Makefile that download packages."""
FRAMES = 90
PATIENCE = 600.0
"""Seconds after which a step counts as failed."""
SECONDS_LEFT = re.compile(r"\d+ s\b")


@dataclass(frozen=True)
class Target:
    """A pin of the sample's first frame: its name, its points, a ray (origin, direction) at it."""

    name: str
    points: NDArray[np.int64]
    origin: NDArray[np.float64]
    direction: NDArray[np.float64]


def target() -> Target:
    """Return the pin of the most points."""
    recording = generate("juggling", 0, FRAMES)
    made, truth = recording.frame(0), recording.truth[0]
    pins = [label for label in recording.labels if label.category == "pin"]
    chosen = max(pins, key=lambda label: int(np.count_nonzero(truth == label.id)))
    assert made.viewpoint is not None
    at = middle(made.xyz, truth == chosen.id)
    way = at - made.viewpoint
    points = np.flatnonzero(truth == chosen.id)
    return Target(chosen.name, points, made.viewpoint, way / np.linalg.norm(way))


def copy_files(checkout: Path, place: Path) -> None:
    """Copy the files of a checkout that git knows or would, linking the page's packages."""
    command = ["git", "-C", str(checkout), "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(command, capture_output=True, check=True, text=True)
    for name in filter(None, listed.stdout.split("\0")):
        if (checkout / name).is_file():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(checkout / name, place / name)
    modules = place / "webxr_client/node_modules"
    if not modules.exists():
        modules.symlink_to((CHECKOUT / "webxr_client/node_modules").resolve())
    (place / ".stamps").mkdir()
    for step in INSTALLED:
        (place / ".stamps" / step).touch()


def demo(place: Path) -> subprocess.Popen[str]:
    """Start ``make demo`` in a copy, in a session of its own."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(place / "server"),
        "POINTBRUSH_WORKSPACE": str(place / "workspace"),
        "POINTBRUSH_PORT": "0",
    }
    environment.pop("NUMBA_CACHE_DIR", None)
    return subprocess.Popen(
        ["make", "demo", f"VENV={sys.prefix}"],
        cwd=place,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def ready_at(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Wait until the server is ready; return its address and its token."""
    assert process.stdout is not None
    for line in process.stdout:
        if found := re.search(r"ready at (\S+)/\?token=(\S+)", line):
            return found[1], found[2]
    raise AssertionError("make demo ended before the server was ready")


def processor_seconds(session: int) -> float:
    """Processor seconds of the processes of a session, with ended children they waited for."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            if int(fields[3]) == session:
                ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds, looking ten times a second."""
    end = time.perf_counter() + PATIENCE
    while not holds():
        assert time.perf_counter() < end, f"no answer within {PATIENCE:.0f} s"
        time.sleep(0.1)


def drive(client: Client, pin: Target, note: Callable[[str], None]) -> None:
    """Click on the pin, paint it and track it; ``note`` each event."""
    recording = client["juggling"]
    frame, label = recording.frames[0], recording.label(pin.name).id
    take(frame, label, pin)
    note("the first object click is answered (goal 5 s)")
    until(lambda: paint(frame, label, pin))
    note("the pin is painted")
    job = recording.start_tracking([label], 0, FRAMES - 1).id
    until(lambda: told(client, job, SECONDS_LEFT))
    note("Track shows the seconds that remain, or a frame (goal 10 s)")
    until(lambda: told(client, job, re.compile(r"frame [1-9]")))
    note("the first tracked frame (goal 60 s)")
    until(lambda: client.job(job).state == "done")
    note("all frames are tracked")


def take(frame: Frame, label: int, pin: Target) -> str:
    """Ask for the objects under the pin's ray; return the id of the one most like the pin."""
    answered = frame.objects(pin.origin[None], pin.direction[None], label=label)
    return max(answered, key=lambda each: len(np.intersect1d(each.numbers, pin.points))).id


def paint(frame: Frame, label: int, pin: Target) -> bool:
    """Paint the pin by a click; False when the frame was prepared meanwhile, as for a page."""
    chosen = take(frame, label, pin)
    with suppress(ConflictError):
        frame.stroke(
            label=label,
            shape="object",
            samples=pin.origin[None],
            directions=pin.direction[None],
            candidate=chosen,
        )
        return True
    return False


def told(client: Client, job: str, pattern: re.Pattern[str]) -> bool:
    """Return whether a job's message fits a pattern, or the job tracks frames already."""
    found = client.job(job)
    assert found.state in ("queued", "running", "done"), found
    return found.progress > 0.02 or pattern.search(found.message) is not None


def show(event: str, seconds: float, cpu: float) -> None:
    """Print an event with its time and the processor time until then."""
    print(f"  {event:60} {seconds:6.1f} s {cpu:6.1f} s of processors", flush=True)


def main() -> None:
    """Print the times."""
    checkout = Path(sys.argv[1]) if len(sys.argv) > 1 else CHECKOUT
    pin = target()
    with tempfile.TemporaryDirectory() as folder:
        copy_files(checkout.resolve(), Path(folder))
        begun = time.perf_counter()
        process = demo(Path(folder))
        try:
            address, token = ready_at(process)
            ready = time.perf_counter()
            spent = processor_seconds(process.pid)

            def note(event: str) -> None:
                cpu = processor_seconds(process.pid) - spent
                show(event, time.perf_counter() - ready, cpu)

            print("the first minutes, from a checkout with its packages")
            show("make demo to ready (goal 95 s with downloads)", ready - begun, spent)
            print("from ready to")
            drive(Client(address, token), pin, note)
        finally:
            os.killpg(process.pid, signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                process.wait(30)
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


if __name__ == "__main__":
    main()
