"""One frame as its sensor sees it, and how that sensor moves."""
