"""Review: states, notes, assignments of frames, checks, agreement, a report."""

from __future__ import annotations

from pointbrush.values.team.review import Agreement, BoxAgreement, Checked, Finding
from pointbrush.work.reviewing.checks.finding import KINDS, Kind
from pointbrush.work.reviewing.comparing import By
from pointbrush.work.reviewing.report.gather import TABLES, Table, to_csv
from pointbrush.work.reviewing.report.html import POLICY, to_html
from pointbrush.work.reviewing.reviewing import Reviewing
from pointbrush.work.reviewing.states import STATES, Overview, Standing, State

__all__ = [
    "KINDS",
    "POLICY",
    "STATES",
    "TABLES",
    "Agreement",
    "BoxAgreement",
    "By",
    "Checked",
    "Finding",
    "Kind",
    "Overview",
    "Reviewing",
    "Standing",
    "State",
    "Table",
    "to_csv",
    "to_html",
]
