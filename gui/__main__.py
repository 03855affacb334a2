"""`python -m gui`."""

from gui.application import main

main()
