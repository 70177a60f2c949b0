"""Make the tables of the paper method: python tables/generate.py FABRIC... [--grid 48 --contribution 0.9 --json -o DIR].

The same as `glcloth tables`. Without -o the tables go to the cache only, where `--method paper` finds them.
"""

import sys

from glcloth.cli import main

main(["tables", *sys.argv[1:]])
