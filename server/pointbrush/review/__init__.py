"""The review panel: labels and the tracker's doubts, frame by frame, in a viser page."""
