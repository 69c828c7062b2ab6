"""Reference values, each computed here from its equations with numpy and scipy alone: nothing is read from a
table. Lengths in radii R of a fiber and forces in E R^2 unless stated."""

import functools

import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq, fsolve


def elastica_tip(load):
    """(x, z)/L of the tip of an inextensible cantilever under a dead force P across it, load = P L^2/EI.
    EI theta'' = -P cos theta, theta(0) = 0, theta'(L) = 0."""

    def shoot(curvature):
        path = solve_ivp(
            lambda s, y: [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])],
            (0, 1),
            [0, curvature, 0, 0],
            rtol=1e-11,
            atol=1e-12,
        )
        return path.y[:, -1]

    curvature = brentq(lambda k: shoot(k)[1], 0, load)
    return shoot(curvature)[2:]


def buckled_column(shortening):
    """P L^2/EI of an inextensible column clamped at both ends that has come nearer by `shortening` of its
    length. EI theta'' = -P sin theta on a quarter: theta = 0 and theta' = 0 a quarter further."""

    def quarter(load):
        def end(angle):  # from the inflection, where the slope is largest, to the clamp
            path = solve_ivp(
                lambda s, y: [y[1], -load * np.sin(y[0]), np.cos(y[0])],
                (0, 0.25),
                [angle, 0, 0],
                rtol=1e-11,
                atol=1e-13,
            )
            return path.y[:, -1]

        angle = brentq(lambda a: end(a)[0] / a, 1e-3, 2.5)
        return 1 - 4 * end(angle)[2]

    return brentq(lambda p: quarter(p) - shortening, 4 * np.pi**2 * (1 + 1e-5), 8 * np.pi**2)


def bend_45(force, modulus=1e7, radius=1.1414639861778908 / 2, arc=100.0):
    """Tip of the cantilever that is an eighth of a circle in its plane, under a dead force normal to it:
    Reissner's beam, circular section, nu = 0. m' = -r' x n with n the force; shooting for m at the clamp."""
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    stretch = np.array([modulus * area, 0.5 * modulus * area, 0.5 * modulus * area])
    turn = np.array([0.5 * modulus * 2 * inertia, modulus * inertia, modulus * inertia])
    length = arc * np.pi / 4
    initial = np.array([0, 0, 1 / arc])  # curvature about the section's own third axis

    def skew(v):
        return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])

    def shoot(moment, load):
        n = np.array([0, 0, load])

        def slope(s, y):
            rotation, m = y[3:12].reshape(3, 3), y[12:]
            gamma, kappa = rotation.T @ n / stretch, initial + rotation.T @ m / turn
            dr = rotation @ (gamma + [1, 0, 0])
            return np.concatenate([dr, (rotation @ skew(kappa)).ravel(), np.cross(n, dr)])

        y = solve_ivp(
            slope,
            (0, length),
            np.concatenate([np.zeros(3), np.eye(3).ravel(), moment]),
            rtol=1e-10,
            atol=1e-10,
        )
        return y.y[:, -1]

    moment = np.zeros(3)
    for load in np.linspace(0, force, 7)[1:]:
        moment = fsolve(
            lambda m, load=load: shoot(m, load)[12:] / force,
            moment * load / max(load - force / 6, force / 6),
            xtol=1e-11,
        )
    return shoot(moment, force)[:3]


def greenhill(tension):
    """Smallest M L/EI at which a straight rod twisted by M and pulled by T, `tension` = T L^2/EI, both ends
    clamped, buckles. v'''' - i m v''' - t v'' = 0 for v = y + i z."""

    def determinant(m):
        root = np.sqrt(complex(4 * tension - m * m))
        exponents = [(1j * m + root) / 2, (1j * m - root) / 2]
        rows = [
            [1, 0, 1, 1],
            [0, 1, *exponents],
            [1, 1, *(np.exp(k) for k in exponents)],
            [0, 1, *(k * np.exp(k) for k in exponents)],
        ]
        # Up to its phase exp(i m/2) the determinant over the difference of the exponents is real.
        return np.linalg.det(np.array(rows)) / (exponents[0] - exponents[1]) * np.exp(-0.5j * m)

    grid = np.arange(2 * np.sqrt(tension) + 1e-3, 60, 0.01)
    values = np.array([determinant(m) for m in grid])
    phase = values[np.argmax(np.abs(values))]
    real = (values * np.conj(phase)).real
    first = np.flatnonzero(real[:-1] * real[1:] < 0)[0]
    return brentq(lambda m: (determinant(m) * np.conj(phase)).real, grid[first], grid[first + 1])


def ring_critical_twist(nu):
    """Michell and Zajac: a closed ring leaves its plane at the twist 2 pi sqrt 3 EI/GJ."""
    return 2 * np.pi * np.sqrt(3) * (1 + nu)


def helix(stretch, turn, radius, straight=False, turn_0=None, radius_0=None, length_0=None, nu=0.0, own=1.0):
    """Energy per unit of axis length of a wire (radius `own`, modulus 1) that was a helix of radius_0 and
    turn_0 and is one of `radius` and `turn` (rad per unit of first axis length), the axis stretched by
    `stretch`: tension, bending, torsion."""
    area, inertia = np.pi * own**2, np.pi * own**4 / 4
    torsion = 2 * inertia / (2 * (1 + nu))
    turn_0, radius_0 = (turn if turn_0 is None else turn_0), (radius if radius_0 is None else radius_0)
    rest = 1.0 if straight else np.hypot(1, radius_0 * turn_0)
    now = np.hypot(stretch, radius * turn)
    # Curvature and torsion of the helix per length of the wire at rest.
    bend = lambda l, h, r, w: r * w**2 / l / rest
    twist = lambda l, h, r, w: w * h / l / rest
    k_0, t_0 = (0, 0) if straight else (bend(rest, 1, radius_0, turn_0), twist(rest, 1, radius_0, turn_0))
    strain = 0.5 * ((now / rest) ** 2 - 1)
    return rest * (
        0.5 * area * strain**2
        + 0.5 * inertia * (bend(now, stretch, radius, turn) - k_0) ** 2
        + 0.5 * torsion * (twist(now, stretch, radius, turn) - t_0) ** 2
    )


def derivative(f, x, h=1e-5):
    return (8 * (f(x + h) - f(x - h)) - f(x + 2 * h) + f(x - 2 * h)) / (12 * h)


def strand_1_6(lay_degrees, strain, core=1.2, wire=1.0):
    """Axial force over the sum of E A strain, and torque over E R^3 (1 + nu = 1) at that strain, of a core
    and six wires around it that do not rub, sections rigid: Costello's strand by its energy."""
    radius = core + wire
    turn = np.tan(np.radians(lay_degrees)) / radius
    wires = lambda e, w: 6 * helix(1 + e, w, radius, turn_0=turn, own=wire)
    core_energy = lambda e, w: 0.5 * np.pi * core**2 * (e + e * e / 2) ** 2
    force = derivative(lambda e: wires(e, turn) + core_energy(e, turn), strain)
    torque = derivative(lambda w: wires(strain, w), turn)
    return force / (np.pi * (core**2 + 6 * wire**2) * strain), torque


def two_ply(turn, strain):
    """Contact force between two touching fibers per length of the axis, straight at rest, twisted by `turn`
    per length and stretched: dW/dr at r = R of one of them."""
    return derivative(lambda r: helix(1 + strain, turn, r, straight=True), 1.0)


def twisted_yarn(turn, radii, core, strain):
    """Axial force over E strain of helices of `radii` (one of 0: a core of the radius `core`) that turn
    alike, free of stress as they are, at distances from the axis that are kept, nu = 0."""
    force = sum(
        derivative(lambda e, r=r: helix(1 + e, turn, r, own=1.0 if r else core), strain) for r in radii
    )
    return force / strain


def hexagonal(n, spacing=2.0):
    """The n points nearest to the origin of a hexagonal lattice that has one there."""
    points = [
        (spacing * (i + 0.5 * j), spacing * np.sqrt(3) / 2 * j) for i in range(-8, 9) for j in range(-8, 9)
    ]
    return sorted(points, key=lambda p: (round(p[0] ** 2 + p[1] ** 2, 9), p))[:n]


def bonded_over_loose(n, spacing=2.0):
    """Bending stiffness of a bundle whose sections stay plane over that of its fibers one by one."""
    own = np.pi / 4
    return sum(own + np.pi * y * y for _, y in hexagonal(n, spacing)) / (n * own)


def strand_stick_bending(lay_degrees, core=1.0, wire=1.0):
    """Papailiou: E I of a core and six wires that stick, over that of all seven one by one. A wire at angle
    phi around has the strain cos^2 a sin phi r kappa along itself and so adds E A cos^3 a r^2 sin^2 phi."""
    a, r = np.radians(lay_degrees), core + wire
    own = np.pi / 4 * (core**4 + 6 * wire**4 * np.cos(a))
    return (own + 6 * np.pi * wire**2 * np.cos(a) ** 3 * r**2 / 2) / own


class ExtensibleBeam:
    """Plane beam between a clamp and a point where its slope is zero: axial pull `h`, transverse force `v`, E
    A, E I. N = h cos + v sin, EI theta'' = h sin - v cos (per rest length, times the stretch), x' = (1 +
    N/EA) cos."""

    def __init__(self, length, radius=1.0, inextensible=False):
        self.length, self.ea, self.ei = length, np.pi * radius**2, np.pi * radius**4 / 4
        self.soft = 0.0 if inextensible else 1.0 / self.ea

    def solve(self, unknown, conditions, guess):
        """Solves for the state and `unknown` parameters p -> (h, v); `conditions`(x, z at the end, p) are as
        many."""

        def slopes(s, y, p):
            h, v = unknown(p)
            theta, kappa = y[0], y[1]
            stretch = 1 + self.soft * (h * np.cos(theta) + v * np.sin(theta))
            return np.vstack(
                [
                    kappa,
                    stretch * (h * np.sin(theta) - v * np.cos(theta)) / self.ei,
                    stretch * np.cos(theta),
                    stretch * np.sin(theta),
                ]
            )

        def ends(a, b, p):
            return np.concatenate([[a[0], a[2], a[3], b[0]], conditions(b[2], b[3], p)])

        s = np.linspace(0, self.length, 81)
        z = guess(s)
        y = np.vstack([np.gradient(z, s), np.gradient(np.gradient(z, s), s), s, z])
        # As many parameters as conditions beyond the four of the state.
        self.path = solve_bvp(slopes, ends, s, y, p=self.first, tol=1e-10, max_nodes=20000)
        if not self.path.success:
            raise RuntimeError(self.path.message)
        return self.path


def crossing_fibers(length=100.0, push=2.0):
    """Force between two fibers of radius 1 that cross at right angles, both clamped at both ends and just
    touching, one of them pushed by `push`: each bends by half of it."""
    beam = ExtensibleBeam(length / 2)
    deflection = push / 2
    half = length / 2
    linear = 96 * beam.ei * deflection / length**3
    beam.first = np.array([1e-4, linear])
    path = beam.solve(
        lambda p: (p[0], p[1]),
        lambda x, z, p: [x - half, z - deflection],
        lambda s: deflection * (3 * (s / half) ** 2 - 2 * (s / half) ** 3),
    )
    return 2 * path.p[1]


def weave_half_wave(arc, h, rise):
    """(x, v) of a fiber from crossing to crossing, slope zero at both, rising by `rise` under the pull h."""
    beam = ExtensibleBeam(arc)
    beam.first = np.array([12 * beam.ei * rise / arc**3])
    path = beam.solve(
        lambda p: (h, p[0]),
        lambda x, z, p: [z - rise],
        lambda s: rise * (3 * (s / arc) ** 2 - 2 * (s / arc) ** 3),
    )
    return path.y[2, -1], path.p[0]


@functools.lru_cache
def monofilament_weave(spacing, strain=5e-4):
    """(crimp, K/EA, length of a cell) of a plain weave of fibers of radius 1 without friction that are
    `spacing` long from crossing to crossing: both systems press with the same force, and their rises sum
    up to 4. K: pull on the warp over that strain of it, weft free to move."""

    def length(pull):
        def unequal(rise):
            return weave_half_wave(spacing, pull, rise)[1] - weave_half_wave(spacing, 0.0, 4 - rise)[1]

        return weave_half_wave(spacing, pull, brentq(unequal, 1.0, 3.0, xtol=1e-12))[0]

    first = weave_half_wave(spacing, 0.0, 2.0)[0]
    pull = brentq(lambda h: length(h) / first - 1 - strain, 0.2 * np.pi * strain, np.pi * strain, xtol=1e-9)
    return spacing / first - 1, pull / (np.pi * strain), first


if __name__ == "__main__":
    print("elastica", elastica_tip(1), elastica_tip(10))
    print("column", buckled_column(0.1) / (4 * np.pi**2))
    for f in (300, 450, 600):
        print("45", f, bend_45(f))
    print("greenhill", greenhill(1), greenhill(100))
    for a in (10, 15, 20):
        print("strand", a, strand_1_6(a, 1e-3))
    print("two ply", two_ply(2 * np.pi / 500, 0.01))
    print("bonded", [bonded_over_loose(n) for n in (7, 19, 37)])
    print("crossing", crossing_fibers() * 1e9 * 1e-6)
    print("weave", monofilament_weave(10.0), monofilament_weave(20.0))
    print("yarn", twisted_yarn(np.tan(np.radians(20)) / 2.2, [0.0] + [2.2] * 6, 1.2, 1e-3))
