"""The desktop's floor: it may import everything below, and nothing imports it."""
