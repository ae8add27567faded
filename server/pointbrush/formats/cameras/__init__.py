"""Pictures of cameras and depth images."""
