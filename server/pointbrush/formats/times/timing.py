"""Times of frames: from a timestamp file, from file names, and the rate they imply."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from decimal import Decimal
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.formats.times.time_order import TimeOrder, order_by_time, read_fractions
from pointbrush.names import composed

TIME_FILES = ("timestamps.txt", "times.txt", "timestamp.txt", "timestamps.csv", "times.csv")
# Seconds since 1970 of plausible recordings: 1990 to 2100.
EARLIEST, LATEST = 631_152_000, 4_102_444_800
ASSUMED = "assumed"
"""Source of a rate that no file states."""
CAMERA_FPS = 30.0
SPINNING_FPS = 10.0
"""Turns per second of the scanners of KITTI, SemanticKITTI, Argoverse and most others."""
SURVEY_FORMATS, SURVEY_FPS = ("las", "e57", "ptx"), 1.0
"""Formats of scans that are hardly ever frames of a video."""
SPINNING_FORMATS = ("kitti", "bin", "nuscenes", "feather")
SPINNING_FOLDERS = ("velodyne", "velodyne_points", "lidar", "lidar_top", "ouster", "hesai")
NANOSECONDS = (18, 19)
"""Numbers of digits of a name that can only be a time."""
_DATE = re.compile(r"(?<!\d)((?:19|20)\d{6})[T_\- ]?(\d{6})(?:[._](\d{1,9}))?(?!\d)")
_CLOCK = re.compile(
    r"(?<!\d)((?:19|20)\d\d)-(\d\d)-(\d\d)[T _]+(\d\d)[:_-](\d\d)[:_-](\d\d)"
    r"(?:[.,_](\d{1,9}))?(?!\d)"
)
_DECIMAL = re.compile(
    r"(?P<before>.*?)(?P<sign>(?<![0-9a-zA-Z])-)?(?P<whole>\d+)(?P<fraction>\.\d+)?", re.ASCII
)
_EPOCH = re.compile(
    r"(?<!\d)(\d{10})(?:[._](\d{1,9})|-(\d{3,9}))?(?!\d)|(?<!\d)(\d{13,19})(?!\d)", re.ASCII
)
BY_NUMBER = "by number in the file names"


def natural_key(path: Path) -> tuple[tuple[int, str | int], ...]:
    """Sort key that puts ``frame2`` before ``frame10``."""
    return tuple(
        (0, int(part)) if part.isdigit() else (1, part.lower())
        for part in re.findall(r"\d{1,4000}|\D+", str(path), re.ASCII)
    )


def in_order(paths: Sequence[Path]) -> list[Path]:
    """Return files in the order of the numbers in their names.

    Names that differ only in one decimal (``0.05``, ``0.1``; ``scan_-0.5``) are ordered by its
    value, others by ``natural_key``.
    """
    natural = sorted(paths, key=natural_key)
    decimals = [_DECIMAL.fullmatch(path.stem) for path in natural]
    matched = [match for match in decimals if match is not None]
    alike = len({(path.parent, path.suffix) for path in natural}) == 1
    fractions = any(match["fraction"] or match["sign"] for match in matched)
    if not alike or len(matched) != len(natural) or not fractions:
        return natural
    if len({match["before"] for match in matched}) != 1:
        return natural
    if any(match["sign"] for match in matched):
        values = [Decimal(f"{m['sign'] or ''}{m['whole']}{m['fraction'] or ''}") for m in matched]
    else:
        parts = [(match["fraction"] or "")[1:] for match in matched]
        values = read_fractions([match["whole"] for match in matched], parts)
    return [natural[i] for i in sorted(range(len(natural)), key=values.__getitem__)]


def time_in_name(name: str) -> float | None:
    """Seconds since 1970 in a file name: ``20121214T142255.814212``, or an epoch in s, ms … ns."""
    if match := _DATE.search(name):
        try:
            moment = datetime.strptime("".join(match.group(1, 2)), "%Y%m%d%H%M%S")
        except ValueError:
            return None
        return moment.replace(tzinfo=UTC).timestamp() + float(f"0.{match.group(3) or 0}")
    if match := _CLOCK.search(name):
        try:
            moment = datetime(*(int(part) for part in match.groups()[:6]), tzinfo=UTC)  # type: ignore[misc,arg-type]
        except ValueError:
            return None
        return moment.timestamp() + float(f"0.{match.group(7) or 0}")
    if len(name) in NANOSECONDS and name.isascii() and name.isdigit():
        return int(name) / 1e9  # of a clock with any epoch
    if match := _EPOCH.search(name):
        seconds = float(".".join(_parts(match)))
        return seconds if EARLIEST < seconds < LATEST else None
    return None


def _time_match(name: str) -> re.Match[str] | None:
    return _DATE.search(name) or _CLOCK.search(name) or _EPOCH.search(name)


def _parts(match: re.Match[str]) -> tuple[str, str]:
    """Return whole seconds and their fraction, "0" without one, of an epoch in a name."""
    whole, fraction, counted, long = match.groups()
    return (whole, fraction or counted or "0") if whole else (long[:10], long[10:])


def seconds_in_names(names: Sequence[str]) -> list[float | None]:
    """Return the time in each name as ``time_in_name`` does, fractions as ``read_fractions``."""
    times = [time_in_name(name) for name in names]
    matches = enumerate(map(_time_match, names))
    parts = {place: _parts(match) for place, match in matches if match and match.re is _EPOCH}
    if len({len(part) for _, part in parts.values()}) > 1:
        wholes, fractions = zip(*parts.values(), strict=True)
        for place, value in zip(parts, read_fractions(wholes, fractions), strict=True):
            times[place] = float(value) if EARLIEST < value < LATEST else None
    return times


def times_in_names(paths: Sequence[Path]) -> list[float] | None:
    """Return the time in each file's name, or None unless every name has one and most differ."""
    times = seconds_in_names([path.stem for path in paths])
    known = [time for time in times if time is not None]
    return known if len(known) == len(times) < 2 * len(set(known)) else None


def find_time_file(folder: Path) -> Path | None:
    """The timestamp file of a folder of frames, in it or beside it."""
    for place in (folder, folder.parent):
        for name in TIME_FILES:
            if (place / name).is_file():
                return place / name
    return None


def times_of(files: Sequence[Path], folder: Path) -> list[float] | None:
    """Seconds for each of ``files`` of a folder, by its timestamp file or else their names.

    Raises BadInputError for a timestamp file that does not fit.
    """
    time_file = find_time_file(folder)
    if time_file is not None:
        return read_times(time_file, [path.name for path in files])
    return times_in_names(files)


def order_of(files: Sequence[Path], folder: Path, times: Sequence[float] | None) -> TimeOrder:
    """Return the order of files of a folder by their ``times``, as ``order_by_time``."""
    if times is None:
        return TimeOrder(range(len(files)), BY_NUMBER)
    time_file = find_time_file(folder)
    source = time_file.name if time_file else "the times in the file names"
    stems = [path.stem for path in files]
    if not time_file:
        found = map(_time_match, stems)
        stems = [s.replace(m[0], "", 1) if m else s for s, m in zip(stems, found, strict=True)]
    numbered = len({re.sub(r"\d+", "", stem) for stem in stems}) == 1
    distinct = len(set(stems)) == len(stems)
    return order_by_time(times, source, BY_NUMBER, numbered=numbered if distinct else None)


def read_times(path: Path, names: Sequence[str]) -> list[float]:
    """Seconds for each of ``names`` from a timestamp file.

    Lines are ``time`` in the order of the names, or ``time name`` or ``name time`` in any order;
    a time is a number in seconds (integers of 13 to 19 digits: ms to ns) or an ISO date.
    Raises BadInputError for other lines, a name without a time, or another number of lines.
    """
    bare: list[float] = []
    by_name: dict[str, float] = {}
    known = {composed(name): name for name in names}
    known |= {Path(name).stem: seconds for name, seconds in known.items()}
    for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").replace("\t", " ").split()
        if not words or words[0].startswith("#"):
            continue
        time, name = _parse(words, known)
        if time is None:
            if number == 1:
                continue  # a header
            raise BadInputError(f"{path.name} line {number}: expected a time, got another line")
        if name is not None:
            by_name[name] = time
        bare.append(time)
    if by_name:
        absent = [name for name in names if name not in by_name]
        if absent:
            raise BadInputError(f"{path.name}: expected a time for '{absent[0]}', got none")
        return [by_name[name] for name in names]
    return [bare[line] for line in lines_of(path.name, "times", len(bare), names)]


def lines_of(where: str, what: str, lines: int, names: Sequence[str]) -> Sequence[int]:
    """Return the line of each file: one each in order, or by the numbers that name them.

    A part of a recording (``000100.bin`` …) may have the lists of the whole.  Raises BadInputError
    if neither fits.
    """
    if lines == len(names):
        return range(lines)
    stems = [Path(name).stem for name in names]
    if all(stem.isascii() and stem.isdigit() and int(stem[:18]) < lines for stem in stems):
        return [int(stem) for stem in stems]
    raise BadInputError(f"{where}: expected {len(names)} {what}, one per frame, got {lines}")


def _parse(words: list[str], known: dict[str, str]) -> tuple[float | None, str | None]:
    for i, word in enumerate(words if len(words) > 1 else []):
        base = composed(word.replace("\\", "/").rsplit("/", 1)[-1])
        if base in known:
            return _time(words[:i] + words[i + 1 :]), known[base]
    return _time(words), None


def _time(words: list[str]) -> float | None:
    if not words:
        return None
    try:
        value = float(words[0])
    except ValueError:
        return _iso(" ".join(words[:2]))
    if words[0].isdigit() and 13 <= len(words[0]) <= 19:
        value /= 10.0 ** (len(words[0]) - 10)
    return value if np.isfinite(value) else None


def seconds_of(word: str) -> float | None:
    """Seconds of a number (integers of 13 to 19 digits: ms to ns) or an ISO date, else None."""
    return _time([word])


def _iso(text: str) -> float | None:
    # Python reads at most microseconds; KITTI writes nanoseconds.
    try:
        moment = datetime.fromisoformat(re.sub(r"(\.\d{6})\d+", r"\1", text))
    except ValueError:
        return None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def rate_of(times: Sequence[float] | None) -> float | None:
    """Return the frames per second of times in the order of the frames, or None if unclear.

    The rate is from the mean of similar steps, or else from the median, which ignores pauses.
    Equal and decreasing times are no steps, and may be at most half of all.
    """
    if times is None or len(times) < 2:
        return None
    steps = np.diff(np.asarray(times, np.float64))
    forward = steps[steps > 0]
    if not 0 < len(steps) <= 2 * len(forward):
        return None
    step = float(np.median(forward))
    if float(forward.max()) < 1.5 * step:
        step = float(forward.mean())
    if not 0.001 <= step <= 100:
        return None
    rate = 1 / step
    # Jitter of a clock and rounded times are not a rate: 9.9987 is 10.
    return float(round(rate)) if abs(rate - round(rate)) < 0.005 * rate else round(rate, 3)


def assumed_rate(format: str, folder: Path) -> float:
    """Return the default of frames per second: the rate of spinning scanners, one scan a second for
    scanners on a tripod or an aircraft, or the rate of depth cameras."""
    if format in SURVEY_FORMATS:
        return SURVEY_FPS
    spins = format in SPINNING_FORMATS or folder.name.lower() in SPINNING_FOLDERS
    return SPINNING_FPS if spins else CAMERA_FPS


def stated_rate(folder: Path) -> float | None:
    """The number ``fps`` or ``rate_hz`` in a ``meta.json`` in the folder or beside it, or None."""
    for place in (folder, folder.parent):
        try:
            meta = parse_json((place / "meta.json").read_text("utf-8"))
        except (OSError, ValueError):
            continue
        for key in ("fps", "rate_hz"):
            rate = meta.get(key) if isinstance(meta, dict) else None
            if isinstance(rate, int | float) and not isinstance(rate, bool) and 0 < rate <= 1000:
                return float(rate)
    return None
