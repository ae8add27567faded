"""Reports of "Check this headset": what a headset was found to do, as a file and in words."""
