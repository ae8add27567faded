"""The command for studies of labelling."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush.commands.answers import Answer, confirmed, table
from pointbrush.commands.arguments import FROM_ONE, argument, required, switch, verb
from pointbrush.errors import BadInputError

if TYPE_CHECKING:
    from pointbrush.client import Client
    from pointbrush.client.studies import Study
    from pointbrush.values.study import FileKind

ACTIONS = ("list", "add", "participants", "results", "report", "replay", "delete")


@verb(
    argument("action", "the action", choices=ACTIONS),
    argument("study", "id of the study; a template or a YAML file (add)", nargs="?"),
    argument(
        "--participants", "participants to add (add, participants)", type=FROM_ONE, metavar="N"
    ),
    argument("--participant", "number or code of one participant (replay, delete)", metavar="P"),
    argument("--out", "file to write (results: .csv or .parquet; report: .html)", metavar="PATH"),
    switch("--curves", "the IoU over time instead of a row per task (results)"),
)
def study(given: argparse.Namespace, client: Client) -> Answer:
    """List, add, evaluate or delete studies of labelling of a server."""
    if given.action == "list":
        found = [each.info for each in client.studies.all()]
        rows = [(each.id, f"{each.done}/{each.participants}", each.study.title) for each in found]
        return table(found, ("ID", "DONE", "TITLE"), rows)
    name = required("study", given.study)
    if given.action == "add":
        source = Path(name)
        text = source.read_text(encoding="utf-8") if source.suffix == ".yaml" else None
        made = client.studies.create(text=text, template=None if text else name)
        if given.participants:
            return _add(made, given.participants)
        return confirmed(f"added study {made.id}", study=made.id)
    own = client.studies[name]
    if given.action == "participants":
        return _add(own, given.participants) if given.participants else _list(own)
    if given.action in ("results", "report"):
        return _write(own, given)
    if given.action == "replay":
        return _replay(own, given.participant)
    if given.participant:
        own.delete_participant(given.participant)
        return confirmed("deleted the participant", study=name)
    own.delete()
    return confirmed(f"deleted study {name}", study=name)


def _add(own: Study, count: int) -> Answer:
    made = own.add_participants(count)
    rows = [(each.number, each.link, ", ".join(each.conditions)) for each in made]
    return table(made, ("NUMBER", "LINK", "CONDITIONS"), rows)


def _list(own: Study) -> Answer:
    found = own.participants()
    rows = [
        (each.number, each.state, f"{each.step}/{each.count - 1}", each.condition, each.task)
        for each in found
    ]
    return table(found, ("NUMBER", "STATE", "STEP", "CONDITION", "TASK"), rows)


def _write(own: Study, given: argparse.Namespace) -> Answer:
    out = Path(required("out", given.out))
    if given.action == "report":
        own.report(out)
    elif out.suffix in (".csv", ".parquet"):
        kind: FileKind = "csv" if out.suffix == ".csv" else "parquet"
        own.results(out, format=kind, curves=given.curves)
    else:
        raise BadInputError(f"out: expected a file .csv or .parquet, got {out.name!r}")
    return confirmed(f"wrote {out}", out=str(out))


def _replay(own: Study, participant: str | None) -> Answer:
    """Replay one participant, or all; a difference is an error."""
    numbers = [participant] if participant else [each.number for each in own.participants()]
    found = {str(number): own.replay(number) for number in numbers}
    lines = [
        f"{number}\t{'equal' if each.equal else each.difference}" for number, each in found.items()
    ]
    differs = not all(each.equal for each in found.values())
    return Answer(found, lines, error="the labels differ from the log" if differs else "")
