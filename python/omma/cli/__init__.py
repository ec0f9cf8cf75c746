"""The command `omma`, a file for each group of its commands.

`help` is what ``--help`` prints, `typed` how messages name options, `numbers` how numbers are read.
"""
