"""viser's side of bench_page.py: show frame after frame of the same recording, for ever."""

from __future__ import annotations

import sys
import time
from contextlib import redirect_stdout
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import viser
from bench_streaming import kinect

from tests.ports import free_port


def main() -> None:
    pause = 1 / float(sys.argv[1])
    frames = [kinect(seed) for seed in range(9)]
    port = free_port()
    # Its banner is not for whoever reads our output.
    with redirect_stdout(sys.stderr):
        server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
    print(f"viser ready at http://127.0.0.1:{port}", flush=True)
    number = 0
    while True:
        frame = frames[number % len(frames)]
        assert frame.rgb is not None
        server.scene.add_point_cloud("/frame", frame.xyz, frame.rgb, point_size=0.01)
        server.flush()
        number += 1
        time.sleep(pause)


if __name__ == "__main__":
    main()
