"""The report of a recording as HTML with plots and as CSV."""
