"""What a saved state must fulfil to be an equilibrium with all its contacts. Each check returns a list of
complaints."""

import numpy as np
from scipy.spatial import cKDTree

import elastic
from states import groups, ties

# A place counts as missed where the outlines overlap by more than this share of the thinner radius.
MISSED = 0.01
# Forces and moments of groups, and of single fibers, are balanced to this share of the sizes that cancel.
BALANCE = 0.02
# Nodes of a fiber are in balance to this share of its contact forces.
LOCAL = 0.05
# ... and all to this share of E I/L^2, a force that bends nothing, and of what is pulled along a fiber.
NOISE, ALONG = 1e-3, 1e-3
# Overlap, in thinner radii, at which a state is no longer one of touching fibers.
DEEP = 0.3


def is_at_rest(state):
    """Whether a state is an equilibrium, not one on the way, held back by a proximal term or parted by an order of
    crossings."""
    return state.proximal == 0 and not state.settings.get("separate_yarns", False)


def wants_contact(mesh, state, a, b):
    """Whether the scene asks for contact of fibers a and b in the state's stage."""
    effects = mesh.scene.get("effects", {})
    scope = effects.get("contact", "all")
    if scope == "none":
        return False
    if a == b:
        return effects.get("self_contact", False)
    if scope == "between_yarns" and mesh.yarn[a] == mesh.yarn[b]:
        return False
    kinds = {mesh.yarn_family[mesh.yarn[a]], mesh.yarn_family[mesh.yarn[b]]}
    return not (state.settings.get("separate_yarns", False) and kinds == {0, 1})


class Samples:
    """Points along all fibers, closer than a third of the thinnest radius around them where that is
    affordable."""

    def __init__(self, state, most=6000):
        mesh = state.mesh
        parts = []
        for f in range(mesh.n_fibers):
            length = mesh.length(f)
            n = int(np.clip(np.ceil(length / (0.35 * mesh.radius[f])), 16, most))
            s = np.linspace(0, length, n + 1)
            parts.append((np.full(n + 1, f), s, state.curve(f, s), np.full(n + 1, length / n)))
        self.fiber, self.s, self.r, self.step = (np.concatenate(x) for x in zip(*parts))


def near_pairs(state):
    """Starting points (a, s_a, b, s_b) for closest points: samples whose balls of touching distance meet."""
    mesh = state.mesh
    p = Samples(state)
    pairs = [np.zeros((0, 2), int)]
    # By classes of size, so that one thick fiber does not make all pairs of thin ones near.
    size = np.floor(np.log2(mesh.radius[p.fiber] / mesh.radius.min()) + 1e-9).astype(int)
    classes = {k: np.flatnonzero(size == k) for k in np.unique(size)}
    trees = {k: cKDTree(p.r[i]) for k, i in classes.items()}
    for k, i in classes.items():
        for m, j in classes.items():
            if m < k:
                continue
            reach = 1.15 * (mesh.radius[p.fiber[i]].max() + mesh.radius[p.fiber[j]].max())
            reach = np.hypot(reach, 0.5 * (p.step[i].max() + p.step[j].max()))
            found = trees[k].sparse_distance_matrix(trees[m], reach, output_type="ndarray")
            pairs.append(np.stack([i[found["i"]], j[found["j"]]], 1))
    pairs = np.concatenate(pairs)
    i, j = pairs[:, 0], pairs[:, 1]
    swap = (p.fiber[i] > p.fiber[j]) | ((p.fiber[i] == p.fiber[j]) & (p.s[i] > p.s[j]))
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    a, b = p.fiber[i], p.fiber[j]
    # On one fiber, what lies within 2 pi R of arc cannot be a loop that touches itself.
    keep = (a != b) | (p.s[j] - p.s[i] > 2 * np.pi * mesh.radius[a])
    return a[keep], p.s[i[keep]], b[keep], p.s[j[keep]]


def feet(state, a, b, s_a, s_b):
    """For points s_a of fiber a the nearest ones of b near s_b: Newton's method for (r_b - r_a)·r_b' = 0."""
    target = state.curve(a, s_a)
    limit = 0.5 * state.mesh.radius[b] + 0.5 * state.mesh.radius[a]
    for _ in range(12):
        r, d, dd = state.curve(b, s_b, 2)
        chord = r - target
        slope, curvature = (chord * d).sum(1), (d * d).sum(1) + (chord * dd).sum(1)
        step = np.where(
            curvature > 0.1 * (d * d).sum(1), -slope / np.maximum(curvature, 1e-300), -np.sign(slope) * limit
        )
        s_b = np.clip(s_b + np.clip(step, -limit, limit), 0, state.mesh.length(b))
    r, d = state.curve(b, s_b, 1)
    chord = r - target
    inside = (
        (s_b > 0) & (s_b < state.mesh.length(b)) & (np.abs((chord * d).sum(1)) < 1e-6 * state.mesh.radius[b])
    )
    return s_b, chord, inside


def overlaps(state):
    """Where outlines overlap: per pair of fibers arrays (s_a, s_b, overlap over the thinner radius), chords
    normal to b."""
    mesh = state.mesh
    a, s_a, b, s_b = near_pairs(state)
    out = {}
    if not len(a):
        return out
    order = np.lexsort((b, a))
    a, s_a, b, s_b = a[order], s_a[order], b[order], s_b[order]
    starts = np.flatnonzero(np.r_[True, (a[1:] != a[:-1]) | (b[1:] != b[:-1])])
    for i, j in zip(starts, np.r_[starts[1:], len(a)]):
        fa, fb = a[i], b[i]
        if not wants_contact(mesh, state, fa, fb):
            continue
        # Feet on the thicker of the two: a thick fiber's samples are far apart for a thin one.
        p, q, sp, sq = (fa, fb, s_a[i:j], s_b[i:j])
        if mesh.radius[p] > mesh.radius[q]:
            p, q, sp, sq = q, p, sq, sp
        sq, chord, inside = feet(state, p, q, sp, sq)
        distance = np.linalg.norm(chord, axis=1)
        n = chord / np.maximum(distance, 1e-300)[:, None]
        depth = (state.reach(p, sp, n) + state.reach(q, sq, n) - distance) / min(
            mesh.radius[p], mesh.radius[q]
        )
        # Ends have no caps: what lies within a radius of one is not asked for.
        for f, s in ((p, sp), (q, sq)):
            inside &= (s > mesh.radius[f]) & (s < mesh.length(f) - mesh.radius[f])
        if fa == fb:
            inside &= np.abs(sp - sq) > 2 * np.pi * mesh.radius[fa]
        k = inside & (depth > 0) & (mesh.is_judged(p, sp) | mesh.is_judged(q, sq))
        if k.any():
            out[fa, fb] = (sp[k], sq[k], depth[k]) if p == fa else (sq[k], sp[k], depth[k])
    return out


def contacts_complete(state):
    """Every place where two fibers overlap has an element of that pair near."""
    mesh, missed, deep = state.mesh, [], []
    have = {}
    for k in range(len(state.a)):
        a, b, s, t = state.a[k], state.b[k], state.s_a[k], state.s_b[k]
        if a > b or (a == b and s > t):
            a, b, s, t = b, a, t, s
        have.setdefault((a, b), []).append((s, t, state.stands_for[k]))
    for (a, b), (s, t, depth) in overlaps(state).items():
        radii = mesh.radius[a] + mesh.radius[b]
        elements = np.array(have.get((a, b), [])).reshape(-1, 3)
        covered = np.zeros(len(s), bool)
        for x, y, length in elements:
            near = 1.5 * length + radii
            covered |= (np.abs(s - x) < near) & (np.abs(t - y) < near)
        lost = ~covered & (depth > MISSED)
        if lost.any():
            worst = np.argmax(np.where(lost, depth, 0))
            missed.append(
                (
                    depth[worst],
                    f"fibers {a} and {b} overlap by {depth[worst]:.3f} R at s = {s[worst]:.4g} and "
                    f"{t[worst]:.4g} m, and no contact element is near",
                )
            )
        if depth.max() > DEEP:
            worst = np.argmax(depth)
            deep.append(
                (
                    depth[worst],
                    f"fibers {a} and {b} lie {depth[worst]:.2f} R inside each other at "
                    f"s = {s[worst]:.4g} and {t[worst]:.4g} m",
                )
            )
    return ([x for _, x in sorted(missed, reverse=True)], [x for _, x in sorted(deep, reverse=True)])


def points_of_action(state):
    """Where the forces of contact elements act, on a and on b: the axis of a rod, the surface of a beam."""
    out = []
    for of, arc in ((state.a, state.s_a), (state.b, state.s_b)):
        at = state.position.copy()
        for f in np.unique(of):
            k = np.flatnonzero(of == f)
            if state.is_rod[f]:
                at[k] = state.curve(f, arc[k])
        out.append(at)
    return out


def turns(state, fiber):
    """Angles between the tangents of neighbouring nodes."""
    t = state.t[state.mesh.nodes(fiber)]
    t = t / np.linalg.norm(t, axis=1)[:, None]
    return np.arccos(np.clip((t[1:] * t[:-1]).sum(1), -1, 1))


def bending_force(mesh, fiber):
    """E I/L^2."""
    return mesh.axial_stiffness[fiber] * mesh.radius[fiber] ** 2 / 4 / mesh.length(fiber) ** 2


def group_balance(state):
    """Forces and moments on the fibers that bodies hold together are in balance."""
    mesh, complaints = state.mesh, []
    on_b = state.normal * state.normal_force[:, None] + state.friction
    at_a, at_b = points_of_action(state)
    for fibers, bodies in groups(mesh, state):
        own = np.zeros(mesh.n_fibers, bool)
        own[fibers] = True
        forces, points, moments = (
            [state.body_force[bodies]],
            [state.body_position[bodies]],
            state.body_moment[bodies],
        )
        inner = np.zeros(
            3
        )  # moment of contacts within the group: friction of rods acts on their axes, and so turns them
        for of, other, at, sign in ((state.b, state.a, at_b, 1), (state.a, state.b, at_a, -1)):
            k = own[of] & ~own[other]
            forces.append(sign * on_b[k])
            points.append(at[k])
            k = own[of] & own[other]
            inner += sign * np.cross(at[k], on_b[k]).sum(0)
        force, point = np.concatenate(forces), np.concatenate(points)
        nodes = np.concatenate([state.r[mesh.nodes(f)] for f in fibers])
        arm = point - nodes.mean(0)
        # Moments of clamps count as the forces that they stand for at the far end.
        reach = np.linalg.norm(arm, axis=1).max(initial=mesh.radius[fibers].max())
        size = np.linalg.norm(force, axis=1).sum() + np.linalg.norm(moments, axis=1).sum() / reach
        noise = NOISE * sum(bending_force(mesh, f) for f in fibers)
        off = np.linalg.norm(force.sum(0))
        name = mesh.yarn_names[mesh.yarn[fibers[0]]]
        who = f"{len(fibers)} fibers from {name} on" if len(fibers) > 1 else f"fiber {name}"
        if off > BALANCE * size + noise:
            complaints.append(f"{who}: forces are out of balance by {off:.3g} of {size:.3g} N")
        moment = np.concatenate([np.cross(arm, force), moments])
        # A lever within the section is not known better than the overlap: forces of bodies and contact count
        # with it.
        slack = size * mesh.radius[fibers].max() * 2 * BALANCE
        moment_size = np.linalg.norm(moment, axis=1).sum()
        turn = np.linalg.norm(moment.sum(0) + inner)
        if turn > BALANCE * moment_size + slack + noise * reach:
            complaints.append(f"{who}: moments are out of balance by {turn:.3g} of {moment_size:.3g} N m")
    return complaints


def fiber_balance(state, start):
    """Elastic forces of each fiber balance its contacts at every node that no body holds."""
    mesh, complaints = state.mesh, []
    tied = {(f, end) for f, end, _ in ties(mesh)}
    for f in range(mesh.n_fibers):
        if not mesh.is_judged(f, 0.5 * mesh.length(f)):
            continue
        force, elastic_size, contact_size = elastic.nodal_balance(state, start, f)
        free = mesh.is_judged(f, np.linspace(0, mesh.length(f), len(force)))
        free[0] &= (f, "start") not in tied
        free[-1] &= (f, "end") not in tied
        ends = sum(np.linalg.norm(force[k]) for k in (0, -1) if not free[k])
        off = np.linalg.norm(force[free], axis=1).sum()
        # Against what loads it across: its contacts, the pull at its ends as far as the fiber turns, and what
        # bends it. A pull along a straight fiber must not hide what is missing across it. Contacts are saved in
        # single precision, so that forces that cancel are known to 1e-6.
        turning = turns(state, f)
        bent = np.abs(turning - (0 if state.is_rod[f] else turns(start, f))).sum()
        size = contact_size[free].sum() + ends * min(1.0, turning.sum()) + bending_force(mesh, f) * bent
        allowed = LOCAL * size + ALONG * ends + 1e-6 * elastic_size.sum() + NOISE * bending_force(mesh, f)
        if off > allowed:
            complaints.append(
                f"fiber {f} of {mesh.yarn_names[mesh.yarn[f]]}: elastic forces and contacts are out of "
                f"balance by {off:.3g} N, summed over its nodes, where what loads it across sums up to {size:.3g} N"
            )
    return complaints


def friction_law(state):
    """Contacts push, friction is tangential and at most mu N."""
    mesh, complaints = state.mesh, []
    effects = mesh.scene.get("effects", {})
    on = effects.get("friction", True) and state.settings.get("friction", True)
    mu = mesh.scene.get("contact", {}).get("friction_coefficient", 0.2) if on else 0.0
    largest = state.normal_force.max(initial=0)
    drag = np.linalg.norm(state.friction, axis=1)
    if (state.normal_force < 0).any():
        complaints.append(f"{(state.normal_force < 0).sum()} contacts pull")
    over = drag > mu * state.normal_force * (1 + 1e-3) + 1e-5 * largest
    if over.any():
        k = np.argmax(drag - mu * state.normal_force)
        complaints.append(
            f"{over.sum()} contacts bear more friction than mu N, the worst {drag[k]:.3g} N at "
            f"N = {state.normal_force[k]:.3g} N, mu = {mu}"
        )
    along = np.abs((state.friction * state.normal).sum(1)) > 1e-3 * drag + 1e-6 * largest
    if along.any():
        complaints.append(f"friction of {along.sum()} contacts is not tangential")
    # Forces settle where the gap is zero, up to the target on either side, but for 1 % of them, and up to three
    # times the target; on the way, a force may outlast its overlap.
    if is_at_rest(state):
        target = mesh.scene.get("contact", {}).get("target_penetration", 0.01)
        gap = state.gap / (0.5 * (mesh.radius[state.a] + mesh.radius[state.b]))
        across = (state.normal_force > 1e-3 * largest) & (gap > 3 * target + 1e-3)
        share = state.normal_force[gap > target + 1e-3].sum() / max(state.normal_force.sum(), 1e-300)
        if across.any() or share > 0.01:
            complaints.append(
                f"{across.sum()} contacts press across a gap, {100 * share:.2g} % of all forces across more "
                "than the target"
            )
    return complaints


def finite(state):
    bad = [
        k
        for k in ("r", "g1", "g2", "t", "body_force", "body_moment", "normal_force", "gap", "friction")
        if not np.isfinite(getattr(state, k)).all()
    ]
    return [f"{k} has values that are not finite" for k in bad]


def coplanar_times(p, q):
    """Times 0 ... 1 at which pieces p0 p1 and q0 q1, whose points (n, 2 (time), 3) move straight, cut each
    other, with the sign of the passage: +1 from below to above along the common normal. Returns an array
    of (sign) per piece pair, 0 for none."""
    p0, p1, q0, q1 = p[0], p[1], q[0], q[1]
    at = lambda x, t: x[:, 0] + t * (x[:, 1] - x[:, 0])
    volume = lambda t: (np.cross(at(p1, t) - at(p0, t), at(q1, t) - at(q0, t)) * (at(q0, t) - at(p0, t))).sum(
        1
    )
    # A cubic in t from four values.
    t = np.array([0, 1 / 3, 2 / 3, 1])
    coefficients = np.linalg.solve(np.vander(t), np.stack([volume(x) for x in t]))
    signs = np.zeros(len(p0), int)
    for k in np.flatnonzero(np.abs(coefficients).max(0) > 0):
        for root in np.roots(np.trim_zeros(coefficients[:, k], "f")):
            if abs(root.imag) > 1e-9 or not 0 < root.real <= 1:
                continue
            x = root.real
            a, b, c, d = (at(y[k : k + 1], x)[0] for y in (p0, p1, q0, q1))
            # a + u (b - a) = c + v (d - c)
            m = np.stack([b - a, c - d], 1)
            (u, v), *_ = np.linalg.lstsq(m, c - a, rcond=None)
            if 0 <= u < 1 and 0 <= v < 1:
                slope = np.polyval(np.polyder(coefficients[:, k]), x)
                signs[k] += int(np.sign(slope))
    return signs


def passed_through(before, after):
    """Pairs of fibers whose axes cut each other if every node goes straight from one saved state to the next.
    Where something turns by more than a quarter of a turn in between, straight ways say nothing, and no
    one is accused."""
    mesh = after.mesh
    turned = (before.t * after.t).sum(1) < 0.5 * np.linalg.norm(before.t, axis=1) * np.linalg.norm(
        after.t, axis=1
    )
    if turned.any():
        return []
    complaints = []
    boxes = []
    for f in range(mesh.n_fibers):
        x = np.stack([before.r[mesh.nodes(f)], after.r[mesh.nodes(f)]], 1)
        boxes.append((x, np.minimum(x[:-1], x[1:]).min(1), np.maximum(x[:-1], x[1:]).max(1)))
    low = np.array([b[1].min(0) for b in boxes])
    high = np.array([b[2].max(0) for b in boxes])
    for a in range(mesh.n_fibers):
        others = np.flatnonzero(((low[a] <= high[a + 1 :]) & (low[a + 1 :] <= high[a])).all(1)) + a + 1
        for b in others:
            if not wants_contact(mesh, after, a, b):
                continue
            (xa, la, ha), (xb, lb, hb) = boxes[a], boxes[b]
            i, j = np.nonzero(((la[:, None] <= hb[None]) & (lb[None] <= ha[:, None])).all(-1))
            if not len(i):
                continue
            # A fiber that passes exactly at a node of the other (scenes are symmetric) would be counted by
            # both pieces that end there, or by neither: one of the two is moved by next to nothing, off it.
            aside = 1e-6 * mesh.radius[a] * np.array([0.61, -0.47, 0.64])
            # Passages through one fiber and back again cancel.
            total = coplanar_times((xa[i] + aside, xa[i + 1] + aside), (xb[j], xb[j + 1])).sum()
            if total != 0:
                complaints.append(
                    f"fibers {a} and {b} have passed through each other since the saved state before"
                )
    return complaints
