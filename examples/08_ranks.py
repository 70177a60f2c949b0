"""Figures 8 and 9 of paper A: how many singular values of T hold 90 %, against the sharpness of the light; yarn 1.

python examples/08_ranks.py [silk_crepe_de_chine] [out/08_ranks.png]  (figure 9: satin_charmeuse_back)
"""

import sys

from common import needs, output

needs("matplotlib", "plots")
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import glcloth

name = sys.argv[1] if len(sys.argv) > 1 else "silk_crepe_de_chine"
path = output(sys.argv[2] if len(sys.argv) > 2 else "out/08_ranks.png")
facts = glcloth.tables_report(name, glcloth.tables_for(name))

figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
# Mirrored tangents have equal ranks: t_1, t_2, t_4, t_5 of silk share a curve; of satin t_1 to t_4, and t_5 to t_8.
curves = {t["tilt_deg"]: t["ranks"] for t in facts["tangents"] if t["yarn"] == 1 and t["tilt_deg"] <= 0}
for (tilt_deg, ranks), style in zip(curves.items(), ("o-", "s--"), strict=True):
    axis.semilogx(facts["sharpness"][1:], ranks[1:], style, label=f"tilt {tilt_deg:g}°")
axis.set_xlabel(r"$2 / \sigma_k^2$")
axis.set_ylabel(f"singular values for {100 * facts['contribution']:g} %")
axis.set_title(f"{facts['fabric']}, yarn 1")
axis.set_ylim(0)
axis.legend()
figure.savefig(path, dpi=100)
print(path)
