"""Metrics of the server, for Prometheus."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    PlatformCollector,
    ProcessCollector,
)
from prometheus_client.core import GaugeMetricFamily, Metric

from pointbrush.database.job import ENDED, Job

SECONDS = (0.001, 0.002, 0.003, 0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.5, 1.0, 5.0)
LONG_SECONDS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0)


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
        self.skipped = Counter(
            "pointbrush_frames_skipped",
            "frames of playing viewers that were not sent, since a newer one was due",
            registry=self.registry,
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
        self.database = Histogram(
            "pointbrush_database_seconds",
            "transactions of the label database, by what they do: read or write",
            ["kind"],
            buckets=SECONDS,
            registry=self.registry,
        )
        self.jobs = Histogram(
            "pointbrush_job_seconds",
            "from a job's submission to its end, on this server",
            ["kind", "state"],
            buckets=LONG_SECONDS,
            registry=self.registry,
        )

    def transaction(self, kind: str, seconds: float) -> None:
        """Count a transaction of the database."""
        self.database.labels(kind).observe(seconds)

    def job(self, job: Job) -> None:
        """Count a job that has ended."""
        if job.state in ENDED:
            self.jobs.labels(job.kind, job.state).observe(max(0.0, time.time() - job.created))

    def watch_backups(self, newest_at: Callable[[], float], failures: Callable[[], float]) -> None:
        """Report the time of the newest backup and the number of failures with the metrics."""
        for name, text, ask in (
            ("timestamp_seconds", "time of the newest backup, since 1970; 0 for none", newest_at),
            ("failures", "backups that this server could not make", failures),
        ):
            gauge = Gauge(f"pointbrush_backup_{name}", text, registry=self.registry)
            gauge.set_function(ask)

    def watch_queues(self, lengths: Callable[[], Mapping[str, int]]) -> None:
        """Call ``lengths`` for the length of each queue when the metrics are read."""
        self.registry.register(_Queues(lengths))


class _Queues:
    """Collector of the lengths of queues, measured when the metrics are read."""

    def __init__(self, lengths: Callable[[], Mapping[str, int]]) -> None:
        self._lengths = lengths

    def describe(self) -> Iterable[Metric]:
        """Return the metric without values, so that registration does not measure queues."""
        return [self._family()]

    def collect(self) -> Iterable[Metric]:
        """Return the metric with its values."""
        family = self._family()
        for queue, length in self._lengths().items():
            family.add_metric([queue], length)
        return [family]

    @staticmethod
    def _family() -> GaugeMetricFamily:
        return GaugeMetricFamily(
            "pointbrush_queue_length", "what waits or runs, by queue", labels=["queue"]
        )
