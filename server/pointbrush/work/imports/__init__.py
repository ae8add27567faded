"""Import of recordings and labels: previews, jobs, uploads, allowed folders."""
