"""The benchmarks; a package, as some versions of pyarrow install one of this name."""
