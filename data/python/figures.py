#!/usr/bin/python3
"""Figures of a run of a weave: curves, sections of a yarn before and after, where yarns press on each other.

    data/python/figures.py results/plain_small pictures
"""

# %% What is looked at
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parent))
import trame
from trame import figures

if len(sys.argv) != 3:
    sys.exit(__doc__)
run, out = trame.open_run(sys.argv[1]), Path(sys.argv[2])
out.mkdir(parents=True, exist_ok=True)
stages = list(dict.fromkeys(run.states()["stage"]))[1:]  # without the reference
print(run.states().tail())

# %% Curves: force per width of the fabric over strain, in the stages that strain the sides
fig, ax = plt.subplots(figsize=(6, 4))
table = run.curves()
if "warp_strain" in table:
    strained = table[(table["warp_strain"] != 0) | (table["weft_strain"] != 0)]["stage"].unique()
    for side, colour in (("warp", figures.warp_colour), ("weft", figures.weft_colour)):
        curve = run.curve(f"{side} sides")
        curve.table = curve.table[curve.table["stage"].isin(strained)].reset_index(drop=True)
        if (curve.table["motion"] == 0).all():  # held: over the strain of the others
            curve.table["motion"] = run.curve("warp sides").table["motion"][table["stage"].isin(strained)].to_numpy()
            curve.name += ", over the warp strain"
        figures.plot_curve(ax, curve, color=colour)
else:
    for branch in run.branches().sort_values("work", ascending=False)["curve"].unique()[:4]:
        figures.plot_curve(ax, run.curve(branch))
ax.legend()
fig.savefig(out / "curves.png", dpi=150, bbox_inches="tight")
print(run.branches().to_string())

# %% Sections of the largest yarn, at quarters of its length, in the reference and in the last state
yarns = run.yarns().sort_values("n_fibers", ascending=False)
yarn = yarns.iloc[0]
fig, axs = plt.subplots(3, 2, figsize=(7, 6), sharex=True, sharey=True)
for row, at in zip(axs, (0.25, 0.5, 0.75)):
    for ax, state, name in zip(row, (0, -1), ("reference", "last state")):
        figures.plot_cut(ax, run.cut(yarn["name"], at, state), facecolor=figures.colours[yarn["family"]])
        ax.set_title(f"{yarn['name']} at {at:.0%}, {name}", fontsize=9)
for ax in axs.flat:
    ax.label_outer()
fig.savefig(out / "sections.png", dpi=150, bbox_inches="tight")

# %% Where yarns press on each other
fig, ax = plt.subplots(figsize=(6, 5))
figures.plot_contact_pressure(ax, run, between_yarns=len(yarns) > 1)
fig.savefig(out / "contact_pressure.png", dpi=150, bbox_inches="tight")
