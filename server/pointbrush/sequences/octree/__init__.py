"""Order, grids and chunks of the additive octree, in memory and streamed for large frames."""
