"""What an operator sees of a running server: its log and its metrics."""

from __future__ import annotations

import json
import logging
import re
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from prometheus_client import CollectorRegistry
from waiting import eventually

from pointbrush.database.job import Job
from pointbrush.streaming.metrics import Metrics
from pointbrush.web.logs import JsonFormatter
from tests.faults.clients import SocketTalk
from tests.faults.server import TOKEN, ServerProcess, running
from tests.serving import add_sequence, settings_in

DEPLOY = Path(__file__).parents[2] / "deploy"
DASHBOARD, ALERTS = DEPLOY / "grafana.json", DEPLOY / "alerts.yml"
SUFFIXES = {
    "counter": ("_total",), "gauge": ("",), "histogram": ("_bucket", "_count", "_sum"),
}  # fmt: skip


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "ball", frames=2, points=3_000)
    asked = {"POINTBRUSH_LOG_FORMAT": "json", "POINTBRUSH_NEW_LABELS": "1"}
    with running(settings.workspace, **asked) as started:
        yield started


def test_the_log_names_requests_edits_and_jobs_and_no_token(server: ServerProcess) -> None:
    edit = str(uuid.uuid4())
    stroke = {"id": edit, "label": 1, "radius": 0.4, "samples": [{"origin": [0, 0, 3]}]}
    with server.api() as api, SocketTalk(server.url, TOKEN, "ann"):
        api.post("/sequences/ball/labels", json={"name": "pin"}).raise_for_status()
        path = "/sequences/ball/frames/0/strokes"
        answer = api.post(path, json=stroke, headers={"X-Request-Id": "from-the-proxy"})
        assert answer.headers["x-request-id"] == "from-the-proxy"
        api.get(f"/jobs?token={TOKEN}")
        run = {"start": 0, "stop": 1, "method": "icp"}
        job = api.post("/sequences/ball/tracking", json=run).json()["id"]
        eventually(lambda: api.get(f"/jobs/{job}").json()["state"] == "done", every=0.2)
        for told in (
            'pointbrush_database_seconds_count{kind="write"}',
            'pointbrush_job_seconds_count{kind="tracking",state="done"} 1.0',
            'pointbrush_queue_length{queue="jobs_running"} 0.0',
            "pointbrush_viewers 1.0",
        ):
            eventually(lambda wanted=told: wanted in api.get("/metrics").text, every=0.2)
    assert server.stop() == 0
    lines = [json.loads(line) for line in server.stderr.splitlines()]
    by_the_proxy = [line for line in lines if line.get("request") == "from-the-proxy"]
    made, asked = by_the_proxy
    assert made["edit"] == edit
    assert (asked["method"], asked["status"]) == ("POST", 200)
    assert asked["path"].endswith(path)
    assert {line["state"] for line in lines if line.get("job") == job} >= {"running", "done"}
    assert TOKEN not in server.stderr


def test_no_token_is_left_in_what_is_logged() -> None:
    said = f"GET /?token=abc.def&x=1 Authorization: Bearer xyz {TOKEN}"
    record = logging.LogRecord("a", logging.ERROR, __file__, 1, said, (), None)
    line = JsonFormatter(TOKEN).format(record)
    assert not any(secret in line for secret in ("abc.def", "xyz", TOKEN))
    assert "x=1" in json.loads(line)["message"]


def names_of(registry: CollectorRegistry) -> set[str]:
    return {
        family.name + suffix
        for family in registry.collect()
        for suffix in SUFFIXES.get(family.type, ("",))
    }


def test_the_dashboard_asks_for_metrics_that_are_served() -> None:
    metrics = Metrics()
    metrics.watch_queues(dict)
    metrics.watch_backups(float, float)
    metrics.job(Job(kind="import", state="done"))
    panels = json.loads(DASHBOARD.read_text())["panels"]
    asked = {
        name
        for panel in panels
        for target in panel["targets"]
        for name in re.findall(r"(?:pointbrush|process)_\w+", target["expr"])
    }
    rules = yaml.safe_load(ALERTS.read_text())["groups"][0]["rules"]
    asked |= {name for rule in rules for name in re.findall(r"pointbrush_\w+", rule["expr"])}
    served = names_of(metrics.registry)
    assert asked <= served
    own = {name for name in served if re.fullmatch(r"pointbrush_\w+(?<!_sum)(?<!_count)", name)}
    assert own <= asked, "each metric of ours is on the dashboard"
