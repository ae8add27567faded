"""REST resources: one module per resource, each with a ``router``."""

from pointbrush.web.routes import (
    annotations,
    checks,
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
    meta, sequences, imports, frames, labels, taxonomy, edits, objects, annotations, tracking,
    export, jobs, review, checks,
)  # fmt: skip
