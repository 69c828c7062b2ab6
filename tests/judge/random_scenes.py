"""Random small scenes, a kind by chance: what a solver of fibers in contact may meet. The seed tells the
scene."""

import math
import random

from scene_text import Scene, helix

R = 10.0  # um
E = 3e9  # Pa


def start(u, title):
    scene = Scene(title)
    scene.material("m", E, u.choice((0.0, 0.3, 0.39)))
    scene.effects["friction"] = u.random() < 0.6
    if scene.effects["friction"]:
        scene.contact["friction_coefficient"] = u.choice((0.1, 0.2, 0.5))
    return scene


def ends(scene, name, points):
    for end, p in (("start", points[0]), ("end", points[-1])):
        scene.body(f"{name}/{end}", p, [(name, end)])


def spline(u, half, angle, height, bow, wave):
    """A curved fiber through the z axis, in plan at an angle to x."""
    c, s = math.cos(angle), math.sin(angle)
    out = []
    for k in range(-4, 5):
        t = k / 4
        side = wave * math.sin(math.pi * t)
        out.append((t * half * c - side * s, t * half * s + side * c, height + bow * (1 - t * t)))
    return out


def stack(u):
    """Two to five curved fibers above each other, radii 1 to 100 apart, driven by displacements, forces or
    turns."""
    scene = start(u, "curved fibers above each other")
    n, model = u.choice((2, 2, 3, 4, 5)), u.choice(("rod", "enriched"))
    ratio = u.choice((1, 1, 3, 10, 100))

    radii = [R * ratio ** u.choice((0, 0, 0.5, 1)) for _ in range(n)]
    half, height, last = 30 * R if ratio < 10 else 15 * R * ratio**0.75, 0.0, 0.0
    for k, r in enumerate(radii):
        scene.fiber_type(f"t{k}", "m", r, model if u.random() < 0.8 else u.choice(("rod", "enriched")))
        bow = u.choice((0, 1, -1)) * u.uniform(0, 0.2) * half
        wave = u.choice((0, 0, 1)) * u.uniform(0, 0.1) * half
        if k:
            height += radii[k - 1] + r + u.uniform(0.05, 2) * min(radii[k - 1], r) + last + abs(bow)
        last = abs(bow)
        points = spline(
            u, half, 0 if k == 0 else math.radians(u.uniform(0, 90)) * u.choice((1, -1)), height, bow, wave
        )
        scene.fiber(f"f{k}", f"t{k}", points, u.choice((8, 12, 16, 24)))
        ends(scene, f"f{k}", points)
    for stage in range(u.choice((1, 1, 2))):
        k = u.randrange(1, n)
        thin = min(radii)
        drives = [
            (
                f"f{k}/*",
                "z",
                "displacement",
                -u.uniform(0.5, 15) * thin - (0 if ratio == 1 else u.uniform(0, 2) * R),
            )
        ]
        if u.random() < 0.5:
            drives.append((f"f{k}/*", u.choice("xy"), "displacement", u.uniform(-10, 10) * thin))
        if u.random() < 0.25:
            drives.append(
                (f"f{k}/end", u.choice(("rx", "ry", "rz")), "displacement", math.radians(u.uniform(-60, 60)))
            )
        scene.stage(f"s{stage}", u.choice((1, 2, 5, 10)), drives)
    return scene


def pressed(u):
    """Two fibers pressed by forces on bodies that are free in z."""
    scene = start(u, "fibers pressed by forces")
    model = u.choice(("rod", "enriched"))
    radii = [R, R * u.choice((0.5, 1, 2))]
    half = 20 * R
    angle = math.radians(u.uniform(5, 90))
    height = (radii[0] + radii[1]) * 0.998  # touching, so that the press is held
    for k, (r, z, a) in enumerate(zip(radii, (0, height), (0, angle))):
        scene.fiber_type(f"t{k}", "m", r, model)
        points = spline(u, half, a, z, 0, 0)
        scene.fiber(f"f{k}", f"t{k}", points, u.choice((8, 12, 16)))
        scene.body(f"f{k}/both", (0, 0, z), [(f"f{k}", "start"), (f"f{k}", "end")])
    stiffness = 48 * E * math.pi * min(radii) ** 4 / 4 / (2 * half) ** 3 * 1e-6  # N per um
    scene.stage(
        "press", u.choice((2, 5, 10)), [("f1/both", "z", "force", -stiffness * R * u.uniform(0.2, 3))]
    )
    return scene


def covered(u):
    """Helices around a straight core, lay angles up to 80 degrees, pulled, twisted or bent."""
    scene = start(u, "helices around a core")
    model = u.choice(("rod", "enriched"))
    core, wire = R * u.choice((1, 1, 2, 5)), R * u.choice((1, 1, 0.5))
    n = u.choice((1, 1, 2, 3, 6))
    lay = math.radians(u.uniform(5, 80))
    radius = core + wire + u.uniform(0.0, 0.05) * wire
    # Windings may not lie in each other: n of them share the pitch.
    pitch = 2 * math.pi * radius / math.tan(lay)
    while (
        n > 1
        and pitch * math.cos(math.pi / 2 - lay) < 2.1 * n * wire
        or 2 * math.pi * radius * math.cos(lay) < 2.1 * n * wire
    ):
        n -= 1
        if n == 0:
            n, lay = 1, math.radians(60)
            pitch = 2 * math.pi * radius / math.tan(lay)
            break
    turns = u.choice((1, 1, 2))
    length = max(turns * pitch, 12 * core)
    turns = length / pitch
    scene.fiber_type("core", "m", core, model)
    scene.fiber_type("wire", "m", wire, "enriched" if model == "enriched" else "rod")
    scene.fiber("core", "core", [(0, 0, 0), (length, 0, 0)], 16)
    names = ["core"]
    along = math.hypot(length, 2 * math.pi * radius * turns)
    elements = max(
        12,
        min(
            60,
            round(along / (3 * wire)),
        ),
        round(16 * turns),
    )
    for k in range(n):
        scene.fiber(f"w{k}", "wire", helix(radius, turns, 2 * math.pi * k / n, length), elements)
        names.append(f"w{k}")
    scene.body("left", (0, 0, 0), [(name, "start") for name in names])
    scene.body("right", (length, 0, 0), [(name, "end") for name in names])
    kind = u.choice(("pull", "pull", "twist", "bend"))
    if kind == "pull":
        scene.stage(
            "pull", u.choice((1, 3, 6)), [("right", "x", "displacement", u.uniform(1e-3, 1e-2) * length)]
        )
    elif kind == "twist":
        scene.stage(
            "twist",
            u.choice((2, 5)),
            [
                ("right", "rx", "displacement", u.choice((1, -1)) * u.uniform(0.1, 0.5)),
                ("right", "x", "displacement", 2e-3 * length),
            ],
        )
    else:
        scene.stage("bend", u.choice((2, 5)), [("right", "z", "displacement", u.uniform(0.02, 0.1) * length)])
    return scene


def ply(u):
    """Two or three fibers twisted around each other without a core, pulled."""
    scene = start(u, "a ply")
    model = u.choice(("rod", "enriched"))
    n, turns = u.choice((2, 2, 3)), u.uniform(0.5, 2)
    radius = R * (1 if n == 2 else 2 / math.sqrt(3))
    lay = math.radians(u.uniform(5, 35))
    # On a helix two strands are nearer than in its section: keep them apart by 1/cos.
    radius *= u.uniform(1.0, 1.03) / math.cos(lay) ** (1 if n == 2 else 1.5)
    length = turns * 2 * math.pi * radius / math.tan(lay)
    scene.fiber_type("f", "m", R, model)
    for k in range(n):
        scene.fiber(
            f"f{k}", "f", helix(radius, turns, 2 * math.pi * k / n, length), max(10, round(20 * turns))
        )
    scene.body("left", (0, 0, 0), [("f*", "start")])
    scene.body("right", (length, 0, 0), [("f*", "end")])
    drives = [("right", "x", "displacement", u.uniform(1e-3, 1e-2) * length)]
    if u.random() < 0.4:
        drives.append(("right", "rx", "displacement", u.uniform(-0.5, 0.5)))
    scene.stage("pull", u.choice((1, 3, 6)), drives)
    return scene


def twisted(u):
    """A bundle, twisted by a body and pulled."""
    scene = start(u, "a bundle twisted and pulled")
    model = u.choice(("rod", "enriched", "enriched"))
    n, length = u.choice((2, 3, 4, 7, 7, 12)), u.uniform(60, 120) * R
    scene.fiber_type("f", "m", R, model)
    scene.bundle(
        "strand",
        "f",
        [(0, 0, 0), (length, 0, 0)],
        u.choice((12, 16, 24)),
        n,
        u.choice((1.0, 1.02, 1.1)),
        u.choice((0, 0, 0.3, -0.5)),
    )
    scene.body("left", (0, 0, 0), [("strand", "start")])
    scene.body("right", (length, 0, 0), [("strand", "end")])
    pull = E * math.pi * R * R * 1e-12 * n * u.uniform(1e-4, 3e-3)
    scene.stage(
        "twist",
        u.choice((4, 9, 18)),
        [
            ("right", "rx", "displacement", u.choice((1, -1)) * u.uniform(0.3, 3.2)),
            ("right", "x", "force", pull),
        ],
    )
    if u.random() < 0.5:
        scene.stage(
            "pull", u.choice((1, 5)), [("right", "x", "displacement", u.uniform(1e-3, 1e-2) * length)]
        )
    return scene


def loop(u):
    """A fiber that meets itself: a loop whose ends are pulled, or an arch that is folded up."""
    scene = start(u, "a fiber that meets itself")
    scene.effects["self_contact"] = True
    scene.fiber_type("f", "m", R, u.choice(("rod", "enriched")))
    size, gap = u.uniform(10, 20) * R, u.uniform(2.05, 4) * R
    n = 24
    points = []
    for k in range(n + 1):  # one turn of a flat helix with straight legs
        a = 2 * math.pi * k / n
        points.append((size * math.sin(a), size * (1 - math.cos(a)), gap * (k / n - 0.5)))
    leg = u.uniform(1, 2) * size
    points = [(-leg, 0, -0.5 * gap)] + points + [(leg, 0, 0.5 * gap)]
    scene.fiber("loop", "f", points, u.choice((24, 36, 48)))
    ends(scene, "loop", points)
    drives = [("loop/end", "x", "displacement", u.uniform(0.2, 1.0) * leg)]
    if u.random() < 0.7:
        drives.append(("loop/end", "z", "displacement", -u.uniform(0.5, 2.0) * gap))
    scene.stage("pull", u.choice((3, 8, 15)), drives)
    return scene


def hooks(u):
    """Two bows that hang in each other, pulled apart."""
    scene = start(u, "bows hooked into each other")
    model = u.choice(("rod", "enriched"))
    r2 = R * u.choice((1, 1, 2))
    bend, leg = u.uniform(3, 15) * max(R, r2), u.uniform(10, 25) * R
    angle = math.radians(u.uniform(45, 90))

    def bow(sign, apex):
        arc = [
            (apex + sign * bend * (1 - math.cos(a)), bend * math.sin(a))
            for a in [math.pi / 16 * k for k in range(-8, 9)]
        ]
        first, last = arc[0], arc[-1]
        return [(first[0] + sign * leg, first[1])] + arc + [(last[0] + sign * leg, last[1])]

    gap = u.uniform(0.02, 0.5) * R
    for k, (sign, r) in enumerate(((-1, R), (1, r2))):
        scene.fiber_type(f"t{k}", "m", r, model)
        # The inner sides of the apexes face each other: the first opens to -x, the second to +x.
        apex = 0.5 * (R + r2 + gap) * -sign
        c, s = (1, 0) if k == 0 else (math.cos(angle), math.sin(angle))
        points = [(x, y * c, y * s) for x, y in bow(sign, apex)]
        scene.fiber(f"f{k}", f"t{k}", points, u.choice((16, 24, 32)))
        scene.body(f"b{k}", (apex + sign * (bend + leg), 0, 0), [(f"f{k}", "start"), (f"f{k}", "end")])
    scene.stage("pull", u.choice((2, 5, 10)), [("b1", "x", "displacement", u.uniform(0.5, 6) * R)])
    return scene


def weave(u):
    """A small weave, woven, relaxed and pulled as the shipped ones."""
    scene = start(u, "a small weave")
    scene.fiber_type("f", "m", R, "enriched" if u.random() < 0.5 else "rod")
    n, fibers = u.choice((2, 2, 3)), u.choice((1, 2, 3, 4))
    layers = 1 if fibers < 4 else 2
    width = 2.1 * R * (fibers / layers)
    spacing = width + u.uniform(3, 6) * R
    pattern = 'pattern = "plain"' if n == 2 or u.random() < 0.7 else 'pattern = "twill"\nrepeat = "2/1"'
    text = f"[weave]\n{pattern}"
    for family in ("warp", "weft"):
        text += (
            f'\n[weave.{family}]\nfiber_type = "f"\nyarns = {n}\nfibers = {fibers}\nlayers = {layers}\n'
            f'elements = {u.choice((9, 12, 15))}\nyarn_spacing = "{spacing:.4f} um"\n'
            f'margin = "{0.75 * spacing:.4f} um"'
        )
    scene.raw(text)
    ends_pull = lambda f: [
        (f"{y}/*/{e}", d, "force", (1 if e == "end" else -1) * f)
        for y, d in (("warp", "x"), ("weft", "y"))
        for e in ("start", "end")
    ]
    unit = E * math.pi * R * R * 1e-12 * fibers
    scene.stage(
        "separate",
        12,
        ends_pull(1e-4 * unit),
        separate_yarns=True,
        friction=False,
        proximal_start=1e-3,
        proximal_end=1e-3,
        fiber_model="rod",
    )
    scene.stage("relax", 10, ends_pull(1e-5 * unit), proximal_start=1e-3, proximal_end=0, fiber_model="rod")
    load = [
        ("side/warp/*", "x", "strain", u.uniform(0.003, 0.015)),
        ("warp/*/start", "x", "follow", "side/warp/start"),
        ("warp/*/end", "x", "follow", "side/warp/end"),
        ("weft/*/start", "y", "force", -1e-5 * unit),
        ("weft/*/end", "y", "force", 1e-5 * unit),
    ]
    scene.stage("load", u.choice((3, 6)), load)
    return scene


KINDS = {
    "stack": (stack, 8),
    "pressed": (pressed, 2),
    "covered": (covered, 4),
    "ply": (ply, 3),
    "twisted": (twisted, 3),
    "loop": (loop, 3),
    "hooks": (hooks, 3),
    "weave": (weave, 2),
}


def scene_of(seed, kind=None):
    """(kind, TOML) of a seed."""
    u = random.Random(seed)
    names = [name for name, (_, weight) in KINDS.items() for _ in range(weight)]
    chosen = u.choice(names)
    kind = kind or chosen
    return kind, KINDS[kind][0](u).text()
