"""Write the values that `glcloth check` compares with, as llvmpipe draws them: glcloth/bench/check.json.

python tests/measure/check_values.py

To be run when a picture of the check is meant to change; the differences to the values before are printed first.
"""

import json

import common
import numpy as np

from glcloth.bench import check
from glcloth.picture.renderer import Renderer


def main():
    common.options(__doc__)
    with Renderer("llvmpipe") as renderer:
        values = {name: check.cell_means(renderer.render(**changes)) for name, changes in check.PICTURES.items()}
    before = json.loads(check.VALUES.read_text()) if check.VALUES.exists() else {}
    common.head("picture", "largest change of a cell, %")
    for name, means in values.items():
        old = np.array(before.get(name, np.full_like(means, np.nan)))
        common.row(name, float(100 * np.abs(old - means).max() / np.abs(means).mean()))
    rows = (f'"{name}": {json.dumps(means.round(6).tolist())}' for name, means in values.items())
    check.VALUES.write_text("{\n" + ",\n".join(rows) + "\n}\n")


if __name__ == "__main__":
    main()
