"""Elastic forces of fibers: an own reading of the equations of micro/fiber/README.md."""

import numpy as np
from scipy.optimize import lsq_linear

from states import node_slopes, value_hermite, value_lagrange

GAUSS = 1 / np.sqrt(3)
ACTS_WITHIN = 0.2  # of a radius


def material(mesh, fiber):
    """E_L, E_T, G, nu_LT, nu_TT of a fiber in Pa. E_L is that of the file, so that only ratios come from the
    scene."""
    table = mesh.scene["material"][mesh.scene["fiber_type"][mesh.fiber_table(fiber)[1]]["material"]]
    axial = mesh.axial_stiffness[fiber] / (np.pi * mesh.radius[fiber] ** 2)
    if table["model"] == "isotropic":
        nu = table["poisson_ratio"]
        return axial, axial, axial / (2 * (1 + nu)), nu, nu
    pascal = lambda key: modulus(table[key])
    scale = axial / pascal("young_modulus_axial")
    return (
        axial,
        scale * pascal("young_modulus_transverse"),
        scale * pascal("shear_modulus_axial"),
        table["poisson_ratio_axial"],
        table["poisson_ratio_transverse"],
    )


def modulus(value):
    number, unit = value.split()
    return float(number) * {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12}[unit]


def strains(z, radius, share):
    """The twelve (or with the coupling fifteen) measures of z = (r', g1, g2, g1', g2'), and r'-conjugate
    rows."""
    dr, g1, g2, d1, d2 = z
    dot = lambda a, b: (a * b).sum(-1)
    m1 = dot(d1, d1) + dot(d2, d2)
    return np.stack(
        [
            0.5 * dot(dr, dr) + share * radius**2 / 8 * m1,
            0.5 * dot(g1, g1),
            0.5 * dot(g2, g2),
            dot(g1, g2),
            dot(dr, g1),
            dot(dr, g2),
            dot(dr, d1),
            dot(dr, d2),
        ]
    )


def axial_stress(strain):
    """Second Piola stress over E_L: linear, but below a stretch of 0.8 the nominal stress goes on from there
    as a logarithm with the slope that it has there."""
    kept = 0.8
    stretch = np.sqrt(np.maximum(1 + 2 * strain, 1e-12))
    at_kept = kept * (kept**2 - 1) / 2
    slope = (3 * kept**2 - 1) / 2
    nominal = at_kept + kept * slope * np.log(stretch / kept)
    return np.where(stretch < kept, nominal / stretch, strain)


def beam_force(state, start, fiber):
    """Force on each node of a beam by the elements, of its position: -dW/dr."""
    mesh, at = state.mesh, state.mesh.nodes(fiber)
    radius, h = mesh.radius[fiber], mesh.element_length(fiber)
    e_l, e_t, g, nu, nu_t = material(mesh, fiber)
    coupled = mesh.scene.get("effects", {}).get("twist_stretch", True)
    share = 1 if coupled else 4 * nu * g / e_l
    compliance = np.array(
        [
            [1 / e_l, -nu / e_l, -nu / e_l],
            [-nu / e_l, 1 / e_t, -nu_t / e_t],
            [-nu / e_l, -nu_t / e_t, 1 / e_t],
        ]
    )
    normal = np.linalg.inv(compliance)
    area = np.pi * radius**2
    out = np.zeros((at.stop - at.start, 3))
    size = np.zeros(at.stop - at.start)
    for point in (-GAUSS, GAUSS):
        n, dn, _ = value_lagrange(np.array(point), h)

        def z_of(s):
            pick = lambda x, w: sum(w[k] * x[at][k : at.stop - at.start - 2 + k : 2] for k in range(3))
            return pick(s.r, dn), pick(s.g1, n), pick(s.g2, n), pick(s.g1, dn), pick(s.g2, dn)

        z = z_of(state)
        e = strains(z, radius, share) - strains(z_of(start), radius, share)
        axial = area * (normal[0] @ e[:3] + e_l * (axial_stress(e[0]) - e[0]))
        shear = area * g * e[4:6]
        bending = e_l * area * radius**2 / 4 * e[6:8]
        pulls = [
            axial[:, None] * z[0],
            shear[0][:, None] * z[1],
            shear[1][:, None] * z[2],
            bending[0][:, None] * z[3],
            bending[1][:, None] * z[4],
        ]
        force = sum(pulls)
        for k in range(3):
            out[k : len(out) - 2 + k : 2] -= h / 2 * dn[k] * force
            size[k : len(out) - 2 + k : 2] += (
                h / 2 * abs(dn[k]) * sum(np.linalg.norm(p, axis=1) for p in pulls)
            )
    return out, size


def rod_force(state, fiber):
    """Force on each end of a rod's elements, of its position: -dW/dr."""
    mesh, at = state.mesh, state.mesh.nodes(fiber)
    radius, h, ea = mesh.radius[fiber], mesh.element_length(fiber), mesh.axial_stiffness[fiber]
    r, d = state.r[at][::2], state.t[at][::2]
    q = (r[:-1], d[:-1], r[1:], d[1:])
    out, size = np.zeros((len(r), 3)), np.zeros(len(r))

    def add(weights, stress):
        for k, node in ((0, 0), (2, 1)):
            out[node : len(r) - 1 + node] -= weights[k] * stress
            size[node : len(r) - 1 + node] += abs(weights[k]) * np.linalg.norm(stress, axis=1)

    for point, weight in ((-1, 1 / 6), (0, 4 / 6), (1, 1 / 6)):
        w = value_hermite(np.array(float(point)), h)[1]
        slope = sum(c * x for c, x in zip(w, q))
        strain = 0.5 * ((slope * slope).sum(1) - 1)
        add(w, h * weight * ea * axial_stress(strain)[:, None] * slope)
    for point in (-GAUSS, GAUSS):
        w = value_hermite(np.array(point), h)[2]
        add(w, h * 0.5 * ea * radius**2 / 4 * sum(c * x for c, x in zip(w, q)))
    return out, size


def nodal_balance(state, start, fiber):
    """Elastic plus contact forces on the nodes of a fiber (every second one of a rod), and their sizes: first
    the elastic ones that cancel, then what contact brings."""
    mesh, h = state.mesh, state.mesh.element_length(fiber)
    rod = state.is_rod[fiber]
    force, size = rod_force(state, fiber) if rod else beam_force(state, start, fiber)
    contact_size = np.zeros(len(force))
    shifts = []  # what the force on nodes changes by when a contact acts a unit farther along
    total = state.normal * state.normal_force[:, None] + state.friction  # on b
    for of, arc, sign in ((state.a, state.s_a, -1), (state.b, state.s_b, 1)):
        k = np.flatnonzero((of == fiber) & (np.linalg.norm(total, axis=1) > 0))
        if not len(k):
            continue
        e, t = state.locate(fiber, arc[k])
        if rod:
            w = value_hermite(t, h)[0]
            weights = np.zeros((len(k), len(force)))
            weights[np.arange(len(k)), e], weights[np.arange(len(k)), e + 1] = w[0], w[2]
        else:
            node, t = state.stretch(fiber, arc[k])
            w = value_hermite(t, h / 2)[0]
            value, slope = np.eye(len(force)), node_slopes(len(force), h / 2)
            parts = (value[node], slope[node], value[node + 1], slope[node + 1])
            weights = sum(c[:, None] * x for c, x in zip(w, parts))
            w = value_hermite(t, h / 2)[1]
            along = sum(c[:, None] * x for c, x in zip(w, parts))
            shifts.append(sign * along[:, :, None] * total[k][:, None, :])
        force += sign * weights.T @ total[k]
        contact_size += abs(weights).T @ np.linalg.norm(total[k], axis=1)
    if shifts:
        force = with_contacts_shifted(force, np.concatenate(shifts), ACTS_WITHIN * mesh.radius[fiber])
    return force, size, contact_size


def with_contacts_shifted(force, shifts, most):
    """The same with the forces of contacts where they fit best, up to `most` along the fiber: a contact on a
    section that grows along it does not act at the point where it is nearest."""
    inner = slice(1, -1)
    columns = shifts[:, inner].reshape(len(shifts), -1).T
    scale = np.linalg.norm(columns, axis=0)
    used = scale > 1e-9 * scale.max(initial=0)
    if not used.any():
        return force
    limit = most * scale[used]
    found = lsq_linear(columns[:, used] / scale[used], -force[inner].ravel(), bounds=(-limit, limit))
    return force + np.tensordot(found.x / scale[used], shifts[used], 1)
