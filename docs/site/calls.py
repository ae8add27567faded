"""Call each method of the client: the examples of the references of Python and REST.

``# Class.method`` begins the example of a method, ``# Class`` the example of a class, and
``# rest`` the calls for which the client has no method.  Tests run the examples in this order, with
``client``, ``url``, ``token``, a folder to work in, and the recordings ``juggling`` and ``room``.
"""

# ruff: noqa: F821, E402
# mypy: ignore-errors

# Client
from pathlib import Path

from pointbrush.client import Client

with Client(url, token) as client:
    print(client["juggling"])

# Client.__init__
client = Client(url, token, timeout=30.0)

# Client.sequences
for recording in client.sequences():
    print(recording.id, recording.manifest.frames)

# Client.search
found = client.search("jugg", label="car")

# Client.manifests
damaged = [each.id for each in client.manifests() if each.damaged]

# Client.__getitem__
juggling = client["juggling"]

# Client.call
health = client.call("GET", "/session").json()

# Client.preview
seen = client.preview("recording")  # a folder of this machine, uploaded
print(seen.format, seen.frames, seen.warnings)

# Client.start_import
job = client.start_import("recording", name="later")

# Client.wait
result = client.wait(job, progress=True)

# Client.import_files
garden = client.import_files("recording", name="garden", fps=10)
drive = client.import_files(server_path=Path("sequences/00").resolve(), name="drive")

# Client.import_path
street = client.import_path(Path("sequences/00").resolve(), name="street")

# Client.job
print(client.job(job.id).state)

# Client.jobs
running = [each for each in client.jobs() if each.state == "running"]

# Client.taxonomy
classes = client.taxonomy()

# Client.box_attributes
print([each.name for each in client.box_attributes()])

# Client.change_taxonomy
from pointbrush.client import BoxAttribute, Category

client.change_taxonomy(
    [Category(200, "tram", "#4363d8", size=(28.0, 2.6, 3.6))],
    attributes=[BoxAttribute("door", "choice", "frame", ("open", "shut"))],
)

# Client.merge_categories
client.change_taxonomy([Category(201, "streetcar"), Category(202, "trolley")])
client.merge_categories(200, [201])

# Client.delete_category
client.delete_category(202)

# Client.templates
print(client.templates())

# Client.export_formats
print({each.format: each.cannot_hold for each in client.export_formats()})

# Recording
juggling = client["juggling"]
print(juggling.name, len(juggling.frames), juggling.manifest.fps)

# Recording.labels
for label in juggling.labels():
    print(label.id, label.name, label.category, label.points)

# Recording.categories
print(juggling.categories())

# Recording.create_label
pin = juggling.create_label("pin 1", category="pin", color="#e6194b")
other = juggling.create_label("pin 2", category="pin")

# Recording.label
car = juggling.label("car")

# Recording.update_label
juggling.update_label(other.id, name="pin two", locked=False)

# Recording.add_palette
added = juggling.add_palette("semantickitti")

# Frames.__getitem__
frame = juggling.frames[0]
last = juggling.frames[-1]
first_two = juggling.frames[0:2]

# Frames.__len__
print(len(juggling.frames))

# Frames.__iter__
counts = [int((each.annotation() == car.id).sum()) for each in juggling.frames]

# Frame.points
xyz = frame.points()["xyz"]  # (N, 3) float32, in the order of the source

# Frame.cameras
names = [camera.name for camera in frame.cameras()]

# Frame.image
for name in names:
    Path(f"{name}.jpg").write_bytes(frame.image(name))

# Frame.mask
mask = frame.mask("colour")  # (H, W) uint16: label ids, 65535 where no point is seen

# Frame.set_mask
mask[:24] = other.id
edit = frame.set_mask("colour", mask)
print(edit.changed, edit.doubt)

# Frame.predict_mask
edit = frame.predict_mask("colour", "toy", positives=[[32, 24]], label=other.id)

# Frame.thumbnail
Path("frame.jpg").write_bytes(frame.thumbnail())

# Frame.annotation
values = frame.annotation()
sure = frame.annotation("confidence")

# Frame.annotate
values[xyz[:, 2] < xyz[:, 2].min() + 0.02] = other.id
edit = frame.annotate(values, if_match=values.etag)

# Frame.stroke
edit = frame.stroke(label=pin.id, radius=0.2, samples=[xyz[100]])

# Frame.objects
eye, ahead = [[0.0, 0.0, 0.0]], xyz[frame.annotation() == 0][:1]
levels = frame.objects(eye, ahead)
print([level.points for level in levels])
clicked = {"shape": "object", "samples": eye, "directions": ahead}
edit = frame.stroke(label=car.id, candidate=levels[0].id, **clicked)

# Frame.copy_labels
last.copy_labels(0, [pin.id])

# Frame.clear
last.clear([pin.id])

# Recording.annotate
edit = juggling.annotate({1: values * 0, 2: values * 0})

# Recording.undo
juggling.undo()

# Recording.redo
juggling.redo()

# Recording.edits
for past in juggling.edits(limit=5):
    print(past.time, past.author, past.summary)

# Recording.watch
from itertools import islice

for happened in islice(juggling.watch(after=0), 1):
    print(happened)

# Watch.next
watch = juggling.watch(after=0)
print(watch.next())

# Recording.start_tracking
job = juggling.start_tracking([car.id], start=0, stop=1)
client.wait(job)

# Recording.track
run = juggling.track([pin.id], start=0, stop=2, progress=False)
print(run.changed, "points in", run.frames, "frames")

# Recording.tracks
unsure = [track.frame for track in juggling.tracks() if track.confidence < 0.5]

# Recording.accept
juggling.accept([pin.id], start=1, stop=2)

# Recording.clear
juggling.clear([car.id], start=1, stop=2)

# Recording.find_people
kinect = client.import_files("kinect", name="kinect")
found = kinect.find_people([0])
print([person.name for person in found.people])

# Recording.start_find_people
job = kinect.start_find_people([0])
client.wait(job)

# Recording.label_people
labelled = kinect.label_people()
print(labelled.people, "people,", labelled.changed, "points")

# Recording.align_sensors
from pointbrush.errors import ConflictError

try:
    aligned = juggling.align_sensors()
    print([(each.name, each.before, each.after) for each in aligned.sensors])
    juggling.align_sensors(undo=True)
except ConflictError as error:  # such as a recording of one sensor
    print(error)

# Recording.start_align_sensors
try:
    client.wait(juggling.start_align_sensors([0]))
except ConflictError as error:
    print(error)

# Recording.start_fit_boxes
job = juggling.start_fit_boxes(category="car", frames="0:1")
client.wait(job)

# Recording.fit_boxes
juggling.fit_boxes([car.id], frames="0:1")

# Boxes.add
from pointbrush.client import BoxPose

turned = BoxPose(centre=(0.2, 0.1, 1.4), quaternion=(0.0, 0.0, 0.0, 1.0))
box = juggling.boxes.add(pin.id, size=(0.5, 0.2, 0.2), poses={0: turned})

# Boxes.all
for each in juggling.boxes.all(frame=0):
    print(each.id, each.size)

# Boxes.__getitem__
box = juggling.boxes[box.id]

# Boxes.change
juggling.boxes.change(box.id, attributes={"parked": True}, poses={1: turned})

# Boxes.paint
juggling.boxes.paint(box.id, "0:1", only_unlabeled=True)

# Boxes.frame
table = juggling.boxes.frame()  # a pandas frame

# Recording.export_boxes
juggling.export_boxes("kitti-tracking", "boxes.zip")

# Boxes.remove
juggling.boxes.remove(box.id)

# Recording.start_label_import
job = juggling.start_label_import([Path("000000.label")], dry_run=True)

# Recording.import_labels
report = juggling.import_labels([Path("000000.label")], format="semantickitti")

# Recording.import_source_labels
from pointbrush.errors import PointbrushError

try:
    juggling.import_source_labels()
except PointbrushError as error:
    print(error)  # the files have no labels, or the import has read them

# Recording.export
juggling.export("npz", "labels.zip", frames="0:2")

# Recording.merge_labels
juggling.merge_labels(pin.id, [other.id])

# Recording.delete_label
juggling.delete_label(juggling.create_label("a slip").id)

# Review.put
juggling.review.put(0, 1, state="review", note="is this one pin?", place=[0.2, 0.1, 1.4])

# Review.counts
print(juggling.review.counts())

# Review.standings
notes = [each.note for each in juggling.review.standings() if each.note]

# Review.frame
print(juggling.review.frame(0).state)

# Review.history
print(juggling.review.history(limit=10))

# Review.check
checked = juggling.review.check(frames="0:2")

# Review.checks
for finding in juggling.review.checks():
    print(finding.text)

# Review.agreement
print(juggling.review.agreement("room").miou)

# Review.difference
Path("difference.png").write_bytes(juggling.review.difference("room", frame=0))

# Review.report
juggling.review.report("report.html")

# Classifiers.create
walls = client["room"].create_label("wall")
room = client["room"].frames[0]
room.stroke(label=1, radius=0.4, samples=room.points()["xyz"][:1])
room.stroke(label=walls.id, radius=0.4, samples=room.points()["xyz"][300:301])
kinds = client.classifiers.create("kinds", ["room"])

# Classifiers.all
print([each.name for each in client.classifiers.all()])

# Classifiers.__getitem__
print(client.classifiers[kinds.id].score)

# Classifiers.teach
kinds = client.classifiers.teach(kinds.id, ["juggling"])

# Classifiers.save
client.classifiers.save(kinds.id, "kinds.npz")

# Classifiers.load
copy = client.classifiers.load("kinds.npz", name="from the other lab")

# ByExample.predict
predicted = client["room"].by_example.predict(kinds.id, frame=1)
print((predicted.confidence < 64).mean(), "of the points are in doubt")

# ByExample.starts
earlier = client["room"].by_example.starts()
print(len(earlier), "labelled recordings to start from")

# ByExample.doubt
for place in client["room"].by_example.doubt(kinds.id, frame=0, most=3):
    print(place.centre, place.classes)

# ByExample.answer
print(client["room"].by_example.answer(kinds.id, place, walls.id), "points labelled")

# ByExample.ignore
client["room"].by_example.ignore(kinds.id, place)  # none of the classes

# ByExample.take_back
client["room"].by_example.take_back(kinds.id)

# ByExample.start
job = client["room"].by_example.start(kinds.id, frames="1:2")
client.wait(job)

# ByExample.apply
client["room"].by_example.apply(kinds.id, frames="2:3", above=0.3)

# Classifiers.delete
client.classifiers.delete(copy.id)

# Projects.create
nights = client.projects.create("Night drives", roles={"ada": "annotator"})

# Projects.all
print([each.info.name for each in client.projects.all()])

# Projects.__getitem__
nights = client.projects[nights.id]

# Project
print(nights.info.tasks, nights.info.people)

# Project.change
nights.change(recordings=["room", "juggling"])

# Project.statistics
print(nights.statistics().classes)

# Client.entries
print([entry.name for entry in client.entries(server_path=Path("sequences").resolve())])

# Project.import_each
jobs = nights.import_each(server_path=Path("sequences").resolve())

# Project.add_tasks
tasks = nights.add_tasks(["room"], every=2)

# Project.tasks
open_tasks = nights.tasks(state="open")

# Project.next_task
task = nights.next_task()

# Project.task
print(nights.task(task.number).state)

# Project.put_task
nights.put_task(task.number, state="done", note="the wall is unsure")

# Project.task_history
print(nights.task_history(task.number))

# Project.delete_task
nights.delete_task(tasks[-1].number)

# Project.add_webhook
hook = nights.add_webhook("https://lab.example.org/hook", ["task"])

# Project.webhooks
print(nights.webhooks())

# Project.deliveries
print(nights.deliveries(hook.id))

# Project.delete_webhook
nights.delete_webhook(hook.id)

# Project.snapshot
version = nights.snapshot("first delivery")

# Project.snapshots
print([each.name for each in nights.snapshots()])

# Project.difference
for changed in nights.difference(version.id):
    print(changed.sequence, len(changed.frames))

# Project.delete_snapshot
nights.delete_snapshot(version.id)

# Project.agreement
copies = nights.add_tasks(["juggling"], people=2)
pairs = nights.agreement("juggling")

# Project.scores
print(nights.scores())

# Project.merge
try:
    nights.merge("juggling", take="majority")
except PointbrushError as error:
    print(error)  # no copy is submitted yet

# rest
place = "/sequences/juggling"
client.call("GET", "/me")
client.call("PUT", "/me/keys", json={"keys": {"Loop": "v"}})
client.call("GET", "/me/keys")
client.call("POST", "/session", json={"token": token})
sample = {"origin": [0.0, 0.0, 0.0], "direction": xyz[100].tolist()}
client.call("POST", f"{place}/floor", json={"frame": 0, "samples": [sample]})
client.call("DELETE", f"{place}/floor")
client.call("GET", f"{place}/frames/0/chunks")
client.call("GET", f"{place}/frames/0/chunks/0")
client.call("GET", f"{place}/frames/0/placements", params={"after": 1})
client.call("GET", f"{place}/labels/{pin.id}")
sides = juggling.frames[1].points()["xyz"]
sides = sides[[sides[:, 0].argmin(), sides[:, 0].argmax()]]
juggling.frames[1].stroke(label=pin.id, radius=1.0, samples=sides[:1])
juggling.frames[1].stroke(label=pin.id, radius=1.0, samples=sides[1:])
client.call("POST", f"{place}/labels/{pin.id}/split", json={"frame": 1})
client.call("GET", f"{place}/palette")
order = [label.id for label in juggling.labels()]
client.call("PUT", f"{place}/palette/order", json={"labels": order})
client.call("POST", f"{place}/frames/1/accept", json={"labels": [pin.id]})
client.call("PUT", f"{place}/frames/0/review", json={"state": "accepted"})
client.call("DELETE", f"{place}/features")
client.call("DELETE", f"/imports/{seen['upload']}")
version = nights.snapshot("second delivery")
client.call("GET", f"/projects/{nights.id}/snapshots/{version.id}")

# Recording.update
garden.update(name="Garden", fps=15)

# Recording.delete
garden.delete()

# Client.deleted
print([each.id for each in client.deleted()])

# Client.restore
garden = client.restore("garden")

# Client.cancel
job = client.start_import("recording", name="not wanted")
try:
    client.cancel(job.id)
except PointbrushError:
    print(client.job(job.id).state)  # it was done already

# Project.delete
client.projects.create("by mistake").delete()

# Client.accounts
people = client.accounts

# Accounts.create
made = client.accounts.create("lin", role="annotator", days=90)
print(made.token)  # the secret, shown once

# Accounts.all
print({each.account: each.role for each in client.accounts.all()})

# Accounts.add_token
headset = client.accounts.add_token("lin", days=1)

# Accounts.tokens
print([(each.id, each.valid) for each in client.accounts.tokens("lin")])

# Accounts.revoke
client.accounts.revoke("lin", headset.id)
client.accounts.revoke("lin")  # all of the account

# Client.headset_reports
reports = client.headset_reports

# HeadsetReports.add
import json

report = json.loads(Path("headset-report-2026-11-27.json").read_text())
client.headset_reports.add(report)

# HeadsetReports.all
print([(each.account, each.received) for each in client.headset_reports.all()])

# rest
print([(each["id"], each["done"]) for each in client.call("GET", "/studies").json()])
client.call("POST", "/studies", json={"template": "brush-or-object-tool"})
study = client.call("GET", "/studies/brush-or-object-tool").json()
client.call("POST", "/studies", json={"text": study["text"], "id": "mine"})
between = study["text"].replace("design: within", "design: between")
client.call("PUT", "/studies/mine", json={"text": between})
people = "/studies/brush-or-object-tool/participants"
ada, lin = client.call("POST", people, json={"count": 2}).json()
print(ada["link"], ada["conditions"])  # the code is in the link, shown once
client.call("GET", people)
client.call("PATCH", f"{people}/1", json={"paused": True})
client.call("PATCH", f"{people}/1", json={"paused": False})
client.call("POST", f"/study/{ada['code']}")
step = client.call("GET", f"/study/{ada['code']}/step").json()
client.call("POST", f"/study/{ada['code']}/step", json={"number": step["number"]})
first = {"kind": "device", "step": 1, "t": 0, "profile": {"agent": "an example"}}
client.call("POST", f"/study/{ada['code']}/log", json={"first": 0, "records": [first]})
results = client.call("GET", "/studies/brush-or-object-tool/results", params={"table": "curves"})
Path("iou.csv").write_bytes(results.content)
client.call("GET", "/studies/brush-or-object-tool/report")
client.call("GET", f"{people}/1/log", params={"format": "csv"})
client.call("GET", f"{people}/1/steps")
print(client.call("POST", f"{people}/1/replay").json()["equal"])
client.call("DELETE", f"{people}/{lin['code']}")
client.call("DELETE", "/studies/mine")

# Client.projects
print(client.projects.all())

# Client.classifiers
print(client.classifiers.all())

# rest
client.call("POST", "/headset-checks")
client.call("DELETE", "/session")

# Client.close
client.close()

# AsyncClient
import asyncio

from pointbrush.client import AsyncClient


async def sizes() -> list[int]:
    async with AsyncClient(url, token) as client:
        juggling = await client["juggling"]
        frames = await asyncio.gather(*(frame.points() for frame in juggling.frames))
        return [len(points["xyz"]) for points in frames]


print(asyncio.run(sizes()))

# AsyncClient.__init__
client = AsyncClient(url, token)

# AsyncClient.close
asyncio.run(client.close())
