"""REST resources: one module per resource, each with a ``router``."""

from pointbrush.web.routes import (
    annotations,
    boxes,
    classifiers,
    edits,
    events,
    export,
    frames,
    headset_checks,
    imports,
    jobs,
    labels,
    masks,
    meta,
    objects,
    people,
    sensors,
    sequences,
    studies,
    taxonomy,
    tracking,
)
from pointbrush.web.routes.team import (
    accounts,
    agreement,
    checks,
    projects,
    review,
    snapshots,
    tasks,
    webhooks,
)

RESOURCES = (
    edits, meta, sequences, imports, frames, labels, boxes, taxonomy, events, objects,
    annotations, masks, people, sensors, tracking, classifiers, export, jobs, review, checks,
    projects, tasks, snapshots, agreement, webhooks, accounts, headset_checks, studies,
)  # fmt: skip
"""In the order of matching: strokes first, because they are by far the most frequent calls."""
