"""The review panel: labels, the tracker's doubts and how it found them, in a viser page.

``pointbrush.review.open(workspace, sequence)`` opens one from a notebook or a script.
"""

from pointbrush.review.panel import ReviewPanel
from pointbrush.review.panel import open_panel as open

__all__ = ["ReviewPanel", "open"]
