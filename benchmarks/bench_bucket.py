"""Frames out of object storage: the first one, and playing, with the cache cold and warm.

python benchmarks/bench_bucket.py [--milliseconds 30]

The store is moto's S3 server in a process of its own, on loopback: it stands for the requests that
are made, not for a network or a real store.  ``--milliseconds`` is added to each of them.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import boto3
import s3fs

sys.path.insert(0, str(Path(__file__).parent.parent))

from pointbrush.sequences import RecordingInfo, Sequence, import_frames, open_sequence
from pointbrush.sequences.storage.bucket import Bucket
from pointbrush.sequences.storage.bucket_files import BucketFiles
from pointbrush.sequences.storage.file_cache import FileCache
from tests.serving import surface

FRAMES, POINTS, FPS = 60, 54_272, 30
URL = "s3://bench/recordings"
SERVER = """
from moto.server import ThreadedMotoServer
import logging, sys
logging.getLogger("werkzeug").setLevel(logging.ERROR)
server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
server.start()
print(server.get_host_and_port()[1], flush=True)
sys.stdin.read()
"""


@contextmanager
def store(milliseconds: float) -> Iterator[None]:
    """Run an S3 server with a bucket; each request takes so much longer."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdin is not None
    assert process.stdout is not None
    os.environ |= {
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{int(process.stdout.readline())}",
        "AWS_ACCESS_KEY_ID": "somebody",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    asked = s3fs.S3FileSystem._call_s3

    async def slowly(*args: Any, **options: Any) -> Any:
        await asyncio.sleep(milliseconds / 1000)
        return await asked(*args, **options)

    s3fs.S3FileSystem._call_s3 = slowly
    try:
        boto3.client("s3").create_bucket(Bucket="bench")
        yield
    finally:
        process.stdin.close()
        process.wait()


def first_frame(recording: Sequence) -> float:
    """Return the time from an open recording to a frame's bytes for the wire, milliseconds."""
    started = time.perf_counter()
    frame = recording[0]
    bytes(frame.wire(0, len(frame.chunks)))
    return 1000 * (time.perf_counter() - started)


def play(recording: Sequence) -> tuple[int, float, float]:
    """Return how many frames came late at ``FPS``, the longest wait, CPU time a frame (both ms)."""
    first_frame(recording)
    used = time.process_time()
    started, late, longest = time.perf_counter(), 0, 0.0
    for index in range(1, len(recording)):
        due = started + index / FPS
        time.sleep(max(0.0, due - time.perf_counter()))
        frame = recording[index]
        bytes(frame.wire(0, len(frame.chunks)))
        wait = 1000 * (time.perf_counter() - due)
        late, longest = late + (wait > 1000 / FPS), max(longest, wait)
    used = time.process_time() - used
    return late, longest, 1000 * used / (len(recording) - 1)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--milliseconds", type=float, default=0.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, store(given.milliseconds):
        folder = Path(name)
        frames = (surface(POINTS, index) for index in range(FRAMES))
        import_frames(frames, folder / "wall", RecordingInfo("wall", "wall", FPS))
        local = open_sequence(folder / "wall")
        nbytes = sum(file.stat().st_size for file in local.path.rglob("*") if file.is_file())
        print(f"{FRAMES} frames of {POINTS:,} points, {nbytes / FRAMES / 1e6:.2f} MB each")
        print(f"folder: first frame {first_frame(local):.1f} ms, late {play(local)[0]}")
        started = time.perf_counter()
        sent = Bucket(URL, FileCache(folder / "sent", 1 << 40))
        sent.publish(local.path, "wall")
        print(f"sent in {time.perf_counter() - started:.1f} s")

        def opened(cache: str) -> Sequence:
            return open_sequence(
                BucketFiles(Bucket(URL, FileCache(folder / cache, 1 << 40)), "wall")
            )

        cold = [first_frame(opened(f"cold {attempt}")) for attempt in range(5)]
        warm = [first_frame(opened("cold 0")) for _ in range(5)]
        print(f"bucket: first frame {median(cold):.0f} ms cold, {median(warm):.0f} ms warm")
        for cache in ("playing", "playing"):
            late, longest, used = play(opened(cache))
            print(
                f"playing: {late} of {FRAMES - 1} frames late, longest wait {longest:.0f} ms,",
                end="",
            )
            print(f" {used:.2f} ms of processor time a frame")


if __name__ == "__main__":
    main()
