"""Single spheres against the published test cases of Wiscombe's code and against another library."""

import miepython
import numpy as np
import pytest

from hcss_twin.models.optics.spheres import mie_efficiencies

# W. J. Wiscombe, Mie Scattering Calculations, NCAR/TN-140+STR (1979, revised 1996): index, x, Q_ext, Q_sca, g
PUBLISHED = [
    (0.75 + 0j, 10.0, 2.232265, 2.232265, 0.896473),
    (1.33 + 1e-5j, 1.0, 0.0939520, 0.0939233, 0.184517),
    (1.33 + 1e-5j, 100.0, 2.101321, 2.096594, 0.868959),
    (1.33 + 1e-5j, 10000.0, 2.004089, 1.723857, 0.907840),
    (1.5 + 0j, 10.0, 2.881999, 2.881999, 0.742913),
    (1.5 + 1j, 0.055, 0.1014910, 1.131687e-5, 0.000491),
    (1.5 + 1j, 1.0, 2.336321, 0.6634538, 0.192136),
    (1.5 + 1j, 100.0, 2.097502, 1.283697, 0.850252),
    (10.0 + 10j, 100.0, 2.071124, 1.836785, 0.556215),
]


@pytest.mark.parametrize(("index", "x", "extinction", "scattering", "asymmetry"), PUBLISHED)
def test_efficiencies_equal_the_tables_of_wiscombe(index, x, extinction, scattering, asymmetry) -> None:
    q_ext, q_sca, g = (float(q[0]) for q in mie_efficiencies(np.array([index]), np.array([x])))
    assert q_ext == pytest.approx(extinction, rel=1e-6)
    assert q_sca == pytest.approx(scattering, rel=1e-6)
    assert g == pytest.approx(asymmetry, abs=6e-7)


def test_many_spheres_at_once_equal_one_by_one_in_another_library() -> None:
    generator = np.random.default_rng(7)
    count = 300
    x = 10.0 ** generator.uniform(-0.5, 2.2, count)
    index = generator.uniform(1.05, 1.8, count) + 1j * 10.0 ** generator.uniform(-6.0, 0.2, count)
    ours = np.array(mie_efficiencies(index, x))
    theirs = np.array([miepython.efficiencies_mx(m.conjugate(), s) for m, s in zip(index, x, strict=True)])
    np.testing.assert_allclose(ours, theirs[:, [0, 1, 3]].T, rtol=2e-8)


def test_a_sphere_does_not_depend_on_its_neighbours() -> None:
    x = np.geomspace(0.05, 150.0, 9000)
    index = np.full(x.size, 1.33 + 0.005j)
    together = np.array(mie_efficiencies(index, x))
    alone = np.array(mie_efficiencies(index[::500], x[::500]))
    np.testing.assert_allclose(together[:, ::500], alone, rtol=1e-11)


@pytest.mark.parametrize(("index", "x"), [(1.3 + 0j, 0.0), (1.3 - 0.1j, 1.0), (0.0 + 1j, 1.0), (1.3 + 0j, np.nan)])
def test_impossible_spheres_are_refused(index, x) -> None:
    with pytest.raises(ValueError, match="allowed"):
        mie_efficiencies(np.array([index]), np.array([x]))
