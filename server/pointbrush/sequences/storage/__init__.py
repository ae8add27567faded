"""Files of a recording: manifest, arrays, checksums, and caches in memory or of a bucket."""
