"""`auto-next`: tracking by one labelling energy per frame."""
