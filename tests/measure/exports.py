"""How far exported fabrics are from the original: a row for each fabric and format.

python tests/measure/exports.py [--fabrics linen,velvet,...] [--formats .glb,.mtlx,.u3m]

Columns: mean and 95th percentile of |difference| of luminance, % of the original's mean, under the built-in studio turned in
all ways and under single suns from everywhere; seconds of CPU. A .zip has the errors of a .glb, a .u3ma those of a .u3m.
"""

import tempfile
import time
from pathlib import Path

import common

from glcloth.export.files import export


def main():
    options = common.options(
        __doc__,
        fabrics=["linen", "silk_crepe_de_chine", "satin_charmeuse_front", "velvet", "denim_raw", "sheer_voile"],
        formats=[".glb", ".mtlx", ".u3m"],
    )
    common.head("fabric", "format", "studio mean", "95 %", "suns mean", "95 %", "s")
    with tempfile.TemporaryDirectory() as folder:
        for fabric in options.fabrics:
            for suffix in options.formats:
                begin = time.process_time()
                done = export(fabric, Path(folder) / f"a{suffix}")
                spent = time.process_time() - begin
                if isinstance(done.errors, str):
                    common.row(fabric, suffix, done.errors)
                else:
                    common.row(fabric, suffix, *done.errors.studio, *done.errors.sun, spent)


main()
