"""Metrics of the server, for Prometheus."""

from __future__ import annotations

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    PlatformCollector,
    ProcessCollector,
)

SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)


class Metrics:
    """Counters of one app, in a registry of their own so that several apps can coexist."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        PlatformCollector(registry=self.registry)
        self.requests = Counter(
            "pointbrush_requests", "HTTP requests", ["method", "status"], registry=self.registry
        )
        self.viewers = Gauge("pointbrush_viewers", "open sockets", registry=self.registry)
        self.frames = Counter(
            "pointbrush_frame_messages", "frame messages sent", registry=self.registry
        )
        self.sent = Counter(
            "pointbrush_stream_bytes", "bytes sent over sockets", registry=self.registry
        )
        self.strokes = Histogram(
            "pointbrush_stroke_seconds",
            "from a stroke's end to its durable answer, over sockets",
            buckets=SECONDS,
            registry=self.registry,
        )
