#!/usr/bin/python3
"""The judge on states that are right, and on the same states with one thing made wrong: each is found by the
check it belongs to.

    judge_test.py BIN      BIN: folder of simulate_fibers
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import h5py  # noqa: E402
import numpy as np  # noqa: E402
from judge import verdict  # noqa: E402
from scene_text import Scene  # noqa: E402
from states import Mesh, State  # noqa: E402

TIGHT = {"force_tolerance": 1e-9, "geometry_tolerance": 1e-7, "max_geometry_updates": 20}
R = 10.0


def crossing(model, turn=0.0):
    """A fiber pressed on another one and dragged over it."""
    scene = Scene("crossing")
    scene.material("m", 1e9, 0.3)
    scene.fiber_type("f", "m", R, model)
    scene.solver = TIGHT
    scene.contact["friction_coefficient"] = 0.3
    for name, points in (
        ("under", [(-200, 0, 0), (200, 0, 0)]),
        (
            "over",
            [
                (-200 * np.sin(turn), -200 * np.cos(turn), 20.1),
                (200 * np.sin(turn), 200 * np.cos(turn), 20.1),
            ],
        ),
    ):
        scene.fiber(name, "f", points, 10)
        scene.body(name, (0, 0, points[0][2]), [(name, "start"), (name, "end")])
    scene.stage("press", 3, [("over", "z", "displacement", -0.5 * R)])
    scene.stage("drag", 5, [("over", "x", "displacement", 0.5 * R)])
    return scene


def loop():
    """A loop that touches itself where it crosses."""
    scene = Scene("loop")
    scene.material("m", 1e9, 0.3)
    scene.fiber_type("f", "m", R, "enriched")
    scene.solver = TIGHT
    scene.effects = {"self_contact": True, "friction": False}
    points = [
        (150 * np.sin(a), 150 * (1 - np.cos(a)), 21 * (a / (2 * np.pi) - 0.5))
        for a in np.linspace(0, 2 * np.pi, 25)
    ]
    points = [(-200, 0, -10.5)] + points + [(200, 0, 10.5)]
    scene.fiber("loop", "f", points, 40)
    scene.body("left", points[0], [("loop", "start")])
    scene.body("right", points[-1], [("loop", "end")])
    scene.stage("press", 8, [("right", "z", "displacement", -3 * R)])
    return scene


def weave():
    """A weave without stages, of named yarns: two rods beside each other, and a beam of another radius."""
    return """title = "weave"
[material.m]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.3
[fiber_type.thin]
material = "m"
diameter = "20 um"
model = "rod"
[fiber_type.thick]
material = "m"
diameter = "30 um"
model = "enriched"
[yarn.A]
fiber_type = "thin"
fibers = 2
[yarn.B]
fiber_type = "thick"
fibers = 1
[weave]
pattern = "plain"
[weave.warp]
order = "B A"
yarns = 3
sett = "60 per cm"
[weave.weft]
order = "A"
yarns = 2
sett = "60 per cm"
[solver]
force_tolerance = 1e-9
"""


def cell():
    """The same as a periodic cell, stretched along the warp."""
    scene = weave().replace("[weave]", "[weave]\nperiodic = true").replace("yarns = 3", "yarns = 2")
    return scene + '[test]\nkind = "biaxial"\nwarp_strain = 0.01\nincrements = 2\n'


class Judge(unittest.TestCase):
    binary = pathlib.Path()

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="judge_"))
        cls.states = {}
        for name, scene in (
            ("rods", crossing("rod").text()),
            ("beams", crossing("enriched", 0.3).text()),
            ("loop", loop().text()),
            ("weave", weave()),
            ("cell", cell()),
        ):
            file = cls.folder / f"{name}.toml"
            file.write_text(scene)
            subprocess.run(
                [cls.binary, file, "--threads", "1", "--out", cls.folder / name],
                check=True,
                capture_output=True,
            )
            cls.states[name] = cls.folder / name / "states.h5"

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def found(self, name, change=None):
        """The checks that complain about a state after a change of its file."""
        copy = self.folder / "changed.h5"
        shutil.copy(self.states[name], copy)
        if change:
            with h5py.File(copy, "r+") as file:
                change(file, int(file["n_increments"][()]) - 1)
        with h5py.File(copy, "r") as file:
            return {check for check, complaints in verdict(file).items() if complaints}

    @staticmethod
    def pressing(file, i):
        """Rows of the contacts that press."""
        a = int(file["contacts/first"][i])
        rows = np.arange(a, a + int(file["contacts/count"][i]))
        return rows[file["contacts/normal_force"][rows] > 0]

    def test_right_states_are_right(self):
        for name, states in self.states.items():
            with h5py.File(states, "r") as file:
                for i in range(int(file["n_increments"][()])):
                    with self.subTest(name, increment=i):
                        wrong = {k: v for k, v in verdict(file, i).items() if v}
                        self.assertEqual(wrong, {})

    def test_there_is_contact_and_friction(self):
        for name in self.states:
            with h5py.File(self.states[name], "r") as file:
                self.assertGreater(len(self.pressing(file, int(file["n_increments"][()]) - 1)), 0, name)

    @staticmethod
    def sink(file, i, depth=0.04):
        """Lets the fibers go into each other, farther than contact would: in equilibrium they only touch."""
        r, first = file["fibers/r"], file["mesh/first_node"][:]
        if len(first) > 2:
            r[i, first[1] : first[2], 2] -= depth * R * 1e-6
        else:
            r[i, :, 2] = r[i, :, 2] * (1 - depth / 2)

    def test_missing_contact(self):
        def remove(file, i):
            file["contacts/count"][i] = 0

        def remove_and_sink(file, i):
            remove(file, i)
            self.sink(file, i)

        for name in ("rods", "beams", "loop"):
            with self.subTest(name):
                self.assertIn("fibers", self.found(name, remove))
                self.assertLessEqual({"contacts", "fibers"}, self.found(name, remove_and_sink))
                self.assertNotIn("contacts", self.found(name, self.sink))

    def test_contact_elsewhere(self):
        def move(file, i):
            file["contacts/s_a"][self.pressing(file, i)] = 1e-5
            self.sink(file, i)

        self.assertIn("contacts", self.found("rods", move))

    def test_contact_across_a_gap(self):
        def part(file, i):
            file["contacts/gap"][self.pressing(file, i)] = np.float32(0.03 * R * 1e-6)

        for name in ("rods", "beams", "loop"):
            with self.subTest(name):
                self.assertEqual(self.found(name, part), {"friction"})

    def test_force_of_a_body(self):
        def more(file, i):
            file["bodies/force"][i, 0, 2] *= 1.1

        self.assertEqual(self.found("rods", more), {"groups"})
        self.assertEqual(self.found("beams", more), {"groups"})

    def test_moment_of_a_body(self):
        def more(file, i):
            file["bodies/moment"][i, 0, 0] += 0.3 * R * 1e-6 * np.abs(file["bodies/force"][i, 0]).max()

        self.assertEqual(self.found("rods", more), {"groups"})

    def test_shape_that_is_no_equilibrium(self):
        def bend(file, i):
            file["fibers/r"][i, 6, 2] += 1e-3 * R * 1e-6

        self.assertEqual(self.found("rods", bend), {"fibers"})
        self.assertEqual(self.found("beams", bend), {"fibers"})

    def test_contact_force_that_elastic_forces_do_not_balance(self):
        def less(file, i):
            rows = self.pressing(file, i)
            file["contacts/normal_force"][rows] *= np.float32(0.8)

        self.assertLessEqual({"groups", "fibers"}, self.found("beams", less))
        self.assertIn("fibers", self.found("loop", less))

    def test_friction_beyond_coulomb(self):
        def rub(file, i):
            rows = self.pressing(file, i)
            file["contacts/friction_force"][rows] *= np.float32(1.2)

        self.assertIn("friction", self.found("rods", rub))

    def test_pulling_contact(self):
        def pull(file, i):
            file["contacts/normal_force"][self.pressing(file, i)] *= np.float32(-1)

        self.assertIn("friction", self.found("rods", pull))

    def test_yarns_of_a_weave_have_the_fibers_of_their_kinds(self):
        """Warp B A B, weft A A; which fibers are rods goes by the stage, too."""
        with h5py.File(self.states["weave"], "r") as file:
            mesh, n = Mesh(file), int(file["n_increments"][()])
            thick, thin = ("thick",), ("thin", "thin")
            kinds = [mesh.fiber_table(f)[1] for f in range(mesh.n_fibers)]
            self.assertEqual(kinds, [*thick, *thin, *thick, *thin, *thin])
            self.assertEqual({round(r * 1e6) for r in mesh.radius}, {10, 15})
            stages = [State(file, i, mesh) for i in range(1, n)]
        self.assertEqual(list(dict.fromkeys(s.stage for s in stages)), ["separate", "relax", "settle"])
        self.assertTrue(all(s.is_rod.all() for s in stages if s.stage != "settle"))
        self.assertEqual(stages[-1].is_rod.tolist(), [k == "thin" for k in kinds])

    def test_force_of_a_contact_in_a_weave(self):
        def less(file, i):
            file["contacts/normal_force"][self.pressing(file, i)] *= np.float32(0.8)

        for name in ("weave", "cell"):
            self.assertIn("fibers", self.found(name, less), name)

    def test_fiber_of_a_cell_that_goes_into_others(self):
        def sink(file, i):
            first = file["mesh/first_node"][:]
            file["fibers/r"][i, first[0] : first[1], 2] += 3 * R * 1e-6
            file["contacts/count"][i] = 0

        self.assertLessEqual({"contacts", "deep"}, self.found("cell", sink))

    def test_fibers_that_passed_through_each_other(self):
        def jump(file, i):
            first = file["mesh/first_node"][:]
            file["fibers/r"][i, first[1] : first[2], 2] -= 6 * R * 1e-6

        self.assertIn("passed", self.found("rods", jump))

    def test_deep_overlap(self):
        def sink(file, i):
            first = file["mesh/first_node"][:]
            file["fibers/r"][i, first[1] : first[2], 2] -= 0.5 * R * 1e-6

        self.assertIn("deep", self.found("rods", sink))

    def test_not_a_number(self):
        def spoil(file, i):
            file["fibers/r"][i, 3, 0] = np.nan

        self.assertEqual(self.found("rods", spoil), {"finite"})


if __name__ == "__main__":
    Judge.binary = pathlib.Path(sys.argv.pop(1)) / "simulate_fibers"
    unittest.main()
