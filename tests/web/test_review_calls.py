"""Review over REST: states, notes, people, and who may set them."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from pointbrush.accounts.roles import ROLES
from tests.serving import Served

PLACE = [0.5, -0.25, 3.0]


@pytest.fixture(scope="module")
def people(served: Served) -> dict[str, dict[str, str]]:
    """Headers of a person of each role."""
    tokens = served.workspace.labels.tokens
    return {role: {"Authorization": f"Bearer {tokens.add(role, role)}"} for role in ROLES}


def put(served: Served, headers: dict[str, str], path: str, **body: Any) -> httpx.Response:
    url = f"{served.url}/api/v1/sequences/wall/{path}"
    return httpx.put(url, json=body, headers=headers)


def get(served: Served, path: str, **query: Any) -> Any:
    url = f"{served.url}/api/v1/sequences/wall/{path}"
    answer = httpx.get(url, headers=served.headers, params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_frames_go_from_an_annotator_to_a_reviewer_and_back(
    served: Served, people: dict[str, dict[str, str]]
) -> None:
    given = put(served, people["manager"], "review", first=0, last=1, assignee="annotator")
    assert given.status_code == 200, given.text
    put(served, people["annotator"], "review", first=0, last=1, state="review").raise_for_status()
    rejected = {"state": "rejected", "note": "the door is open", "place": PLACE}
    answer = put(served, people["reviewer"], "frames/1/review", **rejected)
    assert answer.status_code == 200, answer.text
    frame = get(served, "frames/1/review")
    assert rejected.items() <= frame.items()
    assert (frame["assignee"], frame["by"], frame["first"]) == ("annotator", "reviewer", 1)
    put(served, people["annotator"], "frames/1/review", state="review").raise_for_status()
    assert get(served, "frames/1/review")["note"] == "the door is open"
    put(served, people["reviewer"], "review", first=0, last=1, state="accepted").raise_for_status()
    overview = get(served, "review")
    assert overview["counts"] == {"open": 2, "review": 0, "accepted": 2, "rejected": 0}
    assert overview["frames"][0]["note"] == ""
    assert {"annotator", "reviewer", "manager"} <= set(overview["people"])
    history = get(served, "review/history")
    assert [(line["by"], line["state"]) for line in history][:3] == [
        ("reviewer", "accepted"),
        ("annotator", "review"),
        ("reviewer", "rejected"),
    ]
    refused = put(served, people["annotator"], "frames/0/review", state="open")
    assert refused.status_code == 403
    stroke = {"label": 0, "tool": "delete", "radius": 0.5, "samples": [{"origin": [0, 0, 3]}]}
    url = f"{served.url}/api/v1/sequences/wall/frames/0/strokes"
    httpx.post(url, json=stroke, headers=people["annotator"]).raise_for_status()
    assert get(served, "frames/0/review")["changed"] is True
    assert get(served, "frames/1/review")["changed"] is False


def test_a_label_is_judged_in_a_frame_and_as_a_whole(
    served: Served, people: dict[str, dict[str, str]]
) -> None:
    label = served.workspace.labels.create_label("wall", "ada", name="pin").id
    reviewer = people["reviewer"]
    put(served, reviewer, "frames/2/review", label=label, state="rejected").raise_for_status()
    put(served, reviewer, "review", label=label, state="accepted").raise_for_status()
    assert get(served, "frames/2/review", label=label)["state"] == "rejected"
    assert get(served, "frames/2/review")["state"] == "open"
    assert [line["label"] for line in get(served, "review")["labels"]] == [label]


def test_suspicious_things_come_in_order_with_their_places(served: Served) -> None:
    names = [served.workspace.labels.create_label("wall", "ada", name="door").id for _ in range(2)]
    stroke = {"label": names[1], "radius": 0.3, "samples": [{"origin": [0, 0, 3]}]}
    url = f"{served.url}/api/v1/sequences/wall/frames/3/strokes"
    httpx.post(url, json=stroke, headers=served.headers).raise_for_status()
    checked = get(served, "checks")
    assert checked["unchecked"] == []
    (double,) = (each for each in checked["findings"] if each["kind"] == "name")
    assert (double["labels"], double["first"], double["settled"]) == (names, 3, False)
    assert double["place"] == pytest.approx([0, 0, 3], abs=0.4)
    assert get(served, "checks", frames="0:2")["findings"] != checked["findings"]
    bad = httpx.get(
        f"{served.url}/api/v1/sequences/wall/checks",
        params={"frames": "2:9"},
        headers=served.headers,
    )
    assert bad.status_code == 422
    assert "0:4" in bad.json()["detail"]


@pytest.mark.parametrize(
    ("role", "body", "status", "said"),
    [
        ("viewer", {"first": 0, "last": 0, "state": "review"}, 403, "annotator"),
        ("annotator", {"first": 0, "last": 0, "state": "accepted"}, 403, "reviewer"),
        ("annotator", {"first": 0, "last": 0, "state": "rejected"}, 403, "reviewer"),
        ("reviewer", {"first": 0, "last": 0, "assignee": "ada"}, 403, "manager"),
        ("admin", {"first": 3, "last": 2, "state": "open"}, 404, "first <= last"),
        ("admin", {"first": 0, "last": 4, "state": "open"}, 404, "0 to 3"),
        ("admin", {"first": 0, "state": "open"}, 422, "first and last"),
        ("admin", {"state": "open"}, 422, "or a label"),
        ("admin", {"first": 0, "last": 0}, 422, "a state, a note or an assignee"),
        ("admin", {"first": 0, "last": 0, "state": "fine"}, 422, "state"),
        ("admin", {"label": 60000, "state": "open"}, 404, "label"),
        ("admin", {"first": 0, "last": 0, "state": "open", "place": PLACE}, 422, "note"),
        ("admin", {"first": 0, "last": 0, "assignee": " "}, 422, "name"),
    ],
)
def test_what_cannot_be_is_refused_in_words(
    served: Served,
    people: dict[str, dict[str, str]],
    role: str,
    body: dict[str, Any],
    status: int,
    said: str,
) -> None:
    before = get(served, "review/history")
    answer = put(served, people[role], "review", **body)
    assert (answer.status_code, said in answer.json()["detail"]) == (status, True), answer.text
    assert get(served, "review/history") == before


def test_agreement_with_another_recording(served: Served) -> None:
    found = get(served, "agreement", **{"with": "wall"})
    assert all(label["iou"] == 1 for label in found["labels"])
    assert [frame["differ"] for frame in found["frames"]] == [0] * 4
    url = f"{served.url}/api/v1/sequences/wall/frames/0/agreement"
    answer = httpx.get(url, params={"with": "wall"}, headers=served.headers)
    assert answer.headers["Content-Type"] == "image/png"
    assert answer.content.startswith(b"\x89PNG")
    missing = httpx.get(url, params={"with": "none"}, headers=served.headers)
    assert missing.status_code == 404


def test_the_report_is_a_page_under_a_policy_of_its_own_and_a_table(served: Served) -> None:
    url = f"{served.url}/api/v1/sequences/wall/report"
    page = httpx.get(url, headers=served.headers)
    assert page.headers["Content-Type"] == "text/html; charset=utf-8"
    assert "default-src 'none'; style-src 'sha256-" in page.headers["Content-Security-Policy"]
    assert "People" in page.text
    query = {"format": "csv", "table": "labels"}
    table = httpx.get(url, params=query, headers=served.headers)
    assert table.headers["Content-Type"] == "text/csv; charset=utf-8"
    assert table.text.startswith("label,name,")
