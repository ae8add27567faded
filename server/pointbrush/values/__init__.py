"""Values of REST: each is defined once, for the server, the client, the page and the references.

A value is a frozen dataclass.  FastAPI validates bodies and describes answers with it, the client
returns it, and ``python -m pointbrush.typescript --write`` writes its TypeScript interface.
"""
