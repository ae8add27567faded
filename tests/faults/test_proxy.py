"""The whole topology of docker-compose.yml with a proxy before it, on loopback."""

from __future__ import annotations

import uuid
from contextlib import ExitStack
from pathlib import Path

import httpx
import numpy as np
import pytest
from waiting import eventually

from pointbrush.client import Client
from tests.faults.clients import SocketTalk
from tests.faults.server import TOKEN
from tests.faults.test_topology import Lab
from tests.postgres import PostgresServer
from tests.proxy import proxy

FOREIGN = "https://elsewhere.example"


def files(folder: Path) -> Path:
    folder.mkdir()
    for i in range(2):
        np.save(folder / f"{i}.npy", np.random.default_rng(i).uniform(-1, 1, (500, 3)))
    return folder


@pytest.mark.timeout(300)
def test_people_work_through_a_proxy_on_two_servers_with_one_database_and_dask(
    tmp_path: Path,
    postgres_server: PostgresServer,
) -> None:
    with ExitStack() as stack:
        lab = Lab(tmp_path, postgres_server.new_labels(), stack)
        lab.options |= {"POINTBRUSH_TRUSTED_PROXIES": "127.0.0.1"}
        lab.worker()
        url = stack.enter_context(proxy([lab.server().port, lab.server().port]))
        first, second = (
            stack.enter_context(Client(url, TOKEN, cookies={"pointbrush_server": number}))
            for number in "01"
        )

        # A worker of the cluster imports what was uploaded, and tracks.
        uploaded = first.import_files([files(tmp_path / "room")])
        assert [each.id for each in second.sequences()] == ["ball", uploaded.id]

        # What is painted over a socket at one server is read at the other.
        label = first["ball"].create_label("pin").id
        stroke = {"label": label, "tool": "paint", "shape": "sphere", "radius": 0.4}
        edit = {"kind": "stroke", "id": str(uuid.uuid4()), "frame": 0}
        edit["stroke"] = stroke | {"samples": [{"origin": [0, 0, 3]}]}
        with SocketTalk(url, TOKEN, "ann") as ann:
            changed = ann.stroke(edit)["changed"]
        there = second["ball"].frames[0]
        eventually(lambda: (there.annotation() == label).sum() == changed > 0)
        tracked = second["ball"].track([label], start=0, stop=1, method="icp", progress=False)
        assert tracked.frames >= 1
        assert (first["ball"].frames[1].annotation() == label).any()

        # The page's cookie is for HTTPS, as visitors come by, and other pages are refused.
        own = url.replace("http:", "https:")
        call = {"url": f"{url}/api/v1/session", "json": {"token": TOKEN}}
        signed_in = httpx.post(**call, headers={"Origin": own})
        assert signed_in.is_success
        assert "; Secure" in signed_in.headers["set-cookie"].replace("secure", "Secure")
        for origin in (FOREIGN, url):
            assert httpx.post(**call, headers={"Origin": origin}).status_code == 403
