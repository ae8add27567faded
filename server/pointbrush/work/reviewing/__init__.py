"""Review: states and notes, who does which frames, checks, agreement, a report."""

from __future__ import annotations

from pointbrush.work.reviewing.reviewing import Reviewing
from pointbrush.work.reviewing.states import STATES, Overview, Standing, State

__all__ = ["STATES", "Overview", "Reviewing", "Standing", "State"]
