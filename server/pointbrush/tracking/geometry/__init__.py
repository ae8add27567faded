"""Points and pixels by themselves: nearest ones, grids, components, paths, registration."""
