"""`python -m contiga`: the command line."""

from contiga.cli import main

main()
