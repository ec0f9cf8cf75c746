"""``python -m omma``: the command line."""

from omma.cli import main

main()
