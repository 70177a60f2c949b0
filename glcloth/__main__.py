"""`python -m glcloth` is the same as `glcloth`."""

from .cli import main

main()
