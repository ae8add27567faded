"""People in colour pictures: searched frame by frame, previewed, and labelled as one edit."""

FIND = "people"
"""Call in the request of a job that labels people."""
