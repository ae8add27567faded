"""Changed recordings and label files, each imported in a process that may die.

python -m tests.formats.mutated_files [--family A,B] [--files 1000] [--seed 1] [--results FILE]

``--results`` keeps each outcome as a line of JSON; a run with the same file continues there.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import struct
import tempfile
import traceback
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from pointbrush.errors import PointbrushError
from pointbrush.formats import Limits
from pointbrush.formats.tables.class_maps import read_map
from pointbrush.jobs.worker import Channel
from pointbrush.sequences import open_sequence
from pointbrush.work.folder_store import FolderTarget
from pointbrush.work.imports.importing import ImportWork
from pointbrush.work.imports.label_reading import LabelRequest, ReadLabelsWork
from pointbrush.work.imports.requests import ImportRequest
from tests.formats.mutation_bases import Base, bases, recording

SPACE = 2 << 30
"""Bytes of address space that a process may take beside those it begins with."""
MOST_RESIDENT = 1 << 30
"""Bytes of memory that a process may use beside those it begins with; no file is larger than a
megabyte."""
SECONDS = 10
"""Processor time of a file."""
WALL_SECONDS = 120
"""Time of a file on a machine with other work."""
HEADER = 600
"""Bytes of a file that are changed more often than those behind them."""
EXTREMES = (0, 1, -1, 127, 255, 2**15 - 1, 2**16 - 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, -(2**31))
WORDS = (
    *("0", "-1", "1", "7", "255", "65536", "2147483648", "4294967295", "99999999999", "1e400"),
    *("9223372036854775808", "9" * 400, "nan", "inf", "-inf", "1e-320", "1e30", "", "null", "[]"),
    *('"x"', "{}", "true", "\x00", "é", "\ud800"),
)
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
READ, REFUSED = "read", "refused"
Change = Callable[[bytes, random.Random], bytes]


class Silent(Channel):
    """A channel that nothing listens to."""

    def __init__(self) -> None:
        pass

    def progress(self, fraction: float, message: str = "") -> None:
        """Take no note."""

    def item(self, value: object) -> None:
        """Take no note."""


# ── changes ──────────────────────────────────────────────────────────────────────────────────


def changed(data: bytes, rng: random.Random) -> bytes:
    """One to four numbers, bytes or spans of a file changed; or it is cut off."""
    made = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randrange(min(len(made), HEADER if rng.random() < 0.5 else len(made)) or 1)
        kind = rng.randrange(8)
        if kind == 0:
            made[at : at + 1] = bytes([rng.randrange(256)])
        elif kind == 1 and made:
            made[min(at, len(made) - 1)] ^= 1 << rng.randrange(8)
        elif kind == 2:
            del made[at : at + rng.choice((1, 2, 4, 20, 1000))]
        elif kind == 3:
            start = rng.randrange(len(made) or 1)
            made[at:at] = made[start : start + rng.choice((1, 4, 20, 1000))]
        elif kind == 4 and rng.random() < 0.4:
            del made[at:]
        elif kind == 5:
            _change_number_in_words(made, at, rng)
        else:
            width, value = rng.choice((1, 2, 4, 4, 8, 8)), rng.choice(EXTREMES)
            order = rng.choice(("little", "little", "big"))
            number = (value % (1 << 8 * width)).to_bytes(width, order)
            made[at : at + width] = rng.choice((number, number, struct.pack("<d", rng.choice(
                (float("nan"), float("inf"), 1e300, 1e-320, -0.0)))))  # fmt: skip
    return bytes(made)


def _change_number_in_words(made: bytearray, at: int, rng: random.Random) -> None:
    """Replace the next number that is written in words."""
    found = NUMBER.search(made, at) or NUMBER.search(made)
    if found is not None:
        word = rng.choice(WORDS).encode("utf-8", "surrogatepass")
        made[found.start() : found.end()] = word


def _in_zip(data: bytes, rng: random.Random) -> bytes:
    """Change a member of an archive, or which members there are."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice(sorted(members))
    if rng.random() < 0.1:
        members[rng.choice(("../out.npy", "/x", name + "x", "label.npy"))] = members.pop(name)
    else:
        members[name] = changed(members[name], rng)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", rng.choice((0, zipfile.ZIP_DEFLATED))) as archive:
        for each, content in members.items():
            archive.writestr(each, content)
    return packed.getvalue()


def _in_pages(data: bytes, rng: random.Random) -> bytes:
    """Change an E57 file and make its checksums fit."""
    from pointbrush.formats.readers.e57 import PAGE, PAYLOAD
    from tests.formats.test_e57 import paged

    logical = b"".join(data[at : at + PAYLOAD] for at in range(0, len(data), PAGE))
    return paged(changed(logical, rng))


def _in_chunks(data: bytes, rng: random.Random) -> bytes:
    """Change the chunks of a PNG, the pixels or their numbers, and make its checksums fit."""
    out, at = data[:8], 8
    while at + 8 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        if kind == b"IDAT" and rng.random() < 0.5:
            content = zlib.compress(changed(zlib.decompress(content), rng), 1)
        elif rng.random() < 0.4:
            content = changed(content, rng)
        crc = zlib.crc32(kind + content)
        out += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", crc)
        at += 12 + length
    return out


def _in_gzip(data: bytes, rng: random.Random) -> bytes:
    return gzip.compress(changed(gzip.decompress(data), rng), 1)


SEALED: dict[str, Change] = {
    ".npz": _in_zip, ".zip": _in_zip, ".e57": _in_pages, ".png": _in_chunks, ".gz": _in_gzip,
}  # fmt: skip
"""Changes of files with checksums, by the end of their names, that leave these right."""


def mutate(files: dict[str, bytes], rng: random.Random) -> dict[str, bytes]:
    """Change one or two files of a folder."""
    made = dict(files)
    for name in rng.choices(sorted(files), k=rng.choice((1, 1, 1, 2))):
        sealed = SEALED.get(Path(name).suffix)
        change = sealed if sealed is not None and rng.random() < 0.8 else changed
        try:
            made[name] = change(made[name], rng)
        except Exception:  # it was changed before
            made[name] = changed(made[name], rng)
    return made


# ── reading ──────────────────────────────────────────────────────────────────────────────────


@dataclass(frozen=True)
class Outcome:
    """What a changed file came to; ``what`` is READ, REFUSED, or the fault."""

    family: str
    seed: int
    base: str
    what: str
    resident: int = 0

    @property
    def sound(self) -> bool:
        """Whether it was read or refused."""
        return self.what in (READ, REFUSED)


def outcome(family: str, all_bases: list[Base], seed: int, folder: Path) -> Outcome:
    """Import the changed file of a seed; 0 is no change of the first base."""
    rng = random.Random(f"{family} {seed}")
    base = rng.choice(all_bases) if seed else all_bases[0]
    files = mutate(dict(base.files), rng) if seed else dict(base.files)

    def work() -> str:
        tempfile.tempdir = str(folder)
        return import_base(base, files, folder)

    try:
        what, resident = _in_a_process(work)
    finally:
        for each in folder.iterdir():
            shutil.rmtree(each, ignore_errors=True) if each.is_dir() else each.unlink()
    if resident > MOST_RESIDENT:
        what = f"{resident >> 20} MB of memory"
    return Outcome(family, seed, base.name, what, resident)


def import_base(base: Base, files: dict[str, bytes], folder: Path) -> str:
    """Write files to a folder, and import them there; returns READ, REFUSED or the fault."""
    for name, content in files.items():
        (folder / "in" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "in" / name).write_bytes(content)
    path = folder / "in" / base.place
    try:
        if base.labels == "classes":
            read_map(path)
        elif base.labels:
            request = LabelRequest(place=path, format=base.format, by_order=base.by_order)
            files = open_sequence(recording(base.labels)).files
            ReadLabelsWork(request, files, Limits())(Silent())
        else:
            ImportWork(ImportRequest((path,)), FolderTarget(folder / "out"), "fuzz")(Silent())
    except PointbrushError:
        return REFUSED
    except Exception as error:
        own = [f for f in traceback.extract_tb(error.__traceback__) if "pointbrush" in f.filename]
        where = f"{Path(own[-1].filename).name}:{own[-1].lineno}" if own else "elsewhere"
        return f"{type(error).__name__} at {where}: {str(error)[:200]}"
    return READ


def _in_a_process(work: Callable[[], str]) -> tuple[str, int]:
    """Run in a fork with limits; returns what it says, or how it died, and the memory it took."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.setsid()
            _limit()
            os.write(writer, b"%d " % _pages(1))
            os.write(writer, work().encode("utf-8", "replace")[:4000])
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        inherited, said = pipe.read().decode().split(" ", 1)
    _, status, usage = os.wait4(child, 0)
    if os.WIFSIGNALED(status):
        said = f"signal {signal.Signals(os.WTERMSIG(status)).name}"
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return said or "nothing", usage.ru_maxrss * 1024 - int(inherited)


def _pages(column: int) -> int:
    """Return the bytes of this process: its address space (0), or its resident memory (1)."""
    return int(Path("/proc/self/statm").read_text().split()[column]) * resource.getpagesize()


def _limit() -> None:
    space = _pages(0) + SPACE
    for kind, soft in (
        (resource.RLIMIT_AS, space),
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_FSIZE, SPACE),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (soft, resource.getrlimit(kind)[1]))
    signal.alarm(WALL_SECONDS)


def warm() -> None:
    """Load what reading loads late, so that each fork has it."""
    import lz4.frame  # noqa: F401
    import zstandard  # noqa: F401

    Image.init()
    for kind in ("points", "boxes"):
        recording(kind)


def outcomes(
    families: dict[str, list[Base]], seeds: Iterable[int], known: set[tuple[str, int]]
) -> Iterator[Outcome]:
    """Import a file of each family for each seed, but for those known."""
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            for family, found in families.items():
                if (family, seed) not in known:
                    yield outcome(family, found, seed, Path(folder))


def main() -> int:
    """Run, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m tests.formats.mutated_files")
    parser.add_argument("--family", default="", help="names, with commas between them")
    parser.add_argument("--files", type=int, default=1000, help="of each family")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--results", type=Path)
    given = parser.parse_args()
    warm()
    families = bases()
    wanted = [name for name in given.family.split(",") if name] or list(families)
    kept = given.results
    lines = kept.read_text().splitlines() if kept and kept.exists() else []
    done = [Outcome(**json.loads(line)) for line in lines]
    seeds = range(given.seed, given.seed + given.files)
    known = {(each.family, each.seed) for each in done}
    chosen = {name: families[name] for name in wanted}
    for each in outcomes(chosen, seeds, known):
        done.append(each)
        if kept:
            with kept.open("a") as file:
                file.write(json.dumps(each.__dict__) + "\n")
        if not each.sound:
            print(f"{each.family} {each.seed} ({each.base}): {each.what}", flush=True)
    print("| family | bases | files | read | refused | faults |\n|---|---|---|---|---|---|")
    for name in wanted:
        counts = Counter(
            each.what if each.sound else "fault"
            for each in done
            if each.family == name and each.seed in seeds
        )
        cells = (counts.total(), counts[READ], counts[REFUSED], counts["fault"])
        print(f"| {name} | {len(families[name])} | {' | '.join(map(str, cells))} |")
    return int(any(not each.sound for each in done if each.seed in seeds))


if __name__ == "__main__":
    raise SystemExit(main())
