"""The tests that textile engineers do, by name, on a fabric: curves in the units of the field, and whether physics holds.

A fabric is a scene with a [weave]. A patch is pulled both ways and one way, bent, sheared, indented, a yarn is drawn out of it, a yarn is
pulled, and it is pressed; a periodic cell is pulled, sheared to both sides and pressed. Each test is a [test] of a
scene of its own.
"""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .figures import plot_ways, warp_colour
from .programs import run_scene

_patch = {"biaxial": {"kind": "biaxial", "warp_strain": "1 %", "weft_strain": "1 %"},
          "uniaxial": {"kind": "uniaxial", "strain": "2 %"},
          "bending": {"kind": "bending", "curvature": "1 mm-1"},
          "shear": {"kind": "shear", "angle": "10 deg"}, "shear back": {"kind": "shear", "angle": "-10 deg"},
          "indentation": {"kind": "indentation", "radius": "150 um", "depth": "10 um"},
          "pull-out": {"kind": "pull_out", "yarn": "warp/1", "distance": "50 um"},
          "yarn tension": {"kind": "yarn_tension", "yarn": "warp/1", "strain": "1 %"},
          "compaction": {"kind": "compaction", "strain": "5 %"}}
_cell = {"biaxial": _patch["biaxial"], "uniaxial": _patch["uniaxial"],
         "shear": {"kind": "shear", "strain": "10 %"}, "shear back": {"kind": "shear", "strain": "-10 %"},
         "compaction": _patch["compaction"]}
# What is the curve of a test, from SI to the units of its labels.
_measured = {"bending": ("bending", 1e-3, 1e3, ("curvature (1/mm)", "moment per width (mN)")),
             "indentation": ("indentation", 1e6, 1e3, ("depth (µm)", "force (mN)")),
             "compaction": ("plates", 1e6, 1e-3, ("plates closed in (µm)", "pressure (kPa)"))}
names = list(dict.fromkeys([*_patch, *_cell]))


@dataclass
class Test:
    """A test that was run: its curve, there and back, and what must hold of it, as `name: (value, least, most)`."""

    fabric: str
    name: str
    run: object
    motion: np.ndarray
    force: np.ndarray
    motion_label: str
    force_label: str
    must_hold: dict = field(default_factory=dict)

    def failures(self):
        """What does not hold, in words."""
        return [f"{self.fabric}, {self.name}: {what} is {value:.3g}, must be {least:g} to {most:g}"
                for what, (value, least, most) in self.must_hold.items() if not least <= value <= most]

    @property
    def turn(self):
        """Where it turns back."""
        return int(np.argmax(np.abs(self.motion)))

    @property
    def loop(self):
        """Work that is not given back, over the work there."""
        ways = slice(None, self.turn + 1), slice(self.turn, None)
        there, back = (np.trapz(self.force[way], self.motion[way]) for way in ways)
        return (there + back) / abs(there)


def tests_of(scene):
    """Names and [test] of what can be done to a fabric."""
    return _cell if scene["weave"].get("periodic") is True else _patch


def run_tests(fabric, folder, increments=10, threads=None, wanted=None):
    """Runs the tests of a fabric, a TOML file, each in a folder of its own, there and back. `wanted`: names of those that
    are, all by default. Returns a list of Test."""
    fabric = Path(fabric)
    scene = tomllib.loads(fabric.read_text())
    name = fabric.stem
    results = []
    for test, keys in tests_of(scene).items():
        if wanted is not None and test not in wanted:
            continue
        own = scene | {"test": keys | {"increments": increments, "cycles": 1}}
        if "stage" in own:  # of a scene with tests of its own, what weaves
            own["stage"] = [stage for stage in own["stage"] if stage["name"] in ("separate", "relax", "settle")]
        run = run_scene(own, Path(folder) / name / test.replace(" ", "_"), threads=threads)
        results.append(_evaluated(name, test, keys, run))
    both = {test.name: test for test in results}
    if "shear" in both and "shear back" in both:
        to, fro = (np.abs(both[t].force).max() for t in ("shear", "shear back"))
        both["shear back"].must_hold["peak over that to the other side"] = (fro / to, 0.9, 1.1)
    return results


def _evaluated(fabric, name, keys, run):
    stage = keys["kind"]
    table = run.curves()
    table = table[table["stage"] == stage].reset_index(drop=True)
    widths = run.widths()
    percent, per_warp = 100, 1 / widths[0]
    if stage in ("biaxial", "uniaxial"):
        motion, force = percent * table["warp_strain"], per_warp * table["warp_force_N"]
        labels = "warp strain (%)", "warp force per width (N/m)"
    elif stage == "shear" and "angle" in keys:
        curve = run.curve("shear").stage(stage).table
        motion, force = np.degrees(curve["motion"]), curve["reaction"]
        labels = "shear angle (°)", "shear force per length (N/m)"
    elif stage == "shear":
        motion = np.degrees(np.arctan(table["cell/weft.x_m"] / widths[0]))
        force, labels = table["cell/weft.x_N"] / widths[1], ("shear angle (°)", "shear force per width (N/m)")
    elif stage in _measured:
        name, per_motion, per_force, labels = _measured[stage]
        curve = run.curve(name).stage(stage).table
        motion, force = per_motion * curve["motion"], per_force * curve["reaction"]
    else:
        motion, force = 1e6 * table[f"{keys['yarn']}/end.x_m"], 1e3 * table[f"{keys['yarn']}/end.x_N"]
        labels = "motion of the yarn's end (µm)", "force (mN)"
    motion, force = motion.to_numpy(), force.to_numpy()
    test = Test(fabric, name, run, motion - motion[0], force, *labels)
    energy = run.summary()["energy"]
    work = abs(energy["work"]["bodies"]) + energy["stored"] + energy["friction"]
    at_turn = test.force[test.turn]
    test.must_hold |= {
        "force at the turn along the motion": (at_turn * np.sign(test.motion[test.turn]), 1e-12, np.inf),
        "force at the start over that at the turn": (abs(test.force[0] / at_turn), 0, 0.1),
        # Contacts that are made stiffer on the way bring some work in, which is booked; what is only rubbed takes twice.
        "loop over the work there": (test.loop, -0.05, 2),
        "imbalance of energy over what was turned over": (abs(energy["imbalance"]) / work, 0, 0.05),
        "forces of all bodies over the largest": (_unbalanced(run, stage), 0, 0.01)}
    return test


def _unbalanced(run, stage):
    """Forces of all bodies that hold fibers, in the state in the middle of the test: their sum over the largest of
    them."""
    states = run.states()
    inside = states.index[states["stage"] == stage]
    bodies = run.bodies(int(inside[len(inside) // 2 - 1]))
    bodies = bodies[~bodies["name"].str.startswith(("side/", "cell/"))]
    if bodies.empty:
        return 0.0
    forces = bodies[["force_x", "force_y", "force_z"]].to_numpy()
    return float(np.linalg.norm(forces.sum(axis=0)) / np.linalg.norm(forces, axis=1).max())


def page(tests, figure):
    """Draws all tests into a figure of matplotlib: a row for each fabric; the way there solid, the way back dashed."""
    fabrics = list(dict.fromkeys(test.fabric for test in tests))
    rows = {fabric: [test for test in tests if test.fabric == fabric] for fabric in fabrics}
    grid = figure.subplots(len(rows), max(map(len, rows.values())), squeeze=False)
    for axes_row, (fabric, row) in zip(grid, rows.items()):
        for axes in axes_row[len(row):]:
            axes.set_axis_off()
        for axes, test in zip(axes_row, row):
            plot_ways(axes, test.motion, test.force, color=warp_colour)
            axes.set_title(f"{fabric}: {test.name}\nlost in the loop: {test.loop:.0%} of the work", fontsize=9)
            axes.set_xlabel(test.motion_label)
            axes.set_ylabel(test.force_label)
    figure.set_size_inches(4 * grid.shape[1], 3.4 * grid.shape[0])
    figure.tight_layout()
