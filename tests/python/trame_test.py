#!/usr/bin/env python3
"""data/python/trame against runs of known answer: three fibers in contact, pulled and let go; a patch without contact.

    tests/python/trame_test.py build/release/bin [--install build/release]
"""

import argparse
import os
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import numpy as np

parser = argparse.ArgumentParser()
parser.add_argument("programs")
parser.add_argument("--install", help="a build folder: the package is installed from it and tested there")
arguments = parser.parse_args()
sources = Path(__file__).resolve().parents[2] / "data" / "python"
package, prefix = sources, tempfile.TemporaryDirectory()
if arguments.install:
    subprocess.run(["cmake", "--install", arguments.install, "--prefix", prefix.name, "--component", "python"], check=True,
                   stdout=subprocess.DEVNULL)
    package = Path(prefix.name) / "lib" / "python3" / "dist-packages"
os.environ["TRAME_BIN"] = arguments.programs
sys.path.insert(0, str(package))
import trame
from trame import curves as trame_curves

assert Path(trame.__file__).is_relative_to(package), trame.__file__

radius, length, modulus = 10e-6, 1e-3, 3e9
area = np.pi * radius**2


def strand():
    """Three fibers of 1 mm that touch, pulled by 1 % and let go to a half of it, then turned."""
    ends = [{"name": name, "position": [f"{x} mm", "0 mm", "0 mm"], "tie": [{"fibers": "strand", "end": end}]}
            for name, x, end in (("left", 0, "start"), ("right, hand", 1, "end"))]

    def stage(name, dof, displacement):
        return {"name": name, "increments": 2,
                "drive": [{"bodies": "right, hand", "dof": dof, "displacement": displacement}]}

    return {"title": "a \"strand\" \\ µ",
            "material": {"pa66": {"model": "isotropic", "young_modulus": "3 GPa", "poisson_ratio": 0}},
            "fiber_type": {"f": {"material": "pa66", "diameter": "20 um", "model": "rod"}},
            "bundle": [{"name": "strand", "fiber_type": "f", "points": [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "0 mm"]],
                        "fibers": 3, "elements": 6, "lattice_spacing": 1}],
            "body": ends, "effects": {"contact": "all", "friction": False},
            "stage": [stage("pull", "x", "10 um"), stage("let go", "x", "-5 um"), stage("turn", "rx", "90 deg")]}


class Scenes(unittest.TestCase):
    def test_text_is_read_as_what_was_written(self):
        odd = strand() | {"a key": {"x.y": [1, 2.5, True, "µ \"q\" \n \\"]}, "numbers": [float("inf"), -1e-300]}
        self.assertEqual(tomllib.loads(trame.scene_text(odd)), odd)

    def test_numbers_of_numpy_are_numbers(self):
        self.assertEqual(tomllib.loads(trame.scene_text({"a": np.float64(0.5), "b": [np.int64(3)]})), {"a": 0.5, "b": [3]})

    def test_what_no_scene_holds_is_refused_with_its_key(self):
        with self.assertRaisesRegex(TypeError, "contact.friction"):
            trame.scene_text({"contact": {"friction": None}})

    def test_changes_lead_to_a_copy(self):
        scene = strand()
        other = trame.changed(scene, {"stage.pull.increments": 7, "contact.penalty": 0.1, "body.1.name": "b"})
        self.assertEqual(other["stage"][0]["increments"], 7)
        self.assertEqual(other["contact"], {"penalty": 0.1})
        self.assertEqual(other["body"][1]["name"], "b")
        self.assertEqual(scene, strand())
        with self.assertRaisesRegex(KeyError, "stage.push.increments: there is no entry push"):
            trame.changed(scene, {"stage.push.increments": 7})

    def test_lengths(self):
        self.assertAlmostEqual(trame.length_of("130 um"), 130e-6)
        self.assertAlmostEqual(trame.scene.spacing_of({"yarn_spacing": "130 um"}), 130e-6)
        for sett in ("50 per cm", "50 cm-1", "50 /cm", "127 per inch"):
            self.assertAlmostEqual(trame.scene.spacing_of({"sett": sett}), 0.01 / 50)
        self.assertAlmostEqual(trame.length_of("1e-1 mm"), 1e-4)
        with self.assertRaisesRegex(ValueError, "5 kg"):
            trame.length_of("5 kg")


class Strand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.run_ = trame.run_scene(strand(), Path(cls.folder.name) / "strand", threads=1)

    @classmethod
    def tearDownClass(cls):
        cls.run_.close()
        cls.folder.cleanup()

    def test_states_and_summary(self):
        run = self.run_
        self.assertEqual(run.n_states, 7)
        self.assertEqual(run.summary()["status"], "done")
        self.assertEqual(list(run.states()["stage"]), ["start"] + ["pull"] * 2 + ["let go"] * 2 + ["turn"] * 2)
        self.assertEqual(run.states().attrs["units"]["external_work"], "J")
        self.assertEqual(run.scene()["title"], "a \"strand\" \\ µ")
        self.assertEqual((run.state("let go"), run.state(-1), run.state(2)), (4, 6, 2))
        for wrong, error in ((7, IndexError), (-8, IndexError), ("knit", KeyError)):
            with self.assertRaises(error):
                run.state(wrong)

    def test_curves_have_the_stiffness_of_three_fibers(self):
        table = self.run_.curves()
        self.assertEqual(table.attrs["units"]["right, hand.x_N"], "N")
        self.assertEqual(table.attrs["units"]["right, hand.rx_Nm"], "N m")
        curve = self.run_.curve("right, hand, x")
        self.assertEqual((curve.motion_unit, curve.reaction_unit), ("m", "N"))
        stiffness = 3 * modulus * area / length
        pull = curve.stage("pull").table
        self.assertEqual(len(pull), 3)  # start and two increments
        np.testing.assert_allclose(pull["reaction"][1:] / pull["motion"][1:], stiffness, rtol=0.02)
        self.assertAlmostEqual(curve.stage("let go").table["motion"].iloc[-1], 5e-6, places=12)
        self.assertAlmostEqual(self.run_.curve("right, hand, rx").table["motion"].iloc[-1], np.pi / 2, places=7)
        with self.assertRaisesRegex(KeyError, "left, x: must be one of right, hand, x"):
            self.run_.curve("left, x")
        with self.assertRaisesRegex(KeyError, "knit: must be one of pull"):
            curve.stage("knit")

    def test_branches(self):
        branches = self.run_.branches()
        x = branches[branches["curve"] == "right, hand, x"]
        self.assertEqual(list(x["branch"]), ["loading", "unloading"])
        self.assertAlmostEqual(x["loop_work"].iloc[1] / x["work"].iloc[0], 0, places=3)  # elastic

    def test_fibers_of_a_yarn(self):
        fibers = self.run_.fibers("strand", "pull")
        self.assertEqual([fiber.index for fiber in fibers], [0, 1, 2])
        for fiber in fibers:
            self.assertAlmostEqual(fiber.radius, radius)
            self.assertEqual(fiber.r.shape, (13, 3))
            self.assertAlmostEqual(np.ptp(fiber.r[:, 0]), 1.01 * length, places=8)
            self.assertAlmostEqual(fiber.arc_length[-1], length, places=9)
        self.assertEqual(self.run_.positions(0).shape, (39, 3))
        with self.assertRaisesRegex(KeyError, "warp: must be one of strand"):
            self.run_.fibers("warp")

    def test_bodies(self):
        bodies = self.run_.bodies("pull").set_index("name")
        self.assertAlmostEqual(bodies.loc["right, hand", "motion_x"], 10e-6, places=12)
        self.assertAlmostEqual(bodies["force_x"].sum() / bodies["force_x"].abs().max(), 0, places=4)
        self.assertGreater(bodies.loc["right, hand", "force_x"], 0)

    def test_contacts_press(self):
        touches = self.run_.contacts("turn")
        self.assertGreater(len(touches), 0)
        pressing = touches[touches["normal_force"] > 0]
        self.assertGreater(len(pressing), 0)
        self.assertTrue((pressing["pressure"] > 0).all())
        self.assertTrue((touches["fiber_a"] != touches["fiber_b"]).all())
        # Normals lead from a to b; all fibers lie within two diameters of the axis.
        self.assertLess(touches[["position_y", "position_z"]].abs().to_numpy().max(), 4 * radius)

    def test_cut(self):
        cut = self.run_.cut("strand", 0.5, 0)
        self.assertEqual(len(cut), 3)
        places = cut[["across", "up"]].to_numpy()
        for i in range(3):
            self.assertAlmostEqual(np.linalg.norm(places[i] - places[i - 1]), 2 * radius, places=9)
        self.assertAlmostEqual(cut["x"].iloc[0], length / 2, places=9)
        with self.assertRaisesRegex(ValueError, "at = 2"):
            self.run_.cut("strand", 2)

    def test_figures(self):
        import matplotlib
        matplotlib.use("Agg")
        out = Path(self.folder.name) / "pictures"
        subprocess.run([sys.executable, sources / "figures.py", self.run_.folder, out], check=True, capture_output=True)
        for name in ("curves", "sections", "contact_pressure"):
            self.assertGreater((out / f"{name}.png").stat().st_size, 5000)

    def test_vtk_reads_the_fibers(self):
        try:
            from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
        except ImportError:
            self.fail("python3-vtk9 is missing: workflows/debian-packages.txt")
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(sorted((self.run_.folder / "vtk").glob("fibers_*.vtp"))[-1]))
        reader.Update()
        data = reader.GetOutput()
        self.assertEqual(data.GetNumberOfPoints(), 39)
        self.assertEqual(data.GetNumberOfCells(), 3)
        for name in ("radius", "tension"):
            self.assertIsNotNone(data.GetPointData().GetArray(name), name)
        point = data.GetPoint(12)
        np.testing.assert_allclose(point, self.run_.positions()[12], atol=1e-9)


class Sides(unittest.TestCase):
    def test_forces_per_width(self):
        yarns = {"fiber_type": "f", "yarns": 2, "fibers": 1, "elements": 2, "yarn_spacing": "0.5 mm", "margin": "0.5 mm"}
        scene = {**{key: strand()[key] for key in ("material", "fiber_type")}, "weave": {"pattern": "plain", "warp": yarns, "weft": yarns},
                 "effects": {"contact": "none"},
                 "stage": [{"name": "load", "increments": 1, "drive": [
                     drive for end in ("start", "end") for drive in (
                         {"bodies": f"side/warp/{end}", "dof": "x", "strain": 0.01},
                         {"bodies": f"warp/*/{end}", "dof": "x", "follow": f"side/warp/{end}"})]}]}
        with tempfile.TemporaryDirectory() as folder, trame.run_scene(scene, folder, threads=1) as run:
            self.assertEqual(run.widths(), (1e-3, 1e-3))
            curve = run.curve("warp sides")
            self.assertEqual(curve.reaction_unit, "N/m")
            # E A (λ² − 1) λ/2 of each of two fibers over 1 mm, but for ties that give way by 10⁻³ of an element's stretch.
            expected = 2 * modulus * area * (1.01**2 - 1) * 1.01 / 2 / 1e-3
            self.assertAlmostEqual(curve.table["reaction"].iloc[-1] / expected, 1, delta=5e-3)
            self.assertAlmostEqual(run.states()["side_warp_strain"].iloc[-1], 0.01, places=8)


def cell(periodic=True):
    """A periodic plain weave of single fibers that do not touch, sheared where it is periodic both ways."""
    yarns = {"fiber_type": "f", "yarns": 2, "fibers": 1, "elements": 2, "yarn_spacing": "0.5 mm"}
    drives = [{"bodies": "cell/weft", "dof": "x", "strain": 0.2}] if periodic is True else []
    return {**{key: strand()[key] for key in ("material", "fiber_type")},
            "weave": {"pattern": "plain", "periodic": periodic, "warp": yarns, "weft": yarns},
            "effects": {"contact": "none"}, "stage": [{"name": "load", "increments": 1, "drive": [
                {"bodies": "cell/warp", "dof": "x", "strain": 0.01}, *drives]}]}


class Copies(unittest.TestCase):
    def test_are_displaced_by_the_periods_of_a_sheared_cell(self):
        with tempfile.TemporaryDirectory() as folder, \
                trame.run_scene(cell(), folder, threads=1, arguments=["--copies", "2x3"]) as run:
            a, b = run.periods()
            np.testing.assert_allclose(a, [1.01e-3, 0, 0], atol=1e-9)
            np.testing.assert_allclose(b, [0.2e-3, 1e-3, 0], atol=1e-9)
            np.testing.assert_allclose(run.periods(0), [[1e-3, 0, 0], [0, 1e-3, 0]], atol=1e-12)
            copies, fibers = run.copies((2, 3)), run.fibers()
            self.assertEqual([fiber.copy for fiber in copies[::4]], [(0, -1), (1, -1), (0, 0), (1, 0), (0, 1), (1, 1)])
            for k, fiber in enumerate(copies):
                np.testing.assert_array_equal(fiber.r, fibers[k % 4].r + (fiber.copy[0] * a + fiber.copy[1] * b))
                self.assertEqual(fiber.index, k % 4)
            self.assertEqual([fiber.copy for fiber in run.copies((3, 1), "weft/2")], [(-1, 0), (0, 0), (1, 0)])
            np.testing.assert_allclose(copies[0].r[-1], copies[4].r[0], atol=1e-15)  # the warp goes on
            self.assertEqual(run.copies((1, 1))[0].copy, (0, 0))
            with self.assertRaisesRegex(ValueError, "1 or more"):
                run.copies((0, 1))
            self.assert_in_vtk(run, copies)

    def assert_in_vtk(self, run, copies):
        from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(sorted((run.folder / "vtk").glob("fibers_*.vtp"))[-1]))
        reader.Update()
        data = reader.GetOutput()
        self.assertEqual(data.GetNumberOfCells(), len(copies))
        np.testing.assert_array_equal([data.GetPoint(n) for n in range(data.GetNumberOfPoints())],
                                      np.concatenate([fiber.r for fiber in copies]))
        numbers = data.GetCellData().GetArray("copy")
        self.assertEqual([numbers.GetTuple2(k) for k in range(len(copies))], [fiber.copy for fiber in copies])

    def test_of_a_strip_go_one_way(self):
        with tempfile.TemporaryDirectory() as folder, trame.run_scene(cell("warp"), folder, threads=1) as run:
            self.assertIsNone(run.periods()[1])
            self.assertEqual(len(run.copies((3, 1))), 12)
            with self.assertRaisesRegex(ValueError, "not periodic along its weft"):
                run.copies((1, 2))

    def test_of_what_is_not_periodic_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(trame.ProgramFailed, "exit code 2\n.*--copies 2x2: .*periodic"):
                trame.run_scene(strand(), folder, arguments=["--copies", "2x2"])
            with self.assertRaisesRegex(trame.ProgramFailed, "exit code 2\n.*--copies 2x2: .*end with x1"):
                trame.run_scene(cell("warp"), folder, arguments=["--copies", "2x2"])
            self.assertFalse((Path(folder) / "states.h5").exists(), "refused before anything is simulated")


class Studies(unittest.TestCase):
    def test_all_combinations_and_no_end_with_one_that_fails(self):
        scene = strand()
        scene["stage"] = scene["stage"][:1]
        with tempfile.TemporaryDirectory() as folder:
            table = trame.study(scene, {"material.pa66.young_modulus": ["1 GPa", "2 GPa"], "material.pa66.poisson_ratio": [0, 7]},
                                folder, threads=1,
                                measure=lambda run: {"force": run.curve("right, hand, x").table["reaction"].iloc[-1]})
        self.assertEqual(list(table["status"].str.split(":").str[0]), ["done", "exit code 2"] * 2)
        self.assertIn("poisson_ratio", table["status"][1])
        self.assertAlmostEqual(table["force"][2] / table["force"][0], 2, places=4)

    def test_a_scene_that_is_none_is_told_in_the_words_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(trame.ProgramFailed, "young_modulus"):
            trame.run_scene(trame.changed(strand(), {"material.pa66.young_modulus": "3 kg"}), folder)

    def test_no_run(self):
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(FileNotFoundError, "no states"):
            trame.open_run(folder)


class Units(unittest.TestCase):
    def test_of_columns(self):
        for column, unit in (("stage", ""), ("warp_strain", "1"), ("weft_force_N", "N"), ("a.b_m.x_m", "m"),
                             ("a.rz_rad", "rad"), ("a.rz_Nm", "N m")):
            self.assertEqual(trame_curves.unit(column), unit)


unittest.main(argv=[sys.argv[0]], verbosity=1)
