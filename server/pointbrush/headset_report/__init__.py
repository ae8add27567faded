"""Reports of "Check this headset": the tested features of a headset, as a file and as text."""
