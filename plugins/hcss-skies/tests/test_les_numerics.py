"""Advection and pressure: order, conservation, no over-shoots, no divergence."""

import numpy as np
import pytest
from hcss_skies.les.advection import advect, advect_w, constants, step
from hcss_skies.les.grid import Mesh, stretched_faces
from hcss_skies.les.pressure import PressureSolver

STRETCHED = stretched_faces(1500.0, [(0.0, 25.0), (600.0, 10.0), (900.0, 10.0), (1500.0, 40.0)])


def winds(mesh, dtype=np.float64, seed=0):
    """Random winds without divergence, and the densities (faces, cells) that they were made for."""
    rng = np.random.default_rng(seed)
    u, v = (rng.normal(size=mesh.shape).astype(dtype) for _ in range(2))
    w = rng.normal(size=(*mesh.columns, mesh.levels + 1)).astype(dtype)
    w[..., 0] = w[..., -1] = 0.0
    densities = np.exp(-mesh.faces_m / 8e3), np.exp(-mesh.centres_m / 8e3)
    solver = PressureSolver(mesh, *densities)
    solver.project(u, v, w)
    return (u, v, w), densities, solver


def tendency(q, flow, densities, mesh, shift=(0, 0)):
    rate = np.zeros_like(q)
    kind = q.dtype.type
    per_mass = (1.0 / (densities[1] * mesh.depth_m)).astype(q.dtype)
    advect(q, *flow, *shift, densities[0].astype(q.dtype), per_mass, kind(1.0 / mesh.side_m), rate, constants(q.dtype))
    return rate


def carried(cells, axis):
    """The error of cell means of a wave after it has crossed a tenth of the box."""
    shape = [4, 4, 6]
    shape[axis] = cells
    mesh = Mesh((shape[0], shape[1]), 1.0 / cells, np.arange(7.0))
    flow = [np.zeros(mesh.shape), np.zeros(mesh.shape), np.zeros((*mesh.columns, 7))]
    flow[axis][...] = 1.0
    densities = np.ones(7), np.ones(6)

    def wave(time):
        nodes, weights = np.polynomial.legendre.leggauss(8)
        points = (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes) / cells - time
        fine = np.exp(np.sin(2.0 * np.pi * points)) @ (0.5 * weights)
        profile = np.moveaxis(np.broadcast_to(fine, [*[n for a, n in enumerate(shape) if a != axis], cells]), -1, axis)
        return np.ascontiguousarray(profile)

    steps = int(np.ceil(0.1 * 2.0 * cells ** (5.0 / 3.0)))
    q, new = wave(0.0), wave(0.0)
    for _ in range(steps):
        old = q.copy()
        for part in (3, 2, 1):
            step(new, old, tendency(new, flow, densities, mesh), 0.1 / steps / part)
        q = new.copy()
    return np.abs(q - wave(0.1)).mean()


@pytest.mark.parametrize("axis", [0, 1])
def test_the_error_of_a_smooth_wave_falls_with_the_fifth_power_of_the_cell(axis):
    assert np.log2(carried(32, axis) / carried(64, axis)) > 4.5


def test_what_leaves_a_cell_enters_its_neighbours():
    mesh = Mesh((8, 12), 50.0, STRETCHED)
    flow, densities, _ = winds(mesh)
    q = np.random.default_rng(1).random(mesh.shape)
    rate = tendency(q, flow, densities, mesh) * densities[1] * mesh.depth_m
    assert abs(rate.sum()) < 1e-13 * np.abs(rate).sum()


@pytest.mark.parametrize("shift", [(0, 0), (1, 0), (0, 1)], ids=["scalar", "u", "v"])
def test_a_uniform_field_stays_uniform_on_a_stretched_grid(shift):
    mesh = Mesh((8, 12), 50.0, STRETCHED)
    flow, densities, _ = winds(mesh)
    assert np.abs(tendency(np.full(mesh.shape, 7.0), flow, densities, mesh, shift)).max() < 1e-13


def test_the_momentum_of_w_is_kept_but_for_sea_and_lid():
    mesh = Mesh((8, 12), 50.0, STRETCHED)
    (u, v, w), (rho, rho_cells), _ = winds(mesh)
    around = rho * np.concatenate([[1.0], 0.5 * (mesh.depth_m[1:] + mesh.depth_m[:-1]), [1.0]])
    mass = rho_cells * mesh.depth_m
    below, above = np.concatenate([[0.0], mass]) / around / 2, np.concatenate([mass, [0.0]]) / around / 2
    rate = np.zeros_like(w)
    advect_w(w, u, v, below, above, rho, 1.0 / around, 1.0 / mesh.side_m, rate, constants(w.dtype))
    # the flux of w through the first and the last cell centre ends at sea and lid
    ends = [0.5 * rho[k] * w[..., k] * w[..., k] for k in (1, -2)]
    assert abs((rate * around).sum()) < 2.0 * sum(np.abs(end).sum() for end in ends)
    assert np.all(rate[..., 0] == 0.0)
    assert np.all(rate[..., -1] == 0.0)


def test_a_step_is_carried_without_overshoot():
    mesh = Mesh((64, 4), 1.0, np.arange(7.0))
    flow = np.ones(mesh.shape), np.zeros(mesh.shape), np.zeros((64, 4, 7))
    q = np.zeros(mesh.shape)
    q[20:40] = 1.0
    new = q.copy()
    for _ in range(40):
        old = new.copy()
        for part in (3, 2, 1):
            step(new, old, tendency(new, flow, (np.ones(7), np.ones(6)), mesh), 0.5 / part)
    assert new.min() > -2e-3
    assert new.max() < 1.0 + 2e-3
    assert np.abs(new - np.roll(q, 20, axis=0)).mean() < 0.05


@pytest.mark.parametrize(("dtype", "limit"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_winds_have_no_divergence_after_projection(dtype, limit):
    mesh = Mesh((12, 16), 35.0, STRETCHED)
    flow, densities, solver = winds(mesh, dtype)
    divergence = solver.divergence(*flow) / (densities[1] * mesh.depth_m)
    assert np.abs(divergence).max() < limit


def test_winds_without_divergence_stay_as_they_are():
    mesh = Mesh((12, 16), 35.0, STRETCHED)
    flow, _, solver = winds(mesh)
    again = tuple(field.copy() for field in flow)
    solver.project(*again)
    for one, other in zip(flow, again, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)


def test_faces_follow_the_given_spacing_and_end_at_the_lid():
    depth = np.diff(STRETCHED)
    assert STRETCHED[0] == 0.0
    assert STRETCHED[-1] == 1500.0
    centres = 0.5 * (STRETCHED[1:] + STRETCHED[:-1])
    wanted = np.interp(centres, [0.0, 600.0, 900.0, 1500.0], [25.0, 10.0, 10.0, 40.0])
    np.testing.assert_allclose(depth, wanted, rtol=0.03)
