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

from pointbrush.client.accounts import Account, Accounts, NewToken, Token
from pointbrush.client.boxes import Box, Boxes, BoxPose
from pointbrush.client.classifiers import ByExample, Classifier, Classifiers, Place, Prediction
from pointbrush.client.connection import AsyncClient, Client
from pointbrush.client.frame import Frame, Frames
from pointbrush.client.headset_reports import HeadsetReport, HeadsetReports
from pointbrush.client.projects import Difference, Project, ProjectInfo, Projects, Snapshot, Task
from pointbrush.client.recording import Recording
from pointbrush.client.review import (
    Agreement,
    Checked,
    Finding,
    FrameAgreement,
    LabelAgreement,
    Review,
    Standing,
)
from pointbrush.client.steps import PATIENCE
from pointbrush.client.values import (
    Annotation,
    Bounds,
    BoxAttribute,
    Camera,
    Candidate,
    Category,
    Edit,
    ExportFormat,
    Job,
    Label,
    Manifest,
    PastEdit,
    Run,
    Track,
)
from pointbrush.client.watching import Doubt, Watch

__all__ = [
    "PATIENCE",
    "Account",
    "Accounts",
    "Agreement",
    "Annotation",
    "AsyncClient",
    "Bounds",
    "Box",
    "BoxAttribute",
    "BoxPose",
    "Boxes",
    "ByExample",
    "Camera",
    "Candidate",
    "Category",
    "Checked",
    "Classifier",
    "Classifiers",
    "Client",
    "Difference",
    "Doubt",
    "Edit",
    "ExportFormat",
    "Finding",
    "Frame",
    "FrameAgreement",
    "Frames",
    "HeadsetReport",
    "HeadsetReports",
    "Job",
    "Label",
    "LabelAgreement",
    "Manifest",
    "NewToken",
    "PastEdit",
    "Place",
    "Prediction",
    "Project",
    "ProjectInfo",
    "Projects",
    "Recording",
    "Review",
    "Run",
    "Snapshot",
    "Standing",
    "Task",
    "Token",
    "Track",
    "Watch",
]
