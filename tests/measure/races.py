"""Each pass of the trees and of the tracer twice from the same memory: where do the bits differ? And on poisoned memory.

python tests/measure/races.py [--triangles 12786] [--size 160] [--times 3] [--device 0]
"""

import common
import double_runs as races
import numpy as np

from glcloth.gpu.context import create_context


def main():
    chosen = common.options(__doc__, triangles=12786, size=160, times=3, device="0")
    ctx = create_context(chosen.device)
    print(ctx.info["GL_RENDERER"])
    common.head("structure", "pass", "dispatches", "that differ", "why they may")
    for accelerator, make in races.works(ctx, chosen.triangles, (chosen.size, chosen.size)).items():
        with make() as work:
            work.run()
            clean, total = work.result(), {}
            for _ in range(chosen.times):
                for path, (runs, differ) in races.twice(work.run).items():
                    before = total.get(path, (0, 0))
                    total[path] = before[0] + runs, before[1] + differ
            for path, (runs, differ) in total.items():
                common.row(accelerator, path, runs, differ, races.PLACED.get(path, "" if not differ else "A RACE"))
            for byte in (0x00, 0x7F, 0xFF):
                work.poison(byte)
                work.run()
                wrong = [name for name, array in work.result().items() if not np.array_equal(array, clean[name])]
                common.row(accelerator, f"all, memory of {byte:#x}", "", ", ".join(wrong) or "none", "")


if __name__ == "__main__":
    main()
