"""The client of a pointbrush server: recordings, frames, labels and jobs as Python values.

    from pointbrush.client import Client

    with Client("http://127.0.0.1:8080", token) as client:
        room = client["juggling"]
        car = room.create_label("car 1", category="car")
        room.frames[0].stroke(label=car.id, radius=0.1, samples=[[0.2, 0.1, 1.4]])
        room.track([car.id], start=0, stop=len(room.frames) - 1)
        values = room.frames[5].annotation()

``AsyncClient`` has the same calls as coroutines: ``room = await client["juggling"]``.

A path is a path of this machine, and its files are uploaded; ``server_path`` names a path on the
server.  Arrays are NumPy's, in the order of the points in the source.  A call that the server
refuses raises an error of ``pointbrush.errors``.
"""

from pointbrush.client.accounts import Accounts
from pointbrush.client.answers import Annotation
from pointbrush.client.boxes import Box, Boxes
from pointbrush.client.classifiers import ByExample, Classifiers, Prediction
from pointbrush.client.connection import AsyncClient, Client
from pointbrush.client.frame import Frame, Frames
from pointbrush.client.headset_reports import HeadsetReports
from pointbrush.client.projects import Project, Projects
from pointbrush.client.recording import Recording
from pointbrush.client.review import Review
from pointbrush.client.steps import PATIENCE
from pointbrush.client.watching import Doubt, Watch
from pointbrush.values.boxes import BoxPose, FittedBoxes
from pointbrush.values.classifiers import Classifier, HeldOut, Place
from pointbrush.values.edits import Edit, PastEdit
from pointbrush.values.exports import ExportFormat
from pointbrush.values.frames import Camera
from pointbrush.values.headset_checks import HeadsetReport, HeadsetReportFile
from pointbrush.values.imports import (
    Entry,
    ImportedLabels,
    ImportedRecording,
    ImportOptions,
    ImportPreview,
    LabelImportOptions,
)
from pointbrush.values.jobs import Job
from pointbrush.values.labels import Label
from pointbrush.values.objects import Candidate
from pointbrush.values.people import FoundPeople, FoundPerson, LabelledPeople, PersonPoints
from pointbrush.values.recordings import Bounds, Manifest
from pointbrush.values.taxonomy import BoxAttribute, Category
from pointbrush.values.team.accounts import Account, NewToken, Token
from pointbrush.values.team.projects import ClassFigures, PersonFigures, ProjectInfo, Statistics
from pointbrush.values.team.review import (
    Agreement,
    BoxAgreement,
    BoxScore,
    Checked,
    ClassAgreement,
    Decision,
    Finding,
    FrameAgreement,
    LabelAgreement,
    Standing,
)
from pointbrush.values.team.snapshots import Difference, FrameDifference, LabelDifference, Snapshot
from pointbrush.values.team.tasks import CopyAgreement, Disagreement, Score, Task, TaskEvent
from pointbrush.values.team.webhooks import Delivery, SecretWebhook, Webhook
from pointbrush.values.tracking import Run, Track

__all__ = [
    "PATIENCE",
    "Account",
    "Accounts",
    "Agreement",
    "Annotation",
    "AsyncClient",
    "Bounds",
    "Box",
    "BoxAgreement",
    "BoxAttribute",
    "BoxPose",
    "BoxScore",
    "Boxes",
    "ByExample",
    "Camera",
    "Candidate",
    "Category",
    "Checked",
    "ClassAgreement",
    "ClassFigures",
    "Classifier",
    "Classifiers",
    "Client",
    "CopyAgreement",
    "Decision",
    "Delivery",
    "Difference",
    "Disagreement",
    "Doubt",
    "Edit",
    "Entry",
    "ExportFormat",
    "Finding",
    "FittedBoxes",
    "FoundPeople",
    "FoundPerson",
    "Frame",
    "FrameAgreement",
    "FrameDifference",
    "Frames",
    "HeadsetReport",
    "HeadsetReportFile",
    "HeadsetReports",
    "HeldOut",
    "ImportOptions",
    "ImportPreview",
    "ImportedLabels",
    "ImportedRecording",
    "Job",
    "Label",
    "LabelAgreement",
    "LabelDifference",
    "LabelImportOptions",
    "LabelledPeople",
    "Manifest",
    "NewToken",
    "PastEdit",
    "PersonFigures",
    "PersonPoints",
    "Place",
    "Prediction",
    "Project",
    "ProjectInfo",
    "Projects",
    "Recording",
    "Review",
    "Run",
    "Score",
    "SecretWebhook",
    "Snapshot",
    "Standing",
    "Statistics",
    "Task",
    "TaskEvent",
    "Token",
    "Track",
    "Watch",
    "Webhook",
]
