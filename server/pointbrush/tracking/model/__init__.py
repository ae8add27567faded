"""What is known of a track."""
