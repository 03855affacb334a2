"""The parts of the window, one control a file."""
