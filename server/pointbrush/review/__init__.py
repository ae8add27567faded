"""The review panel: labels, doubtful tracks and their explanation, in a viser page.

``pointbrush.review.open(workspace, sequence)`` opens one from a notebook or a script.
"""

from pointbrush.review.panel import ReviewPanel
from pointbrush.review.panel import open_panel as open

__all__ = ["ReviewPanel", "open"]
