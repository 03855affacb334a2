"""`python -m gui`."""

from gui.application import main

if __name__ == "__main__":  # helper processes import this file too
    main()
