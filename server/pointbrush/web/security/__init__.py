"""Authentication, roles, sign-in and TLS of the server."""
