"""Import every folder of recordings below one folder, several at a time.

    python docs/examples/bulk_import.py http://127.0.0.1:8080 TOKEN recordings/

The script skips folders whose name is already on the server, so you can run it again after an
interruption. All recordings get the same palette; labels in a subfolder `labels` are imported.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from pointbrush.client import Client
from pointbrush.errors import PointbrushError

AT_ONCE = 4
TEMPLATE = "semantickitti"
LABELS = "labels"


def main(url: str, token: str, folder: str) -> None:
    """Upload the missing recordings, and print the result of each import."""
    with Client(url, token) as client:
        known = {recording.name for recording in client.sequences()}
        wanted = [path for path in sorted(Path(folder).iterdir()) if path.is_dir()]
        new = [path for path in wanted if path.name not in known]
        print(f"{len(wanted) - len(new)} are there already, {len(new)} to import")

        def load(path: Path) -> str:
            try:
                labels = path / LABELS
                files = [each for each in sorted(path.iterdir()) if each != labels]
                recording = client.import_files(files, name=path.name)
                recording.add_palette(TEMPLATE)
                told = f"{path.name}: {len(recording.frames)} frames as {recording.id}"
                if not labels.is_dir():
                    return told
                found = recording.import_labels([labels])
            except PointbrushError as error:
                return f"{path.name}: {error}"
            return f"{told}, {found['changed']:,} points labelled in {found['matched']} of them"

        with ThreadPoolExecutor(AT_ONCE) as threads:
            for line in threads.map(load, new):
                print(line)


if __name__ == "__main__":
    main(*sys.argv[1:4])
