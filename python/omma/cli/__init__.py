"""The command `omma`, a file for each group of its commands."""
