"""What the analytic reference answers about one 3D scene."""
