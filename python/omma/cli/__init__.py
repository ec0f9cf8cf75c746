"""The command `omma`, a file for each group of its commands.

`parameters` is how options are declared, `help` what ``--help`` prints, `typed` how messages name
options, `numbers` how numbers are read.
"""
