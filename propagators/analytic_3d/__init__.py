"""The exact reference in three dimensions."""
