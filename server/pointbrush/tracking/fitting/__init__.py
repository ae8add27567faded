"""Where things are in a frame: searched for, registered, judged."""
