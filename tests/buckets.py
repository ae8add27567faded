"""An S3 server for tests: moto's, in this process, on a free loopback port."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from functools import partial

import boto3
import pytest
from moto.server import ThreadedMotoServer

from pointbrush.jobs import worker
from tests.forked import begin_worker_in

_numbers = itertools.count()


@pytest.fixture(scope="session")
def s3_endpoint() -> Iterator[str]:
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    yield f"http://{host}:{port}"
    server.stop()


@pytest.fixture
def s3(s3_endpoint: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """URL of a new, empty place in a bucket that the environment's credentials open."""
    for name, value in {
        "AWS_ENDPOINT_URL": s3_endpoint,
        "AWS_ACCESS_KEY_ID": "somebody",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_EC2_METADATA_DISABLED": "true",
    }.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(worker, "_begin_worker", partial(begin_worker_in, dict(os.environ)))
    bucket = f"lab-{next(_numbers)}"
    boto3.client("s3").create_bucket(Bucket=bucket)
    return f"s3://{bucket}/recordings"
