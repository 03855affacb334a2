"""Fields as pictures: arrays in, RGBA arrays and outlines out; no Qt."""
