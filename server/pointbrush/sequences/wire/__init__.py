"""The coding of points for the socket: quantised positions, colours and fields in chunks."""
