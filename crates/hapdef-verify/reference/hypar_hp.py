"""Strain energy of the partly clamped hyperbolic paraboloid by an hp method that hardly locks.

The surface z = x² - y² over [-1/2, 1/2]², clamped at x = -1/2, under 8000 t per area along -z,
E = 2e11, nu = 0.3 (Bathe, Iosilevich and Chapelle, Comput. Struct. 75, 2000). Half of it, y >= 0.

The model is the basic shell model of Chapelle and Bathe, The Finite Element Analysis of Shells,
2011, section 4.2, without the terms in xi_3²: displacement u + xi_3 theta with theta tangent to the
surface, strains by the true surface and its curvature, shear factor 5/6. Nodal bases of degree p
on a tensor grid of n by n/2 even elements with thin ones along the clamped side and the free edges.

Needs numpy and scipy:  python3 hypar_hp.py 1e-5 8 12
prints t/L, p, n, unknowns, energy.
"""

import sys

import numpy as np
import scipy.sparse as sp
from numpy.polynomial import legendre
from scipy.sparse.linalg import splu

E, NU, LOAD, SHEAR = 2e11, 0.3, 8000.0, 5 / 6
G, LAMBDA = E / (2 * (1 + NU)), E * NU / (1 - NU**2)


def lobatto_nodes(p):
    return np.concatenate([[-1], legendre.legroots(legendre.legder([0] * p + [1])), [1]])


def line_basis(p, q):
    """Values and derivatives [q, p + 1] of the nodal basis at q Gauss points; points, weights."""
    x, w = legendre.leggauss(q)
    slope = [legendre.legval(x, legendre.legder(row)) if k else 0 * x for k, row in enumerate(np.eye(p + 1))]
    to_modes = np.linalg.inv(legendre.legvander(lobatto_nodes(p), p))
    return legendre.legvander(x, p) @ to_modes, np.stack(slope, 1) @ to_modes, x, w


def surface(x, y):
    """Covariant vectors a_1, a_2, the unit normal a_3, its derivatives, and the area factor."""
    one, zero = np.ones_like(x), np.zeros_like(x)
    vector = lambda *parts: np.stack(parts, -1)
    a1, a2 = vector(one, zero, 2 * x), vector(zero, one, -2 * y)
    normal = vector(-2 * x, 2 * y, one)
    area = np.linalg.norm(normal, axis=-1)
    a3 = normal / area[..., None]
    turn = lambda d: (d - a3 * np.sum(a3 * d, -1, keepdims=True)) / area[..., None]
    return (a1, a2), a3, (turn(vector(-2 * one, zero, zero)), turn(vector(zero, 2 * one, zero))), area


def tangents(x, y):
    """The orthonormal tangents that carry the rotations of a node."""
    (a1, _), a3, _, _ = surface(x, y)
    t1 = a1 / np.linalg.norm(a1, axis=-1, keepdims=True)
    return t1, np.cross(a3, t1)


def element_ends(length, layer, n, at_start):
    """n even elements, and two thin ones at the far end, and at the start where asked."""
    layer = min(layer, length / 6)
    start = [0.0, 0.25 * layer, layer] if at_start else [0.0]
    even = np.linspace(start[-1], length - layer, n + 1)[1:]
    return np.array([*start, *even, length - 0.25 * layer, length])


def strain_matrix(shape, slopes, nodal_tangents, a, a3, da3):
    """Membrane 11, 22, 2·12, bending 11, 22, 2·12, shear 1, 2 by u and two rotations: [q, 8, m, 5]."""
    b = np.zeros((len(shape), 8, shape.shape[1], 5))
    for row, (i, k, factor) in enumerate([(0, 0, 0.5), (1, 1, 0.5), (0, 1, 1.0)]):
        for u, v in [(i, k), (k, i)]:
            b[:, row, :, :3] += factor * slopes[v][:, :, None] * a[u][:, None, :]
            b[:, row + 3, :, :3] += factor * slopes[v][:, :, None] * da3[u][:, None, :]
            for r in range(2):
                b[:, row + 3, :, 3 + r] += factor * slopes[v] * (a[u] @ nodal_tangents[r].T)
    for i in range(2):
        b[:, 6 + i, :, :3] = slopes[i][:, :, None] * a3[:, None, :]
        for r in range(2):
            b[:, 6 + i, :, 3 + r] = shape * (a[i] @ nodal_tangents[r].T)
    return b


def material(t, a):
    """Plane stress in covariant components, integrated over the thickness: [q, 8, 8]."""
    g = np.linalg.inv(np.stack([np.stack([np.sum(u * v, -1) for v in a], -1) for u in a], -2))
    c = np.zeros((len(g), 8, 8))
    pairs = [(0, 0), (1, 1), (0, 1)]
    for r, (i, j) in enumerate(pairs):
        for s, (k, l) in enumerate(pairs):
            value = G * (g[:, i, k] * g[:, j, l] + g[:, i, l] * g[:, j, k]) + LAMBDA * g[:, i, j] * g[:, k, l]
            c[:, r, s], c[:, 3 + r, 3 + s] = t * value, t**3 / 12 * value
    c[:, 6:, 6:] = SHEAR * t * G * g
    return c


def energy(t, p, n):
    layer = 6 * np.sqrt(t)
    ends_x, ends_y = element_ends(1.0, layer, n, True) - 0.5, element_ends(0.5, layer, n // 2, False)
    values, slopes, at, weight = line_basis(p, p + 3)
    nodes = lobatto_nodes(p)
    grid = (len(ends_x) - 1) * p + 1, (len(ends_y) - 1) * p + 1
    product = lambda u, v: np.einsum("ai,bj->abij", u, v).reshape(len(at) ** 2, -1)
    elements, load = [], np.zeros(5 * grid[0] * grid[1])
    for i in range(len(ends_x) - 1):
        for j in range(len(ends_y) - 1):
            hx, hy = (ends_x[i + 1] - ends_x[i]) / 2, (ends_y[j + 1] - ends_y[j]) / 2
            place = lambda s: [v.ravel() for v in np.meshgrid(ends_x[i] + hx * (s + 1), ends_y[j] + hy * (s + 1), indexing="ij")]
            a, a3, da3, area = surface(*place(at))
            shape = product(values, values)
            gradient = product(slopes, values) / hx, product(values, slopes) / hy
            b = strain_matrix(shape, gradient, tangents(*place(nodes)), a, a3, da3)
            w = np.outer(weight, weight).ravel() * hx * hy * area
            c = material(t, a) * w[:, None, None]
            index = (i * p + np.arange(p + 1))[:, None] * grid[1] + j * p + np.arange(p + 1)
            dof = (index.ravel()[:, None] * 5 + np.arange(5)).ravel()
            elements.append((dof, b.reshape(*b.shape[:2], -1), c))
            load[dof.reshape(-1, 5)[:, 2]] -= LOAD * t * (shape.T @ w)
    fixed = np.zeros((*grid, 5), bool)
    fixed[0] = True
    fixed[:, 0, [1, 4]] = True  # the mirror at y = 0, where the second tangent is e_y
    free = ~fixed.ravel()
    return load[free] @ solve(elements, load, free), free.sum()


def solve(elements, load, free):
    """Conjugate gradients on strains, which keep the small membrane strains that the rounding of
    the assembled stiffness loses; its factor is the preconditioner."""
    blocks = [np.einsum("qrm,qrs,qsn->mn", b, c, b, optimize=True) for _, b, c in elements]
    rows = np.concatenate([np.repeat(dof, len(dof)) for dof, _, _ in elements])
    columns = np.concatenate([np.tile(dof, len(dof)) for dof, _, _ in elements])
    stiffness = sp.csc_matrix((np.concatenate([k.ravel() for k in blocks]), (rows, columns)), shape=(len(load),) * 2)
    options = dict(permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=dict(SymmetricMode=True))
    precondition = splu(stiffness[free][:, free], **options).solve

    def stiffness_times(v):
        full, out = np.zeros(len(load)), np.zeros(len(load))
        full[free] = v
        for dof, b, c in elements:
            stress = np.einsum("qrs,qsm,m->qr", c, b, full[dof], optimize=True)
            out[dof] += np.einsum("qrm,qr->m", b, stress)
        return out[free]

    u, r = np.zeros(free.sum()), load[free].copy()
    z = precondition(r)
    d, rz = z.copy(), r @ z
    for _ in range(4):
        u += rz / (d @ stiffness_times(d)) * d
        r = load[free] - stiffness_times(u)
        z = precondition(r)
        d, rz = z + (r @ z) / rz * d, r @ z
    return u


if __name__ == "__main__":
    t, p, n = float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    value, unknowns = energy(t, p, n)
    print(f"{t:g} {p} {n} {unknowns} {value:.6g}")
