"""REST resources: one module per resource, each with a ``router``."""

from pointbrush.web.routes import (
    agreement,
    annotations,
    cameras,
    checks,
    edits,
    export,
    frames,
    imports,
    jobs,
    labels,
    meta,
    objects,
    palette,
    placements,
    report,
    review,
    sequences,
    taxonomy,
    tracking,
)

RESOURCES = (
    meta, sequences, imports, frames, cameras, labels, palette, placements, taxonomy, edits,
    objects, annotations, tracking, export, jobs, review, checks, agreement, report,
)  # fmt: skip
