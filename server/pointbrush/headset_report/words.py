"""A headset report as text: a line for each feature, which works, fails or is unknown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple, get_args

from pointbrush.names import spelled_out
from pointbrush.values.headset_checks import (
    HeadsetInput,
    HeadsetLayer,
    HeadsetPictures,
    HeadsetReportFile,
    HeadsetSession,
    Verdict,
)

FEWEST_PICTURES = 60
"""Minimum number of pictures to judge their times."""
MOST_LATE = 0.05
"""Acceptable share of late pictures."""
WHOLE_HAND = 25
"""Number of joints of a tracked hand."""
TASKS = {
    "play": "play the recording",
    "felt": "pulses that are felt",
    "paint": "paint",
    "erase": "erase",
    "label": "switch the label",
    "undo": "undo",
    "step": "step to another frame",
    "go": "go somewhere",
}


class Line(NamedTuple):
    """A feature of a headset, its verdict, and details."""

    verdict: Verdict
    what: str
    detail: str


def report_lines(report: HeadsetReportFile) -> list[str]:
    """Return a report as lines of text, with totals in the last line."""
    lines = list(findings(report))
    count = Counter(line.verdict for line in lines)
    total = ", ".join(f"{verdict} {count[verdict]}" for verdict in get_args(Verdict))
    return [
        spelled_out(text)
        for text in (
            f"pointbrush {report.pointbrush}, {report.made}",
            report.browser,
            *(f"{verdict:<8} {what:<28} {detail}".rstrip() for verdict, what, detail in lines),
            total,
        )
    ]


def findings(report: HeadsetReportFile) -> Iterator[Line]:
    """Yield the verdict on each feature of a report."""
    yield _session(report)
    if report.session:
        yield from _parts(report.session)
    for source in report.inputs:
        yield from _input(source)
    yield _pictures(report.pictures)
    for task in report.tasks:
        detail = "" if task.verdict != "works" else "by buttons" if task.by_buttons else ""
        yield Line(task.verdict, TASKS[task.name], detail)


def _session(report: HeadsetReportFile) -> Line:
    if report.session:
        return Line("works", "session", f"{report.session.mode}, {report.session.blend}")
    return Line("fails" if report.trouble else "unknown", "session", report.trouble)


def _parts(session: HeadsetSession) -> Iterator[Line]:
    for name, granted in ((each.name, each.granted) for each in session.features):
        yield Line("unknown" if granted is None else _is(granted), f"feature {name}", "")
    for space in session.spaces:
        yield Line(_is(space.given), f"reference space {space.name}", "")
    yield Line(_is(session.floor), "height of the floor", "")
    yield from _layer(session.layer)


def _layer(layer: HeadsetLayer) -> Iterator[Line]:
    size = f"{layer.kind}, {layer.width} x {layer.height} for {layer.views} views"
    yield Line(_is(layer.views > 0), "layer", size)
    foveation = "" if layer.foveation is None else f"at {layer.foveation:g}"
    yield Line(_is(layer.foveation is not None), "foveation", foveation)
    near, far = sorted((layer.depth_near, layer.depth_far))
    reversed_ = ", reversed" if layer.depth_near > layer.depth_far else ""
    yield Line(_is(0 < near < far), "depth range", f"{near:g} to {far:g} m{reversed_}")


def _input(source: HeadsetInput) -> Iterator[Line]:
    side = "" if source.side == "none" else f"{source.side} "
    named = source.profiles[0] if source.profiles else source.mode
    what = f"{side}{source.kind or 'unknown input'}"
    yield Line(_is(bool(source.kind)), what, f"{named}, taken for {source.layout or 'nothing'}")
    if source.joints is not None:
        seen = "unknown" if source.joints == 0 else _is(source.joints == WHOLE_HAND)
        yield Line(seen, f"{what}: joints", f"{source.joints} seen")
    if source.buttons > 0:
        seen = "works" if source.pressed else "unknown"
        pressed = f"{_numbers(source.pressed)} of {source.buttons} pressed"
        leaned = f", axes {_numbers(source.leaned)} of {source.axes} leaned"
        yield Line(seen, f"{what}: buttons", pressed + leaned * (source.axes > 0))
    if source.kind == "controller":
        pulses = source.pulses
        yield Line(_is(pulses != "none"), f"{what}: pulses", "" if pulses == "none" else pulses)


def _pictures(pictures: HeadsetPictures | None) -> Line:
    what = "pictures in time"
    if pictures is None or pictures.count < FEWEST_PICTURES:
        return Line("unknown", what, "")
    rate = "no rate told" if pictures.told is None else f"{pictures.told:g}/s told"
    late = pictures.late / pictures.count
    times = f"{pictures.median_ms:.1f} ms, 95 %: {pictures.p95_ms:.1f} ms"
    detail = f"{rate}, {pictures.found:g}/s found, {times}, late {late:.0%} of {pictures.count}"
    return Line(_is(late <= MOST_LATE), what, detail)


def _is(true: bool) -> Verdict:
    return "works" if true else "fails"


def _numbers(values: Sequence[int]) -> str:
    return " ".join(map(str, values)) or "none"
