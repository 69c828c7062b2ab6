#!/usr/bin/python3
"""Tests by name of a fabric that is woven by the stages that the program chooses: what a user adds is [test].

    load_fabric.py BIN SCENE      BIN: folder of simulate_fibers; SCENE: without stages and test, as much warp as weft
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIAXIAL = 'kind = "biaxial"\nwarp_strain = "1 %"\nweft_strain = "1 %"'
UNIAXIAL = 'kind = "uniaxial"\nstrain = "1 %"\ndirection = "weft"\ncycles = 1\nincrements = 5'


class Tests(unittest.TestCase):
    program, scene = pathlib.Path(), pathlib.Path()

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="load_fabric_")
        self.addCleanup(self.folder.cleanup)

    def run_test(self, test, *options, scene=None):
        """Folder of results, and rows of curves.csv of the stage of the test, which `scene` may have another one of."""
        file = pathlib.Path(self.folder.name) / "scene.toml"
        text = (scene or self.scene).read_text().split("[test]")[0]
        file.write_text(text + f"\n[test]\n{test}\n")
        out = file.parent / f"out_{len(list(file.parent.iterdir()))}"
        run = subprocess.run(
            [self.program, file, "--threads", "1", "--out", out, *options],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stdout[-1000:] + run.stderr)
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual(summary["status"], "done")
        self.assertTrue(summary["crossing_order_ok"])
        self.assertLess(summary["max_penetration_over_radius"], 0.05)
        kind = test.split('"')[1]
        with open(out / "curves.csv") as rows:
            return out, [row for row in csv.DictReader(rows) if row["stage"] == kind]

    def test_biaxial_then_the_same_from_the_woven_state(self):
        out, rows = self.run_test(BIAXIAL)
        last = {name: float(value) for name, value in rows[-1].items() if name != "stage"}
        self.assertAlmostEqual(last["warp_strain"], 0.01)
        self.assertGreater(last["warp_force_N"], 100 * float(rows[0]["warp_force_N"]))
        self.assertAlmostEqual(last["warp_force_N"] / last["weft_force_N"], 1, delta=0.01)
        _, again = self.run_test(BIAXIAL, "--start-from", out / "states.h5", "--after", "settle")
        self.assertAlmostEqual(float(again[-1]["warp_force_N"]) / last["warp_force_N"], 1, delta=1e-6)

    def test_uniaxial_is_softer_and_rubs(self):
        _, both = self.run_test(BIAXIAL)
        _, rows = self.run_test(UNIAXIAL)
        forces = [float(row["weft_force_N"]) for row in rows]
        largest, middle = max(forces), len(forces) // 2
        self.assertAlmostEqual(max(float(row["weft_strain"]) for row in rows), 0.01)
        self.assertLess(largest, 0.7 * float(both[-1]["weft_force_N"]))
        self.assertEqual(largest, forces[middle])
        strains = [float(row["weft_strain"]) for row in rows]
        work = sum((f + g) / 2 * (e - d) for d, e, f, g in zip(strains, strains[1:], forces, forces[1:]))
        self.assertGreater(work, 0)  # the loop dissipates
        for there, back in zip(forces[1:middle], reversed(forces[middle + 1 : -1])):
            self.assertLess(back, there)
        self.assertLess(abs(float(rows[-1]["warp_force_N"])), 0.01 * largest)

    def test_pull_out(self):
        _, rows = self.run_test('kind = "pull_out"\nyarn = "warp/2"\ndistance = "100 um"')
        self.assertAlmostEqual(float(rows[-1]["warp/2/end.x_m"]) - float(rows[0]["warp/2/end.x_m"]), 1e-4)
        self.assertGreater(float(rows[-1]["warp/2/end.x_N"]), 0)

    def test_yarn_tension(self):
        _, rows = self.run_test('kind = "yarn_tension"\nyarn = "weft/2"\nstrain = "1 %"')
        pulls = [float(rows[-1][f"weft/2/{end}.y_N"]) for end in ("start", "end")]
        self.assertGreater(pulls[1], 0)
        self.assertLess(pulls[0], 0)

    def test_compaction_then_the_same_from_the_woven_state(self):
        test, cell = 'kind = "compaction"\nstrain = "8 %"\nincrements = 4', self.scene.parent / "cell.toml"
        out, rows = self.run_test(test, scene=cell)
        upper, lower = ([float(row[f"plate/{side}.z_N"]) for row in rows] for side in ("upper", "lower"))
        for thinner, force in zip(upper[1:], upper):
            self.assertLess(thinner, force)  # it pushes down, the more
        self.assertLess(abs(upper[0]), 0.01 * abs(upper[-1]))
        self.assertAlmostEqual(lower[-1] / -upper[-1], 1, delta=1e-4)
        _, again = self.run_test(test, "--start-from", out / "states.h5", "--after", "settle", scene=cell)
        self.assertAlmostEqual(float(again[-1]["plate/upper.z_N"]) / upper[-1], 1, delta=0.01)


if __name__ == "__main__":
    Tests.program = pathlib.Path(sys.argv.pop(1)) / "simulate_fibers"
    Tests.scene = pathlib.Path(sys.argv.pop(1))
    unittest.main()
