"""The HTTP and WebSocket front: FastAPI app, auth, limits, and the page."""
