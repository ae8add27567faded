"""State that viewers of a server share: packed frames, presence, job status, their caches."""
