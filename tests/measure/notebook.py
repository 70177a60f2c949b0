"""A notebook, executed: `glcloth.show` under a cell, an edit from its page, the fabric that comes back.

python tests/measure/notebook.py   (pip install ipykernel nbclient)
"""

import time

import nbformat
from nbclient import NotebookClient

CELLS = (
    "import time\nbegin = time.perf_counter()\nimport glcloth\nview = glcloth.show(fabric='linen', size=(320, 240))\n"
    "print(f'live after {time.perf_counter() - begin:.1f} s')",
    "import json, urllib.request\nroot, token = view.address.split('?token=')\n"
    "wish = json.dumps({'group': 'warp', 'name': 'gamma_s_deg', 'value': 33}).encode()\n"
    "_ = urllib.request.urlopen(f'{root}edit?token={token}', wish)\n"
    "assert view.fabric.yarn[0].gamma_s_deg == 33",
    "with glcloth.Renderer() as renderer:\n    picture = renderer.render(view.scene)\npicture",
    "view.close()\nglcloth.show(fabric='linen', size=(64, 48), live=False)",
)


def main():
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    begin = time.perf_counter()
    NotebookClient(notebook, timeout=200).execute()
    live, _, picture, still = ([output for output in cell.outputs] for cell in notebook.cells)
    assert any("<iframe" in output.get("data", {}).get("text/html", "") for output in live)
    assert "image/png" in picture[-1].data and "image/png" in still[-1].data
    print(live[-1].text.strip(), f"; executed in {time.perf_counter() - begin:.1f} s")


main()
