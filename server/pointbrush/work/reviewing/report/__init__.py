"""A report of a recording: what is gathered, as HTML with plots and as CSV."""
