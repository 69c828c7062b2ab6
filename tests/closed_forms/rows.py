"""Scenes with a published or closed-form answer, run with default settings, and how to read the answer off
their states. Scenes are in units of R = 10 um and E = 1 GPa, so that forces are in E R^2 = 0.1 N and
moments in E R^3 = 1e-6 N m."""

import dataclasses
import pathlib
import sys
from typing import Callable

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "judge"))
import references as ref  # noqa: E402
from scene_text import Scene, helix  # noqa: E402

R, E = 10.0, 1e9  # um, Pa
FORCE, MOMENT = E * (R * 1e-6) ** 2, E * (R * 1e-6) ** 3


@dataclasses.dataclass
class Row:
    """One line of the table. `value` and `expected` may be vectors: the error is that of the vector."""

    what: str
    source: str
    expected: object
    value: Callable
    tolerance: float = 0.01
    reason: str = ""
    absolute: bool = False  # the expected value is 0: the error is the value itself
    may_end: str = ""  # with what the run may give up after the value was reached


@dataclasses.dataclass
class Case:
    name: str
    scene: Scene
    rows: list


class Saved:
    """Saved states in units of R and E."""

    def __init__(self, file):
        self.n = int(file["n_increments"][()])
        self.file = file
        self.names = [x.decode() for x in file["bodies/name"][:]]
        self.first = file["mesh/first_node"][:].astype(int)
        self.stages = [x.decode() for x in file["stage"][: self.n]]

    def _of(self, body):
        return self.names.index(body)

    def last_of(self, stage):
        return max(i for i, s in enumerate(self.stages) if s == stage)

    def force(self, body, i=-1):
        return self.file["bodies/force"][i % self.n][self._of(body)] / FORCE

    def moment(self, body, i=-1):
        return self.file["bodies/moment"][i % self.n][self._of(body)] / MOMENT

    def position(self, body, i=-1):
        return self.file["bodies/position"][i % self.n][self._of(body)] / (R * 1e-6)

    def node(self, fiber, which, i=-1):
        nodes = self.file["fibers/r"][i % self.n][self.first[fiber] : self.first[fiber + 1]]
        return nodes[which] / (R * 1e-6)

    def contacts(self, i=-1):
        a = int(self.file["contacts/first"][i % self.n])
        b = a + int(self.file["contacts/count"][i % self.n])
        take = lambda k: self.file["contacts/" + k][a:b]
        return take("normal_force") / FORCE, take("s_a") / (R * 1e-6), take("length") / (R * 1e-6)

    @property
    def stage_time_at_the_end(self):
        return float(self.file["stage_time"][self.n - 1])

    def first_unstable(self, stage):
        """Share of the stage at the middle of the first increment that ends in an unstable equilibrium; NaN
        for none."""
        found = [i for i in range(self.n) if self.stages[i] == stage and self.file["solver/unstable"][i]]
        if not found:
            return np.nan
        times = [
            float(self.file["stage_time"][i]) if self.stages[i] == stage else 0.0
            for i in (found[0] - 1, found[0])
        ]
        return 0.5 * sum(times)


def um(points):
    return [tuple(R * x for x in p) for p in points]


def base(title, nu=0.0, model="enriched", contact=False, friction=None):
    scene = Scene(title)
    scene.material("m", E, nu)
    scene.fiber_type("f", "m", R, model)
    if not contact:
        scene.effects["contact"] = "none"
    elif friction is not None:
        scene.effects["friction"] = friction
    return scene


def clamped_fiber(scene, points, elements, name="beam"):
    scene.fiber(name, "f", um(points), elements)
    scene.body("wall", um([points[0]])[0], [(name, "start")])
    scene.body("tip", um([points[-1]])[0], [(name, "end")])


def free_but(*driven):
    """The tip without force and moment but in the dofs that are driven."""
    return [("tip", dof, "force", 0.0) for dof in ("x", "y", "z", "rx", "ry", "rz") if dof not in driven]


def elastica(load, model):
    length = 100.0
    scene = base("elastica", model=model)
    clamped_fiber(scene, [(0, 0, 0), (length, 0, 0)], 16)
    force = load * np.pi / 4 / length**2 * FORCE
    scene.stage("bend", 10, free_but("z", "y", "rx", "rz") + [("tip", "z", "force", force)])
    x, z = ref.elastica_tip(load)
    return Case(
        f"elastica_{load}_{model}",
        scene,
        [
            Row(
                f"cantilever ({model}) under a dead force, P L²/EI = {load}: tip (x, z)/L",
                "elastica, shooting",
                (x, z),
                lambda s: s.node(0, -1)[[0, 2]] / length,
            )
        ],
    )


def roll_up():
    length = 100.0
    scene = base("roll-up")
    clamped_fiber(scene, [(0, 0, 0), (length, 0, 0)], 16)
    scene.stage(
        "roll",
        10,
        free_but("ry", "y", "rx", "rz") + [("tip", "ry", "force", -np.pi * np.pi / 4 / length * MOMENT)],
    )
    return Case(
        "roll_up",
        scene,
        [
            Row(
                "cantilever rolled to half a circle by M L/EI = π: tip (x, z)/L",
                "circle",
                (0, 2 / np.pi),
                lambda s: s.node(0, -1)[[0, 2]] / length,
            )
        ],
    )


def bend45():
    """In the units of the problem, m and Pa."""
    scene = Scene("45 degree bend")
    scene.material("m", 1e7, 0)
    radius = 1.1414639861778908e6 / 2
    scene.fiber_type("f", "m", radius, "enriched")
    scene.effects["contact"] = "none"
    arc = [np.pi / 4 * k / 32 for k in range(33)]
    points = [(1e8 * np.sin(a), 1e8 * (1 - np.cos(a)), 0.0) for a in arc]
    scene.fiber("b", "f", points, 8)
    scene.body("wall", points[0], [("b", "start")])
    scene.body("tip", points[-1], [("b", "end")])
    for force in (300, 450, 600):
        scene.stage(f"F{force}", 6, free_but("z") + [("tip", "z", "force", force)])
    tip = lambda force: lambda s: s.node(0, -1, s.last_of(f"F{force}")) * R * 1e-6
    return Case(
        "bend45",
        scene,
        [
            Row(
                f"45° bend, F = {f}: tip",
                "Reissner's beam, shooting (Bathe and Bolourchi 1979)",
                tuple(ref.bend_45(f)),
                tip(f),
            )
            for f in (300, 450, 600)
        ],
    )


def column():
    length, shortening = 200.0, 0.1
    scene = base("column")
    bow = [(length * k / 16, 0, 1e-4 * length * (1 - np.cos(2 * np.pi * k / 16)) / 2) for k in range(17)]
    clamped_fiber(scene, bow, 20)
    scene.stage("shorten", 20, [("tip", "x", "displacement", -shortening * length * R)])
    euler = 4 * np.pi**2 * np.pi / 4 / length**2
    expected = ref.buckled_column(shortening) / (4 * np.pi**2)
    return Case(
        "column",
        scene,
        [
            Row(
                "column with a bow of L/10,000, shortened by 10 %: P over Euler's load",
                "elastica, shooting",
                expected,
                lambda s: -s.force("tip")[0] / euler,
            )
        ],
    )


def tension(model):
    length, strain = 100.0, 0.01
    scene = base("tension", nu=0.3, model=model)
    clamped_fiber(scene, [(0, 0, 0), (length, 0, 0)], 50)
    scene.stage("pull", 2, [("tip", "x", "displacement", strain * length * R)])
    green = strain + strain**2 / 2
    return Case(
        f"tension_{model}",
        scene,
        [
            Row(
                f"tension ({model}, ν = .3) by 1 %: F/(E A)",
                "St. Venant–Kirchhoff",
                green * (1 + strain),
                lambda s: s.force("tip")[0] / np.pi,
            )
        ],
    )


def torsion():
    length, angle, nu = 100.0, np.pi, 0.3
    scene = base("torsion", nu=nu)
    clamped_fiber(scene, [(0, 0, 0), (length, 0, 0)], 30)
    scene.stage("twist", 6, [("tip", "rx", "displacement", angle)])
    k = angle / length
    return Case(
        "torsion",
        scene,
        [
            Row(
                "torsion by half a turn over 100 R: torque over G J φ/L",
                "St. Venant",
                1.0,
                lambda s: s.moment("tip")[0] / (np.pi / 2 / (2 * (1 + nu)) * k),
            ),
            Row(
                "the same, length held: axial force over E I (φ/L)²",
                "St. Venant–Kirchhoff, second order",
                (1 - nu) / (1 + nu),
                lambda s: s.force("tip")[0] / (np.pi / 4 * k**2),
            ),
        ],
    )


def strand(lay):
    core, strain = 1.2, 1e-3
    radius = core + 1
    turn = np.tan(np.radians(lay)) / radius
    length = 2 * np.pi / turn
    scene = base("1+6 strand", contact=True, friction=False)
    scene.fiber_type("c", "m", core * R, "enriched")
    scene.fiber("core", "c", um([(0, 0, 0), (length, 0, 0)]), 32)
    for k in range(6):
        scene.fiber(f"w{k}", "f", um(helix(radius, 1, 2 * np.pi * k / 6, length, 64)), 32)
    scene.body("left", (0, 0, 0), [("core", "start"), ("w*", "start")])
    scene.body("right", (length * R, 0, 0), [("core", "end"), ("w*", "end")])
    scene.stage("pull", 4, [("right", "x", "displacement", strain * length * R)])
    force, torque = ref.strand_1_6(lay, strain)
    area = np.pi * (core**2 + 6)
    return Case(
        f"strand_{lay}",
        scene,
        [
            Row(
                f"1+6 strand, lay {lay}°, strain 10⁻³, no friction: F/(Σ E A ε)",
                "Costello, by energy",
                force,
                lambda s: s.force("right")[0] / (area * strain),
                *((0.02, "sections give way: 0.8 % at 20°") if lay == 20 else ()),
            ),
            Row(
                "the same: torque/(E R³)", "Costello, by energy", torque, lambda s: abs(s.moment("right")[0])
            ),
        ],
    )


def two_ply():
    length, strain = 500.0, 0.01
    scene = base("two-ply yarn", contact=True, friction=False)
    for name, y in (("a", 1), ("b", -1)):
        scene.fiber(name, "f", um([(0, y, 0), (length, y, 0)]), 40)
    scene.body("left", (0, 0, 0), [("a", "start"), ("b", "start")])
    scene.body("right", (length * R, 0, 0), [("a", "end"), ("b", "end")])
    scene.stage(
        "twist",
        16,
        [("right", "rx", "displacement", 2 * np.pi), ("right", "x", "displacement", strain * length * R)],
    )

    def middle(s):
        force, at, stands_for = s.contacts()
        inner = (at > 0.1 * length) & (at < 0.9 * length)
        return force[inner] / stands_for[inner]

    def law(s):
        """T κ λ by the energy of the helix that the middle has become: clamps take a little of the turn from
        the ends."""
        # 81 nodes: 8 to 72 are the middle. The fiber turns by less than half a turn from node to node.
        nodes = np.array([s.node(0, k) for k in range(8, 73)])
        angle = np.unwrap(np.arctan2(nodes[:, 2], nodes[:, 1]))
        rest = 64 / 80 * length
        return ref.two_ply(abs(angle[-1] - angle[0]) / rest, (nodes[-1, 0] - nodes[0, 0]) / rest - 1)

    return Case(
        "two_ply",
        scene,
        [
            Row(
                "two-ply yarn, one turn over 500 R, strain 1 %: mean contact force per length over T κ λ",
                "helix, by energy",
                1.0,
                lambda s: middle(s).mean() / law(s),
                0.02,
                "elements are 12 R long",
            ),
            Row(
                "the same: largest over mean",
                "uniform",
                1.0,
                lambda s: middle(s).max() / middle(s).mean(),
                0.02,
                "elements are 12 R long",
            ),
        ],
    )


def unstable_twist(name, what, source, scene, critical, drives, jumps=False):
    """Twists to 0.9 of the critical angle and on to 1.1 of it in steps of 0.5 %. Where what is unstable `jumps`
    to a state that is far away, the run gives up there."""

    def share(s):
        seen = s.first_unstable("find")
        return s.stage_time_at_the_end if jumps and np.isnan(seen) and s.stages[-1] == "find" else seen

    scene.stage("twist", 12, [("tip", "rx", "displacement", 0.9 * critical)] + drives)
    scene.stage("find", 40, [("tip", "rx", "displacement", 0.2 * critical)] + drives)
    return Case(
        name,
        scene,
        [
            Row(
                what,
                source,
                critical,
                lambda s: critical * (0.9 + 0.2 * share(s)),
                may_end="stability is lost",
            )
        ],
    )


def greenhill(tension):
    length = 200.0 if tension < 10 else 400.0
    scene = base("Greenhill")
    clamped_fiber(scene, [(0, 0, 0), (length, 0, 0)], 24 if tension < 10 else 80)
    pull = [("tip", "x", "force", tension * np.pi / 4 / length**2 * FORCE)]
    scene.stage("pull", 2, pull)
    critical = ref.greenhill(tension)
    return unstable_twist(
        f"greenhill_{tension}",
        f"straight rod, clamped, T L²/EI = {tension}, twisted: M L/EI where unstable",
        "Greenhill, determinant",
        scene,
        critical,
        pull,
    )


def ring():
    """A straight rod rolled to a ring. Held at one point alone it could swing about its tangent there at no
    cost, so the far point, between two fibers that make one, stays in the ring's plane."""
    length = 400.0
    scene = base("Michell's ring")
    half = um([(0, 0, 0), (length / 2, 0, 0), (length, 0, 0)])
    scene.fiber("a", "f", half[:2], 20)
    scene.fiber("b", "f", half[1:], 20)
    scene.body("wall", half[0], [("a", "start")])
    scene.body("far", half[1], [("a", "end"), ("b", "start")])
    scene.body("tip", half[2], [("b", "end")])
    far = [("far", dof, "force", 0.0) for dof in ("x", "z", "rx", "ry", "rz")]
    scene.stage(
        "roll",
        24,
        [("tip", "ry", "displacement", -2 * np.pi), ("tip", "x", "force", 0.0), ("tip", "z", "force", 0.0)] + far,
    )
    return unstable_twist(
        "ring",
        "closed ring, twisted: angle where unstable",
        "Michell, Zajac: 2π√3 (1 + ν)",
        scene,
        ref.ring_critical_twist(0.0),
        far,
        jumps=True,
    )


def papailiou():
    """Of fibers that hardly shear and stick well: theory knows neither slip nor shear. With G = E/2 sections that
    tilt as their neighbours drag at their outlines take 1.8 % of E I; with mu = 0.5 some fibers slip at the
    clamps, which takes 3 %."""
    lay, strain, angle = 5.0, 2e-3, 1e-3
    radius = 2.2  # a core that is thicker than the wires, so that these do not touch each other
    turn = np.tan(np.radians(lay)) / radius
    length = 2 * np.pi / turn
    scene = Scene("bent strand")
    scene.aligned_material("m", E, E, 5 * E, 0.0, 0.0)
    scene.contact = {"friction_coefficient": 5, "reversible_slip": 1e-6}
    scene.fiber_type("f", "m", R, "enriched")
    scene.fiber_type("c", "m", 1.2 * R, "enriched")
    scene.fiber("core", "c", um([(0, 0, 0), (length, 0, 0)]), 32)
    for k in range(6):
        scene.fiber(f"w{k}", "f", um(helix(radius, 1, 2 * np.pi * k / 6, length, 64)), 32)
    scene.body("left", (0, 0, 0), [("core", "start"), ("w*", "start")])
    scene.body("right", (length * R, 0, 0), [("core", "end"), ("w*", "end")])
    scene.stage("pull", 4, [("right", "x", "displacement", strain * length * R)], friction=False)
    scene.stage(
        "bend", 2, [("left", "ry", "displacement", angle / 2), ("right", "ry", "displacement", -angle / 2)]
    )
    own = np.pi / 4 * (1.2**4 + 6 * np.cos(np.radians(lay)))
    expected = ref.strand_stick_bending(lay, core=1.2)

    def value(s):
        # Under tension the ends carry M = EI k (angle/2) coth(k L/2), k^2 = T/EI.
        tension = s.force("right")[0]
        moment = 0.5 * (abs(s.moment("left")[1]) + abs(s.moment("right")[1]))
        from scipy.optimize import brentq

        def excess(ei):
            k = np.sqrt(tension / ei)
            return ei * k * angle / 2 / np.tanh(k * length / 2) - moment

        return brentq(excess, 1e-3 * own, 1e3 * own) / own

    return Case(
        "papailiou",
        scene,
        [
            Row(
                "1+6 strand, lay 5°, G = 5 E, µ = 5, pulled and bent: E I over that of its wires",
                "Papailiou, stick",
                expected,
                value,
                0.02,
                "sections shear a little, contact gives way",
            )
        ],
    )


def capstan(mu, degrees):
    drum, leg = 100.0, 50.0
    rho, wrap = drum + 1, np.radians(degrees)
    scene = base("capstan", contact=True)
    scene.contact["friction_coefficient"] = mu
    scene.fiber_type("drum", "m", drum * R, "enriched")
    scene.fiber("drum", "drum", um([(0, -20, 0), (0, 20, 0)]), 8)
    pitch = 3.0 if degrees > 180 else 0.0
    n = max(12, round(degrees / 7.5))
    arc = [-wrap / 2 + wrap * k / n for k in range(n + 1)]
    points = [(rho * np.sin(a), pitch * a / (2 * np.pi), rho * np.cos(a)) for a in arc]
    along = lambda a: np.array([np.cos(a), 0, -np.sin(a)])
    out, back = along(wrap / 2), -along(-wrap / 2)
    first = [tuple(np.array(points[0]) + back * leg * k / 4) for k in (4, 3, 2, 1)]
    last = [tuple(np.array(points[-1]) + out * leg * k / 4) for k in (1, 2, 3, 4)]
    points = first + points + last
    scene.fiber("rope", "f", um(points), round((rho * wrap + 2 * leg) / 2.5))
    scene.body("axle", (0, 0, 0), [("drum", "start"), ("drum", "end")])
    scene.body("brake", um([points[0]])[0], [("rope", "start")])
    scene.body("haul", um([points[-1]])[0], [("rope", "end")])
    pull = 5e-3 * np.pi
    forces = lambda body, way: [
        (body, d, "force", pull * FORCE * x) for d, x in (("x", way[0]), ("z", way[2]))
    ]
    scene.stage(
        "tighten", 5, forces("brake", back) + forces("haul", out), friction=False, proximal_start=1e-3
    )
    scene.stage(
        "haul",
        10,
        forces("brake", back)
        + [("haul", d, "displacement", 8 * R * x) for d, x in (("x", out[0]), ("z", out[2]))],
    )
    return Case(
        f"capstan_{mu}_{degrees}",
        scene,
        [
            Row(
                f"rope {degrees}° around a drum of 100 R, µ = {mu}: ratio of its tensions",
                "Euler, Eytelwein, friction at the rope's surface: exp(µ θ ρ/(ρ + R))",
                np.exp(mu * wrap * drum / rho),
                lambda s: (s.force("haul") @ out) / (s.force("brake") @ back),
            )
        ],
    )


def pull_out(mu):
    length = 40.0
    scene = base("pull-out", nu=0.3, contact=True)
    if mu > 0:
        scene.contact["friction_coefficient"] = mu
    else:
        scene.effects["friction"] = False
    scene.fiber("core", "f", um([(-5, 0, 0), (length + 5, 0, 0)]), 15)
    scene.body("pull", (R * (length + 5), 0, 0), [("core", "end")])
    scene.body("guide", (-5 * R, 0, 0), [("core", "start")])
    # Fibers that do not bend away press evenly, as the closed form has it.
    scene.material("stiff", 1000 * E, 0.3)
    scene.fiber_type("g", "stiff", R, "enriched")
    press, drives = 0.02, []
    for k in range(6):
        y, z = np.cos(np.pi / 3 * k), np.sin(np.pi / 3 * k)
        scene.fiber(f"o{k}", "g", um([(0, 2 * y, 2 * z), (length, 2 * y, 2 * z)]), 10)
        scene.body(f"b{k}", (0, 2 * R * y, 2 * R * z), [(f"o{k}", "start"), (f"o{k}", "end")])
        drives += [
            (f"b{k}", "y", "displacement", -press * R * y),
            (f"b{k}", "z", "displacement", -press * R * z),
        ]
    scene.stage("press", 4, drives, friction=False) if mu > 0 else scene.stage("press", 4, drives)
    both = [("pull", "x", "displacement", R), ("guide", "x", "force", 0.0)]
    scene.stage("pull", 10, both)

    # The outer fibers touch each other too, so that only those of the core are counted: the core is fiber 0.
    def ratio(s):
        force = s.contacts()[0]
        a = int(s.file["contacts/first"][s.n - 1])
        fibers = (
            s.file["contacts/fiber_a"][a : a + len(force)],
            s.file["contacts/fiber_b"][a : a + len(force)],
        )
        on_core = (fibers[0] == 0) | (fibers[1] == 0)
        return s.force("pull")[0] / force[on_core].sum()

    what = f"fiber pulled out from six others, µ = {mu}: force over the sum of its normal forces"
    return Case(
        f"pull_out_{mu}",
        scene,
        [
            Row(what, "Coulomb", mu, ratio)
            if mu > 0
            else Row(
                what,
                "no friction",
                0.0,
                ratio,
                1e-3,
                "where contact ends, the core's section swells from element to element",
                absolute=True,
            )
        ],
    )


def crossing():
    length, push = 100.0, 2.0
    scene = base("crossing fibers", contact=True, friction=False)
    half = length / 2
    scene.fiber("lower", "f", um([(-half, 0, 0), (half, 0, 0)]), 20)
    scene.fiber("upper", "f", um([(0, -half, 2), (0, half, 2)]), 20)
    scene.body("table", (0, 0, 0), [("lower", "start"), ("lower", "end")])
    scene.body("grip", (0, 0, 2 * R), [("upper", "start"), ("upper", "end")])
    scene.stage("push", 10, [("grip", "z", "displacement", -push * R)])
    return Case(
        "crossing",
        scene,
        [
            Row(
                "two crossing fibers, L = 100 R, clamped, pushed by 2 R: force/(E R²)",
                "extensible elastica, boundary values",
                ref.crossing_fibers(length, push),
                lambda s: -s.force("grip")[2],
                0.02,
                "sections give way where the fibers cross",
            )
        ],
    )


def touching():
    scene = base("touching fibers", contact=True)
    scene.fiber("lower", "f", um([(-20, 0, 0), (20, 0, 0)]), 10)
    scene.fiber("upper", "f", um([(0, -20, 2), (0, 20, 2)]), 10)
    scene.body("table", (0, 0, 0), [("lower", "start"), ("lower", "end")])
    scene.body("grip", (0, 0, 2 * R), [("upper", "start"), ("upper", "end")])
    scene.stage("slide", 4, [("grip", "x", "displacement", 5 * R)])
    return Case(
        "touching",
        scene,
        [
            Row(
                "fiber that slides on another one and only touches it: force/(E R²)",
                "none",
                0.0,
                lambda s: np.linalg.norm(s.force("grip")),
                1e-9,
                absolute=True,
            )
        ],
    )


def monofilament(spacing):
    """Rods, as the reference has neither shear nor sections. Sides do not slide: with ends free to slide and turn out
    of the plane, two by two yarns are a reciprocal frame. Rising by w at the crossings, their slopes 1.5 w/p turn each
    crossing's force N = 48 EI R/p³ by as much, which turns the patch in its plane; for small slopes the energy of a yarn
    is 6 EI/p³ (w² + v²) - 144 EI R/p⁴ w v, v the way of its crossings sideways: unstable for p < 12 R."""
    n, strain = 2, 5e-4
    crimp, stiffness, cell = ref.monofilament_weave(float(spacing), strain)
    scene = base("monofilament weave", contact=True, friction=False)
    text = '[weave]\npattern = "plain"'
    for family in ("warp", "weft"):
        text += (
            f'\n[weave.{family}]\nfiber_type = "f"\nyarns = {n}\nfibers = 1\nelements = {8 * n}\n'
            f'yarn_spacing = "{spacing * R} um"\nmargin = "{spacing * R / 2} um"'
        )
    scene.raw(text)
    own = 12 * np.pi / 4 * 4 / spacing**3 * FORCE  # about the force of a crossing
    turning = [("warp/*", "ry", "force", 0.0), ("weft/*", "rx", "force", 0.0)]
    pull = lambda f: [("warp/*/end", "x", "force", f), ("weft/*/end", "y", "force", f)]
    scene.stage(
        "separate",
        12,
        pull(0.5 * own) + turning,
        separate_yarns=True,
        friction=False,
        proximal_start=1e-3,
        proximal_end=1e-3,
        fiber_model="rod",
    )
    scene.stage("relax", 10, pull(0.0) + turning, proximal_start=1e-3, proximal_end=0.0, fiber_model="rod")
    scene.stage("settle", 4, pull(0.0) + turning, fiber_model="rod")
    load = [("warp/*/end", "x", "displacement", strain * n * cell * R), ("weft/*/end", "y", "force", 0.0)] + turning
    scene.stage("load", 6, load, fiber_model="rod")

    def length(s, stage):
        i = s.last_of(stage)
        return s.position("warp/1/end", i)[0] - s.position("warp/1/start", i)[0]

    def stiffness_of(s):
        reached = length(s, "load") / length(s, "settle") - 1
        return np.mean([s.force(f"warp/{k + 1}/end")[0] for k in range(n)]) / (np.pi * reached)

    return Case(
        f"monofilament_{spacing}",
        scene,
        [
            Row(
                f"plain weave of monofilaments, {spacing} R from crossing to crossing, no friction: crimp",
                "elastica cell, boundary values",
                crimp,
                lambda s: n * spacing / length(s, "settle") - 1,
                0.02,
                "contact gives way, sides held",
            ),
            Row(
                "the same, warp pulled by 0.05 %, weft free: K/EA",
                "elastica cell, boundary values",
                stiffness,
                stiffness_of,
                0.02,
                "contact gives way, sides held",
            ),
        ],
    )


def bundle(n, bonded):
    length, angle = 60.0, 0.006
    scene = base("bent bundle", contact=True, friction=False)
    if bonded:
        scene.bundle("b", "f", um([(0, 0, 0), (length, 0, 0)]), 12, n, spacing=1.0)
        scene.body("wall", (0, 0, 0), [("b", "start")])
        scene.body("tip", (length * R, 0, 0), [("b", "end")])
        moving, what = ["tip"], "ends clamped to bodies"
    else:
        centres = ref.hexagonal(n)
        for k, (y, z) in enumerate(centres):
            scene.fiber(f"f{k}", "f", um([(0, y, z), (length, y, z)]), 12)
            scene.body(f"tip{k}", um([(length, y, z)])[0], [(f"f{k}", "end")])
        scene.body("wall", (0, 0, 0), [("f*", "start")])
        moving, what = [f"tip{k}" for k in range(n)], "ends free along the fibers"
    drives = []
    for body in moving:
        drives += [(body, "rz", "displacement", angle), (body, "x", "force", 0.0), (body, "y", "force", 0.0)]
    scene.stage("bend", 2, drives)
    expected = ref.bonded_over_loose(n) if bonded else 1.0
    return Case(
        f"{'bonded' if bonded else 'loose'}_{n}",
        scene,
        [
            Row(
                f"bundle of {n}, {what}, bent: E I over that of its fibers one by one",
                "plane sections" if bonded else "sum of fibers",
                expected,
                lambda s: sum(s.moment(b)[2] for b in moving) / (n * np.pi / 4 * angle / length),
            )
        ],
    )


def twisted_yarn(layers):
    """A core, six fibers around it that just touch each other, and six more in the grooves between these; all
    turn alike."""
    lay, strain = 15.0, 1e-3
    scene = base("twisted yarn", contact=True, friction=False)

    # The nearest distance of two helices of the turn w, over all shifts along the axis.
    def nearest(r1, r2, angle, w):
        shift = np.linspace(-2, 2, 4001)
        return np.sqrt(r1**2 + r2**2 - 2 * r1 * r2 * np.cos(angle + w * shift) + shift**2).min()

    first, second = 2.0, 3.5
    for _ in range(100):
        turn = np.tan(np.radians(lay)) / (first if layers == 1 else second)
        first += 2.001 - nearest(first, first, np.pi / 3, turn)
        second += 2 - nearest(first, second, np.pi / 6, turn)
    radii = [0.0] + [first] * 6 + [second] * 6 * (layers - 1)
    length = 2 * np.pi / turn
    scene.fiber_type("c", "m", (first - 1) * R, "enriched")
    scene.fiber("core", "c", um([(0, 0, 0), (length, 0, 0)]), 32)
    for k, r in enumerate(radii[1:]):
        angle = np.pi / 3 * k + (np.pi / 6 if k >= 6 else 0)
        scene.fiber(f"w{k}", "f", um(helix(r, 1, angle, length, 64)), 32)
    scene.body("left", (0, 0, 0), [("core", "start"), ("w*", "start")])
    scene.body("right", (length * R, 0, 0), [("core", "end"), ("w*", "end")])
    scene.stage("pull", 4, [("right", "x", "displacement", strain * length * R)])
    # Over the section across the axis, in which a fiber is wider by 1/cos.
    area = np.pi * sum(np.hypot(1, turn * r) if r else (first - 1) ** 2 for r in radii)
    n = len(radii)
    return Case(
        f"twisted_yarn_{n}",
        scene,
        [
            Row(
                f"yarn of {n}, {lay:g}° at its surface, strain 10⁻³: modulus over that of its fibers",
                f"helices, by energy; cos² of the angle: {np.cos(np.radians(lay))**2:.4f}",
                ref.twisted_yarn(turn, radii, first - 1, strain) / area,
                lambda s: s.force("right")[0] / (area * strain),
            )
        ],
    )


# Builders by name, so that one row is had without the references of all.
BUILDERS = {
    **{f"elastica_{p}_{m}": (lambda p=p, m=m: elastica(p, m)) for p in (1, 10) for m in ("enriched", "rod")},
    "roll_up": roll_up,
    "bend45": bend45,
    "column": column,
    **{f"tension_{m}": (lambda m=m: tension(m)) for m in ("enriched", "rod")},
    "torsion": torsion,
    **{f"greenhill_{t}": (lambda t=t: greenhill(t)) for t in (1, 100)},
    "ring": ring,
    **{f"strand_{a}": (lambda a=a: strand(a)) for a in (10, 15, 20)},
    "two_ply": two_ply,
    **{f"twisted_yarn_{1 + 6 * n}": (lambda n=n: twisted_yarn(n)) for n in (1, 2)},
    "papailiou": papailiou,
    **{
        f"{'bonded' if b else 'loose'}_{n}": (lambda n=n, b=b: bundle(n, b))
        for n in (7, 19, 37)
        for b in (True, False)
    },
    **{
        f"capstan_{m}_{d}": (lambda m=m, d=d: capstan(m, d))
        for m, d in ((0.5, 90), (0.3, 180), (0.2, 270), (0.1, 360))
    },
    **{f"pull_out_{m}": (lambda m=m: pull_out(m)) for m in (0.2, 0)},
    "crossing": crossing,
    "touching": touching,
    **{f"monofilament_{p}": (lambda p=p: monofilament(p)) for p in (10, 20)},
}
