"""Studies of labelling: a study, its participants, their steps, and the log of a session."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Body, Complete, Rule, Value
from pointbrush.values.kinds import FrameRange, LabelId, Name, SequenceName, Share

MOST_RECORDS = 1_000
"""Records of one call: half a minute of poses at 30 Hz."""
LONGEST_LOG = 1_000_000
"""Records of one participant: nine hours of poses at 30 Hz."""
MOST_PARTICIPANTS = 1_000
"""Participants of one study."""
LONGEST_YAML = 1 << 22
"""Characters of a study's file, which may contain pictures."""

Prose = Annotated[str, Rule(max_length=10_000)]
"""Text that participants read; an empty line begins a paragraph."""
Word = Annotated[str, Rule(min_length=1, max_length=64, pattern=r"^\w[\w .:/+-]*$")]
Token = Annotated[str, Rule(max_length=64, pattern=r"^[\w-]*$")]
"""A word of a log; no table program takes it for a formula."""
Picture = Annotated[
    str,
    Rule(max_length=400_000, pattern=r"^(data:image/(png|jpeg|webp);base64,[A-Za-z0-9+/=]+)?$"),
]
Seconds = Annotated[float, Rule(gt=0, le=86_400, allow_inf_nan=False)]
Number = Annotated[float, Rule(ge=-1e12, le=1e12, allow_inf_nan=False)]
Pose = Annotated[tuple[Number, ...], Rule(min_length=7, max_length=7)]
"""Position (metres) and quaternion (x, y, z, w) in the coordinates of the recording."""

Count = Annotated[int, Rule(ge=0, lt=2**31)]
Millis = Annotated[float, Rule(ge=0, le=1e9, allow_inf_nan=False)]
Properties = Annotated[
    Mapping[Annotated[str, Rule(max_length=64)], Annotated[str, Rule(max_length=300)]],
    Rule(max_length=32),
]

FileKind = Literal["csv", "parquet", "json"]
Phase = Literal["navigation", "painting", "waiting"]
StepKind = Literal["consent", "instructions", "practice", "task", "questionnaire", "pause", "done"]
RecordKind = Literal[
    "stroke", "click", "undo", "redo", "level", "label", "playback", "pose", "frame_time",
    "device", "phase",
]  # fmt: skip
ParticipantState = Literal["waiting", "running", "paused", "done"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition(Body, Complete):
    """One way of labelling that the study compares."""

    name: Word
    """Name in results."""
    device: Literal["desk", "headset"] = "desk"
    """Device of the participant: a window at the `desk`, or a `headset`."""
    input: Literal["mouse", "controller", "hands", "look-and-pinch"] = "mouse"
    """Input: `mouse` and keyboard, `controller` of a headset, `hands`, or `look-and-pinch`."""
    tools: Annotated[tuple[Word, ...], Rule(max_length=32)] = ()
    """Names of the page's tools that are shown; empty: all."""
    hints: bool = True
    """The page shows hints."""
    instructions: Prose = ""
    """Text before the first task of the condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyTask(Body, Complete):
    """Labels to reach in some frames of a recording."""

    name: Word
    """Name in results."""
    recording: SequenceName
    """Id of the recording; each participant labels a copy of it without labels."""
    sample: Annotated[str, Rule(max_length=64)] = ""
    """Generated sample that becomes the recording if it does not exist; empty: none."""
    frames: FrameRange = ":"
    """Frames ``I:J`` to label, J not included."""
    labels: Annotated[tuple[Name, ...], Rule(min_length=1, max_length=100)]
    """Names of the labels to reach, of the recording's palette."""
    truth: Annotated[str, Rule(max_length=64)] = ""
    """Id of a snapshot with the ground truth; empty: the current labels of the recording."""
    time_limit_s: Seconds | None = None
    """Time after which the task ends, seconds without pauses; null: none."""
    stop: Literal["button", "time", "iou"] = "button"
    """Event that ends the task: the participant's `button`, the `time` limit, or `iou`, that is
    ``target_iou``.  The time limit ends every task."""
    target_iou: Share = 0.9
    """Mean IoU of the labels at which a task with ``stop`` iou ends."""
    instructions: Prose = ""
    """Text before the task."""
    picture: Picture = ""
    """Picture beside the instructions, as a data URL; empty: a thumbnail of the recording."""
    practice: bool = False
    """The task is practice: it comes first in each condition and is not in the results."""


@dataclass(frozen=True, slots=True, kw_only=True)
class QuestionItem(Body, Complete):
    """One item of a questionnaire: a scale."""

    text: Annotated[str, Rule(min_length=1, max_length=500)]
    """Statement or question."""
    low: Annotated[str, Rule(max_length=100)] = ""
    """Text at the low end of the scale."""
    high: Annotated[str, Rule(max_length=100)] = ""
    """Text at the high end of the scale."""
    steps: Annotated[int, Rule(ge=2, le=101)] = 5
    """Number of positions of the scale; answers are 1 to ``steps``."""
    reversed: bool = False
    """A high answer counts as a low one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Questionnaire(Body, Complete):
    """Items that are answered after each condition or at the end of the study."""

    name: Word
    """Name in results."""
    scoring: Literal["sus", "tlx", "own"] = "own"
    """Published items if there are no others: `sus` System Usability Scale, `tlx` raw NASA-TLX,
    `own` none.  The score is the mean of the answers, 0 to 100, with reversed items turned."""
    title: Annotated[str, Rule(max_length=200)] = ""
    """Heading of the page; empty: the name."""
    items: Annotated[tuple[QuestionItem, ...], Rule(max_length=100)] = ()
    """The items in order."""
    after: Literal["condition", "study"] = "condition"
    """Time of the questionnaire: after each `condition`, or after the `study`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Study(Body, Complete):
    """A study, as its file ``studies/ID.yaml`` in the workspace describes it."""

    title: Name
    """Title that participants see."""
    consent: Prose = ""
    """Text to which participants agree first; empty: no such step."""
    conditions: Annotated[tuple[Condition, ...], Rule(min_length=1, max_length=12)]
    """Ways of labelling to compare."""
    design: Literal["within", "between"] = "within"
    """Conditions of a participant: all (`within`) or one (`between`)."""
    order: Literal["latin", "random"] = "latin"
    """Order of conditions: a balanced `latin` square by the participants' numbers, or `random`."""
    seed: Annotated[int, Rule(ge=0, lt=2**31)] = 1
    """Seed of the random order and of the bootstrap."""
    tasks: Annotated[tuple[StudyTask, ...], Rule(min_length=1, max_length=50)]
    """Tasks of each condition, in order; practice comes first."""
    questionnaires: Annotated[tuple[Questionnaire, ...], Rule(max_length=20)] = ()
    """Questionnaires in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewStudy(Body):
    """A study to be created or to replace one: the text of its file, or a template."""

    id: SequenceName | None = None
    """Name in URLs of a new study; null: derived from the title."""
    text: Annotated[str, Rule(max_length=LONGEST_YAML)] = ""
    """The study as YAML, of which JSON is a part."""
    template: Annotated[str, Rule(max_length=64)] = ""
    """Study of the package instead: ``desk-or-headset`` or ``brush-or-object-tool``."""


@dataclass(frozen=True, slots=True)
class StudyInfo(Value):
    """A study and the number of its participants."""

    id: str
    """Name in URLs."""
    study: Study
    """The study."""
    text: str
    """The file of the study, YAML."""
    participants: int
    """Number of participants."""
    done: int
    """Number of participants that have finished."""


@dataclass(frozen=True, slots=True)
class Participant(Complete):
    """A participant and the current step."""

    number: int
    """Number in the study, from 1."""
    conditions: tuple[str, ...]
    """Names of the participant's conditions in order."""
    state: ParticipantState
    """`waiting` (has not begun), `running`, `paused` by the experimenter, or `done`."""
    step: int
    """Number of the current step, from 0."""
    count: int
    """Number of steps."""
    kind: StepKind
    """Kind of the current step: `consent`, `instructions`, `practice`, `task`, `questionnaire`,
    `pause`, or `done`."""
    task: str | None
    """Task of the current step; null: none."""
    sequence: str | None
    """Id of the copy that the current step shows, to follow the session; null: none."""
    iou: float | None
    """Mean IoU of the labels of the current task; null: no task."""
    records: int
    """Number of records in the log."""
    code: str = ""
    """Secret code, only in the answer that adds the participant: only its digest is stored."""
    link: str = ""
    """Address to open, with the code."""


@dataclass(frozen=True, slots=True)
class NewParticipants(Body):
    """Participants to be added."""

    count: Annotated[int, Rule(ge=1, le=100)] = 1
    """Number of participants to add."""


@dataclass(frozen=True, slots=True)
class ParticipantPatch(Body):
    """Change of a participant's session."""

    paused: bool
    """The session is paused: its time stands still, and the page shows a pause."""


@dataclass(frozen=True, slots=True)
class StudyStep(Complete):
    """A step of a participant."""

    kind: StepKind
    """Kind of the step: `consent` to agree to; `instructions` of a condition or task; `practice`, a
    task that is not measured; a `task`; a `questionnaire`; `pause` by the experimenter; `done`."""
    text: str = ""
    """Text to show: of the consent, the condition or the task."""
    condition: Condition | None = None
    """Condition of the step; null: none."""
    task: StudyTask | None = None
    """Task of the step; null: none."""
    questionnaire: Questionnaire | None = None
    """Questionnaire of the step; null: none."""
    title: str = ""
    """Title of the study."""
    number: int = 0
    """Number of the step, from 0."""
    count: int = 0
    """Number of steps."""
    sequence: str | None = None
    """Id of the participant's copy of the recording; null: no task."""
    start: int = 0
    """First frame of the task."""
    stop: int = 0
    """Frame after the last one of the task."""
    labels: tuple[int, ...] = ()
    """Ids of the labels to reach, in the palette of ``sequence``."""
    time_left_s: float | None = None
    """Seconds until the time limit; null: none."""
    elapsed_s: float = 0.0
    """Seconds since the step began, without pauses; records count from there."""
    reached: bool = False
    """The task may end: its time limit or its ``target_iou`` is reached."""
    records: int = 0
    """Number of the next record of the log, from 0."""


@dataclass(frozen=True, slots=True)
class StepDone(Body):
    """The end of a step; a repeated call has no effect."""

    number: Count
    """Number of the step."""
    answers: Annotated[tuple[Annotated[int, Rule(ge=1, le=101)], ...], Rule(max_length=100)] = ()
    """Answers to the items of a questionnaire, each 1 to its ``steps``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LogRecord(Body):
    """One record of a session's log; fields that its ``kind`` does not name are left out."""

    kind: RecordKind
    """`stroke`: an edit (``id``, ``tool``, ``shape``, ``label``, ``frame``); `click` of the object
    tool (``shape`` positive or negative); `undo`, `redo` of the last edit (``id``); another `level`
    of its candidates; another `label`; `playback` (``action`` play, pause, step or seek; the
    ``frame`` it leads to); `pose` at 30 Hz (``head``, ``left``, ``right``); `frame_time` of the
    last second; `device` (``profile``), once a session; `phase` that begins."""
    step: Count
    """Number of the step in which it was made."""
    t: Millis
    """Milliseconds since the step began, by the page's monotonic clock."""
    id: Annotated[str, Rule(max_length=36, pattern=r"^[0-9a-fA-F-]*$")] = ""
    """UUID of a stroke, an undo or a redo, which is that of its edit."""
    tool: Token = ""
    """Tool of a stroke: paint, erase, delete or restore."""
    shape: Token = ""
    """Shape of a stroke, or ``positive`` and ``negative`` of a click."""
    label: LabelId | None = None
    """Id of the label."""
    level: Count | None = None
    """Level of the object tool."""
    frame: Count | None = None
    """Frame of the recording."""
    action: Token = ""
    """Action of playback."""
    phase: Phase | None = None
    """Phase that begins: `navigation` (the view moves), `painting` (a trigger or button is held to
    label) or `waiting` (neither)."""
    head: Pose | None = None
    """Pose of the head; at the desk of the camera."""
    left: Pose | None = None
    """Pose of the left hand or controller."""
    right: Pose | None = None
    """Pose of the right hand or controller."""
    mean_ms: Millis | None = None
    """Mean time of a picture in the last second, milliseconds."""
    p95_ms: Millis | None = None
    """Time that 95% of the last second's pictures kept, milliseconds."""
    dropped: Count | None = None
    """Pictures of the last second that were late by more than half a period."""
    profile: Properties | None = None
    """Properties of the device, such as ``agent``, ``gpu``, ``controllers``, ``rate``."""


@dataclass(frozen=True, slots=True)
class LogRecords(Body):
    """Consecutive records of a log."""

    first: Annotated[int, Rule(ge=0, le=LONGEST_LOG)]
    """Number of the first of them; the first record of a session has 0."""
    records: Annotated[tuple[LogRecord, ...], Rule(min_length=1, max_length=MOST_RECORDS)]
    """The records in order."""


@dataclass(frozen=True, slots=True)
class LogPosition(Value):
    """End of a log."""

    next: int
    """Number of the next record."""


@dataclass(frozen=True, slots=True)
class Replay(Value):
    """Comparison of the labels of a session with the result of its log."""

    equal: bool
    """All labels are equal, bit for bit."""
    edits: int
    """Number of edits that were applied."""
    difference: str
    """The first difference in words; empty: none."""
