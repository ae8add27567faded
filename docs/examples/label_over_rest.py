"""Label a recording from a script: import, paint, track, undo, export.

    python docs/examples/label_over_rest.py http://127.0.0.1:8080 TOKEN PATH

PATH is a file or folder under the server's allowed import roots.
"""

from __future__ import annotations

import io
import sys
import time
import uuid

import httpx
import numpy as np


def wait(api: httpx.Client, job: dict[str, object]) -> dict[str, object]:
    """Poll a job until it has ended; returns its result."""
    while job["state"] in ("queued", "running"):
        time.sleep(0.2)
        job = api.get(f"/jobs/{job['id']}").raise_for_status().json()
    if job["state"] != "done":
        raise SystemExit(f"{job['kind']} {job['state']}: {job['error']}")
    return job["result"]  # type: ignore[return-value]


def load(api: httpx.Client, path: str) -> np.ndarray:
    """Return the array of a .npy answer."""
    return np.load(io.BytesIO(api.get(path).raise_for_status().content))


def main(url: str, token: str, path: str) -> None:
    """Import, paint, track, undo, read and export once."""
    headers = {"Authorization": f"Bearer {token}"}
    with httpx.Client(base_url=f"{url}/api/v1", headers=headers, timeout=60) as api:
        # 1. Import a recording.
        job = api.post("/sequences", json={"path": path}).raise_for_status().json()
        sequence = f"/sequences/{wait(api, job)['sequence']}"
        frames = api.get(sequence).raise_for_status().json()["frames"]

        # 2. Add a label and paint a 15 cm ball round a point of the first frame.
        label = api.post(f"{sequence}/labels", json={"name": "object"}).raise_for_status().json()
        points = load(api, f"{sequence}/frames/0/points")
        center = points["xyz"][len(points) // 2]
        stroke = {
            "id": str(uuid.uuid4()),
            "label": label["id"],
            "tool": "paint",
            "shape": "sphere",
            "radius": 0.15,
            "samples": [{"origin": center.tolist(), "direction": [0, 0, 1], "t": 0}],
        }
        edit = api.post(f"{sequence}/frames/0/strokes", json=stroke).raise_for_status().json()
        print(f"painted {edit['changed']} points")

        # 3. Track the label to the last frame, and print the confidence of each frame.
        if frames > 1:
            run = {"labels": [label["id"]], "start": 0, "stop": frames - 1, "method": "icp"}
            wait(api, api.post(f"{sequence}/tracking", json=run).raise_for_status().json())
            for track in api.get(f"{sequence}/tracks").raise_for_status().json():
                print(f"frame {track['frame']}: {track['state']}, {track['confidence']:.2f}")
            # The whole run is one edit: one undo reverts it, one redo restores it.
            api.post(f"{sequence}/undo").raise_for_status()
            api.post(f"{sequence}/redo").raise_for_status()

        # 4. Read an annotation as an array in source order; export a zip.
        annotation = load(api, f"{sequence}/frames/{frames - 1}/annotation")
        print(f"last frame: {int((annotation == label['id']).sum())} points of the object")
        export = api.get(f"{sequence}/export", params={"format": "npz"}).raise_for_status()
        print(f"export: {len(export.content)} bytes")


if __name__ == "__main__":
    main(*sys.argv[1:4])
