"""Recordings and labels that come in: previews, import jobs, uploads, allowed folders."""
