"""Pictures of a run with matplotlib: each function draws into axes that it is given."""

import numpy as np

warp_colour, weft_colour, free_colour = "#3b75af", "#d5813a", "#5a9e6f"
colours = {"warp": warp_colour, "weft": weft_colour, "free": free_colour}

_shown = {"1": (100, "%"), "m": (1e6, "µm"), "rad": (180 / np.pi, "°"), "N": (1e3, "mN"), "N/m": (1, "N/m"),
          "N m": (1e6, "µN m")}


def _ways(motion):
    """Parts of a curve whose motion goes one way, as slices that share their ends."""
    steps = np.sign(np.diff(motion))
    first = 0
    for i in range(1, len(steps) + 1):
        if i == len(steps) or steps[i] * steps[first] < 0:
            yield slice(first, i + 1)
            first = i


def plot_ways(axes, motion, reaction, **line):
    """Reaction over motion; the way there solid, the way back dashed."""
    for part in _ways(motion):
        back = abs(motion[part][-1]) < abs(motion[part][0])
        drawn, = axes.plot(motion[part], reaction[part], "--" if back else "-", marker=".", **line)
        line |= {"label": None, "color": drawn.get_color()}
    axes.grid(alpha=0.3)


def plot_curve(axes, curve, **line):
    """A curve, in the units of the field."""
    (a, motion_unit), (b, reaction_unit) = _shown[curve.motion_unit], _shown[curve.reaction_unit]
    plot_ways(axes, a * curve.table["motion"].to_numpy(), b * curve.table["reaction"].to_numpy(),
              **{"label": curve.name} | line)
    what = {"1": "strain", "m": "motion", "rad": "turn"}[curve.motion_unit]
    axes.set_xlabel(f"{what} ({motion_unit})")
    axes.set_ylabel(f"{'moment' if curve.reaction_unit == 'N m' else 'force'} ({reaction_unit})")


def plot_cut(axes, cut, **circle):
    """A section of a yarn: its fibers as circles, in µm."""
    from matplotlib.patches import Circle

    circle = {"facecolor": free_colour, "edgecolor": "white", "linewidth": 0.5} | circle
    for fiber in cut.itertuples():
        axes.add_patch(Circle((1e6 * fiber.across, 1e6 * fiber.up), 1e6 * fiber.radius, **circle))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_xlabel("across (µm)")
    axes.set_ylabel("up (µm)")


def plot_contact_pressure(axes, run, state=-1, between_yarns=True):
    """Touches from above, where fibers press on each other: fiber axes as lines, normal force per length in colour."""
    names = run.yarns()
    for yarn in names.itertuples():
        for fiber in run.fibers(yarn.Index, state):
            axes.plot(1e6 * fiber.r[:, 0], 1e6 * fiber.r[:, 1], color=colours[yarn.family], lw=0.4, alpha=0.5)
    touches = run.contacts(state)
    touches = touches[(touches["normal_force"] > 0) & (touches["length"] > 0)]
    if between_yarns:
        touches = touches[touches["yarn_a"] != touches["yarn_b"]]
    touches = touches.sort_values("pressure")
    dots = axes.scatter(1e6 * touches["position_x"], 1e6 * touches["position_y"], c=1e-6 * touches["pressure"], s=14,
                        cmap="inferno_r", zorder=3)
    axes.set_aspect("equal")
    axes.set_xlabel("x (µm)")
    axes.set_ylabel("y (µm)")
    axes.figure.colorbar(dots, ax=axes, label="contact pressure (MPa)")
