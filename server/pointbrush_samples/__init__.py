"""Seeded generators of scenes with ground truth that only tests and benchmarks use."""
