"""REST resources: one module per resource, each with a ``router``."""

from pointbrush.web.routes import (
    agreement,
    annotations,
    boxes,
    checks,
    classifiers,
    edits,
    events,
    export,
    frames,
    imports,
    jobs,
    labels,
    meta,
    objects,
    projects,
    review,
    sequences,
    snapshots,
    tasks,
    taxonomy,
    tracking,
    webhooks,
)

RESOURCES = (
    meta, sequences, imports, frames, labels, boxes, taxonomy, edits, events, objects,
    annotations, tracking, classifiers, export, jobs, review, checks, projects, tasks,
    snapshots, agreement, webhooks,
)  # fmt: skip
