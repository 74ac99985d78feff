"""Consequents from forces: known ones come back, and M stays positive definite."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from scipy.optimize import minimize

from psp3.errors import UnusableEstimate
from psp3.fuzzy_control import force_learning
from psp3.fuzzy_control.force_learning import (
    Samples,
    learn_consequents,
    regressor_blocks,
)


def matrices(triangles: np.ndarray, joints: int) -> np.ndarray:
    out = np.zeros((len(triangles), joints, joints))
    first, second = np.triu_indices(joints)
    out[:, first, second] = out[:, second, first] = triangles
    return out


def samples_of(
    joints: int, rules: int, count: int, seed: int = 0
) -> tuple[Samples, list[np.ndarray]]:
    """Return samples without forces, and consequents of M, G and C that could make some."""
    rng = np.random.default_rng(seed)
    centers, x = rng.uniform(-1, 1, (rules, joints)), rng.uniform(-1, 1, (count, joints))
    firing = np.exp(-8.0 * ((x[:, np.newaxis] - centers) ** 2).sum(axis=-1))
    phi = firing / firing.sum(axis=1, keepdims=True)
    root = rng.normal(size=(rules, joints, joints))
    M = np.eye(joints) + 0.2 * root @ np.swapaxes(root, 1, 2)
    v, w = rng.normal(size=(2, count, joints))
    upper = np.triu_indices(joints)
    known = [M[:, upper[0], upper[1]], rng.normal(size=(rules, joints))]
    known.append(rng.normal(size=(rules, joints**2)))
    return Samples(v, w, np.zeros_like(v), phi, phi, None), known


def with_forces(samples: Samples, known: list[np.ndarray]) -> Samples:
    blocks = regressor_blocks(samples)
    forces = sum(np.einsum("sire,re->si", b, c) for b, c in zip(blocks, known, strict=True))
    return samples._replace(forces=np.asarray(forces))


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_known_consequents_come_back_from_noiseless_forces(joints: int) -> None:
    """The least ridge, 1e-10 of the largest squared singular value, is all that is between."""
    samples, known = samples_of(joints, 4, 400)
    found = learn_consequents(with_forces(samples, known), positive_definite=True)
    for name, expected in zip(("mass", "gravity", "coriolis"), known, strict=True):
        np.testing.assert_allclose(getattr(found, name), expected, atol=1e-6)


def test_where_it_is_asked_m_of_every_rule_is_positive_definite() -> None:
    """Against a general optimizer over Cholesky factors, to what that finds: 1e-4 of M."""
    joints, rules = 2, 3
    samples, known = samples_of(joints, rules, 150, 3)
    known[0][1] = [1.0, 2.0, 1.0]  # eigenvalues -1 and 3
    samples = with_forces(samples, known)
    free = learn_consequents(samples, positive_definite=False)
    np.testing.assert_allclose(free.mass[1], known[0][1], atol=1e-6)
    found = learn_consequents(samples, positive_definite=True)
    least = np.linalg.eigvalsh(matrices(found.mass, joints)).min()
    assert least > 0.0

    blocks = regressor_blocks(samples)
    sizes = np.sqrt((samples.forces**2).mean(axis=0))
    design = np.concatenate(
        [(b / sizes[:, None, None]).reshape(samples.forces.size, -1) for b in blocks], axis=1
    )
    targets = (samples.forces / sizes).ravel()

    def missed(factors: np.ndarray) -> float:
        lower = np.zeros((rules, joints, joints))
        lower[:, [0, 1, 1], [0, 0, 1]] = factors.reshape(rules, 3)
        M = lower @ np.swapaxes(lower, 1, 2) + least * np.eye(joints)
        rest = targets - design[:, : 3 * rules] @ M[:, [0, 0, 1], [0, 1, 1]].ravel()
        other = np.linalg.lstsq(design[:, 3 * rules :], rest, rcond=None)[0]
        return float(((rest - design[:, 3 * rules :] @ other) ** 2).sum())

    best = min(
        (
            minimize(missed, np.random.default_rng(k).normal(size=3 * rules), method="BFGS")
            for k in range(3)
        ),
        key=lambda result: result.fun,
    ).fun
    values = np.concatenate([found.mass.ravel(), found.gravity.ravel(), found.coriolis.ravel()])  # type: ignore[union-attr]
    ours = float(((targets - design @ values) ** 2).sum())
    assert ours == pytest.approx(best, rel=1e-4)


def test_forces_of_no_mass_are_refused() -> None:
    samples, known = samples_of(2, 3, 100)
    known[0] = -known[0]
    with pytest.raises(UnusableEstimate, match="harmonics") as caught:
        learn_consequents(with_forces(samples, known), positive_definite=True)
    # Accelerations are random, so that positions tell nothing: 3 of 100 samples' worth is fitted.
    assert caught.value.told_apart == pytest.approx(np.sqrt(0.97), abs=0.02)


def test_where_accelerations_follow_from_positions_the_error_says_so() -> None:
    """As of a motion of one harmonic: accelerations are a combination of the basis functions."""
    samples, known = samples_of(2, 5, 100)
    samples = samples._replace(accelerations=samples.of_mass @ np.ones((5, 2)))
    known[0] = -known[0]
    with pytest.raises(UnusableEstimate, match="same places with other accelerations") as caught:
        learn_consequents(with_forces(samples, known), positive_definite=True)
    assert caught.value.told_apart < 1e-12


def test_blocks_of_samples_say_what_all_at_once_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """The triangular factor has the design's minimum: equal to rounding, 1e-9 of numbers near 1.

    With noise on the forces, so that the ridge matters, too.
    """
    samples, known = samples_of(2, 5, 300, 2)
    samples = with_forces(samples, known)
    noise = 0.1 * np.random.default_rng(3).normal(size=samples.forces.shape)
    samples = samples._replace(forces=samples.forces + noise)
    monkeypatch.setattr(force_learning, "BLOCK", 10**9)
    whole = learn_consequents(samples, positive_definite=True)
    for block in (1, 7, 299):
        monkeypatch.setattr(force_learning, "BLOCK", block)
        found = learn_consequents(samples, positive_definite=True)
        for name in ("mass", "gravity", "coriolis"):
            np.testing.assert_allclose(getattr(found, name), getattr(whole, name), atol=1e-9)


def test_the_memory_is_that_of_the_samples_and_not_of_their_design() -> None:
    """20 000 samples of 2 forces and 5 rules: a design of 45 columns would take 14.4 MB."""
    samples, known = samples_of(2, 5, 20_000, 2)
    samples = with_forces(samples, known)
    tracemalloc.start()
    learn_consequents(samples, positive_definite=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 7e6


def test_noise_averages_out_over_the_samples() -> None:
    """Sixteen times as many samples, a quarter of the error: the law of averages, within a half."""
    missed = []
    for count in (500, 8000):
        samples, known = samples_of(2, 4, count, 4)
        samples = with_forces(samples, known)
        noise = 0.3 * np.random.default_rng(5).normal(size=samples.forces.shape)
        found = learn_consequents(samples._replace(forces=samples.forces + noise), True)
        missed.append(float(np.sqrt(((found.gravity - known[1]) ** 2).mean())))
    assert 0.125 < missed[1] / missed[0] < 0.5
