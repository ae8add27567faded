"""What is known of one label on its way through a recording."""
