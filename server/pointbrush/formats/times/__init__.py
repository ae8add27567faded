"""Times of frames: clocks, order, and matching of files to frames."""
