"""What the desktop knows and does, without Qt: tested without an application."""
