"""pointbrush: label point cloud recordings from inside."""

__version__ = "0.1.0"
