"""Steps of the tracker in each frame."""
