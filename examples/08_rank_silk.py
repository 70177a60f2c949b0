"""Figure 8 of paper A: how many singular values of T hold 90 %, against the sharpness of the light; yarn 1 of silk.

python examples/08_rank_silk.py [out/08_rank_silk.png]
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import glcloth

path = sys.argv[1] if len(sys.argv) > 1 else "out/08_rank_silk.png"
name = "silk_crepe_de_chine"
facts = glcloth.tables_report(name, glcloth.tables_for(name))

figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
# Mirrored tangents have equal ranks: t_1, t_2, t_4, t_5 share a curve, t_3 has its own.
curves = {t["tilt_deg"]: t["ranks"] for t in facts["tangents"] if t["yarn"] == 1 and t["tilt_deg"] <= 0}
for (tilt_deg, ranks), style in zip(curves.items(), ("o-", "s--"), strict=True):
    axis.semilogx(facts["sharpness"][1:], ranks[1:], style, label=f"tilt {tilt_deg:g}°")
axis.set_xlabel(r"$2 / \sigma_k^2$")
axis.set_ylabel(f"singular values for {100 * facts['contribution']:g} %")
axis.set_title(f"{facts['fabric']}, yarn 1")
axis.set_ylim(0)
axis.legend()
figure.savefig(path, dpi=100)
