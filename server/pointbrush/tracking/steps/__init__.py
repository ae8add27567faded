"""Steps of the tracker, one after the other in each frame."""
