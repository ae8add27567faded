"""Review: states, notes, assignments of frames, checks, agreement, a report."""
