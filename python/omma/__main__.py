"""``python -m omma``: the command line."""

from omma.cli.main import main

main()
