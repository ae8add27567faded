"""REST resources: one module per resource, each with a ``router``."""

from pointbrush.web.routes import (
    annotations,
    boxes,
    checks,
    classifiers,
    edits,
    export,
    frames,
    imports,
    jobs,
    labels,
    meta,
    objects,
    review,
    sequences,
    taxonomy,
    tracking,
)

RESOURCES = (
    meta, sequences, imports, frames, labels, boxes, taxonomy, edits, objects, annotations,
    tracking, classifiers, export, jobs, review, checks,
)  # fmt: skip
