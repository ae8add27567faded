"""Studies of labelling: their participants, results and replays."""

from __future__ import annotations

from pathlib import Path

from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.values.study import (
    FileKind,
    NewParticipant,
    NewParticipants,
    NewStudy,
    Participant,
    Replay,
    SessionStep,
    StudyInfo,
)


class Study(Part[L]):
    """A study; ``info``: its facts as of the call that returned it.

    ``participant`` is a participant's number, or the code.
    """

    def __init__(self, link: L, info: StudyInfo) -> None:
        super().__init__(link, f"/studies/{info.id}")
        self.info, self.id = info, info.id

    def __repr__(self) -> str:
        return f"Study({self.id!r}, {self.info.participants} participants)"

    @steps
    def change(self, text: str) -> Steps[StudyInfo]:
        """Replace the study by one in YAML; raises ConflictError with participants."""
        return self._change(StudyInfo, "PUT", "", NewStudy(text=text))

    @steps
    def delete(self) -> Steps[None]:
        """Remove the study and every trace of its participants."""
        yield from self._call("DELETE")

    @steps
    def participants(self) -> Steps[list[Participant]]:
        """Return the participants by number, with their current steps."""
        return self._get(list[Participant], "/participants")

    @steps
    def add_participants(self, count: int = 1) -> Steps[list[NewParticipant]]:
        """Add participants; only this answer has their codes and links."""
        body = NewParticipants(count)
        return self._change(list[NewParticipant], "POST", "/participants", body, idempotent=False)

    @steps
    def pause(self, participant: int | str, *, paused: bool = True) -> Steps[Participant]:
        """Pause the session of a participant, or continue it."""
        place = f"/participants/{participant}"
        return self._change(Participant, "PATCH", place, {"paused": paused})

    @steps
    def delete_participant(self, participant: int | str) -> Steps[None]:
        """Remove every trace of a participant: session, answers, log, labels and copies."""
        yield from self._call("DELETE", f"/participants/{participant}")

    @steps
    def results(
        self, out: AnyPath, *, format: FileKind = "csv", curves: bool = False
    ) -> Steps[None]:
        """Write a row for each finished task to a file, or the IoU over time (``curves``)."""
        query = {"format": format, "table": "curves" if curves else "tasks"}
        yield from self._call("GET", "/results", params=query, into=Path(out))

    @steps
    def report(self, out: AnyPath) -> Steps[None]:
        """Write plots and effect sizes to an HTML file."""
        yield from self._call("GET", "/report", into=Path(out))

    @steps
    def log(self, participant: int | str, out: AnyPath, *, format: FileKind = "csv") -> Steps[None]:
        """Write all records of a participant to a file."""
        place = f"/participants/{participant}/log"
        yield from self._call("GET", place, params={"format": format}, into=Path(out))

    @steps
    def recordings(self, participant: int | str) -> Steps[list[SessionStep]]:
        """Return the steps of a participant that have a recording, by number."""
        return self._get(list[SessionStep], f"/participants/{participant}/steps")

    @steps
    def replay(self, participant: int | str) -> Steps[Replay]:
        """Compare the labels of a participant with those that their log leads to."""
        return self._change(Replay, "POST", f"/participants/{participant}/replay")


class Studies(Part[L]):
    """The studies of a workspace, for managers."""

    @steps
    def all(self) -> Steps[list[Study[L]]]:
        """Return the studies by id."""
        found = yield from self._get(list[StudyInfo], "/studies")
        return [Study(self._link, each) for each in found]

    @steps
    def __getitem__(self, study: str) -> Steps[Study[L]]:
        """Return a study by its id."""
        return Study(self._link, (yield from self._get(StudyInfo, f"/studies/{study}")))

    @steps
    def create(
        self, *, id: str | None = None, text: str = "", template: str = ""
    ) -> Steps[Study[L]]:
        """Create a study from YAML, or from a template of the package."""
        body = NewStudy(id=id, text=text, template=template)
        made = yield from self._change(StudyInfo, "POST", "/studies", body, idempotent=False)
        return Study(self._link, made)
