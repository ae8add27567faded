"""Classifiers of a workspace, taught by what people painted: kept, asked, applied."""

PREDICT = "prediction"
"""Of a job's request: a classifier applied to frames."""
