"""The default method: the paper's tracker until the object model lands."""

from pointbrush.tracking.paper import PaperTracker


class AutoTracker(PaperTracker):
    """The default tracker."""
