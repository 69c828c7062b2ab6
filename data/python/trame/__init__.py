"""Runs of Trame as numpy arrays and pandas tables, and new runs from dictionaries.

    import trame
    run = trame.open_run("results/plain_small")
    run.curves()            # pandas: every increment; units in attrs["units"]
    run.fibers("warp/1")    # the fibers of a yarn, as arrays
    run.contacts()          # pandas: touches of fibers in the last state
    run.cut("warp/1", at=0.5)

    trame.run_scene(scene, "results/mine")                   # scene: a dict as the TOML holds it
    trame.study(scene, {"contact.friction_coefficient": [0.1, 0.3]}, "results/friction")

All numbers are in SI units. Nothing here computes what the programs compute: it reads and arranges.
"""

from .curves import Curve, Table, read_table
from .programs import ProgramFailed, program, run_scene, study
from .run import Fiber, Run, open_run
from .scene import changed, length_of, scene_text

__all__ = ["Curve", "Fiber", "ProgramFailed", "Run", "Table", "changed", "length_of", "open_run", "program",
           "read_table", "run_scene", "scene_text", "study"]
