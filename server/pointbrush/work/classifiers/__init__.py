"""Classifiers of a workspace, trained on painted points: storage, prediction and jobs."""

PREDICT = "prediction"
"""Call in the request of a job that applies a classifier to frames."""
