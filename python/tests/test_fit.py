"""Curves through points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import Image, wave
from numpy.typing import NDArray

import lariat


def bernstein(order: int, count: int) -> NDArray[Any]:
    """The matrix B of the paper, by binomials."""
    rho = np.linspace(0.0, 1.0, count)[:, None]
    j = np.arange(order + 1)[None]
    binomial = np.cumprod(np.concatenate([[1.0], (order - np.arange(order)) / (1.0 + np.arange(order))]))
    return np.asarray(binomial * rho**j * (1.0 - rho) ** (order - j))


def noisy(count: int = 120) -> NDArray[Any]:
    return wave(count) + np.random.default_rng(7).normal(0.0, 0.5, (count, 2))


def test_the_control_points_are_those_of_least_squares() -> None:
    points, b = noisy(), bernstein(8, 120)
    fit = lariat.fit(points)
    expected = np.linalg.lstsq(b, points, rcond=None)[0]
    assert np.abs(fit.control_points - expected).max() < 1e-8
    residuals = points - b @ expected
    assert fit.rms == pytest.approx(np.sqrt((residuals**2).sum(axis=1).mean()))
    assert fit.max == pytest.approx(np.linalg.norm(residuals, axis=1).max())
    assert fit.residual_variance == pytest.approx((residuals**2).sum() / (2 * (120 - 9)))
    assert fit.condition == pytest.approx(np.linalg.cond(b))
    assert (fit.basis, fit.order, fit.closed) == ("bezier", 8, False)


def test_the_covariance_is_that_of_the_regression() -> None:
    b = bernstein(5, 80)
    fit = lariat.fit(noisy(80), 5)
    expected = fit.residual_variance * np.kron(np.linalg.inv(b.T @ b), np.eye(2))
    assert fit.covariance().shape == (12, 12)
    assert np.abs(fit.covariance() - expected).max() < 1e-6 * np.abs(expected).max()


def test_a_point_is_asked_for_by_a_number_or_by_many() -> None:
    fit = lariat.fit(wave(), 6)
    rho = np.linspace(0.0, 1.0, 60)
    assert fit.point_at(0.5).shape == (2,)
    assert np.array_equal(fit.point_at(rho)[7], fit.point_at(rho[7]))
    assert fit.point_at([0.0, 1]).shape == (2, 2) and fit.point_at(np.array([0.5])).shape == (1, 2)
    assert fit.point_at(np.float32(0.5)).shape == (2,) and fit.point_at(np.array(0.5)).shape == (2,)
    assert np.abs(fit.point_at(rho) - bernstein(6, 60) @ fit.control_points).max() < 1e-9
    assert np.abs(fit.jacobian_at(rho) - bernstein(6, 60)).max() < 1e-12
    velocity = (fit.point_at(0.5 + 1e-6) - fit.point_at(0.5 - 1e-6)) / 2e-6
    assert fit.derivative_at(0.5) == pytest.approx(velocity, rel=1e-5)
    assert fit.tangent_at(0.5) == pytest.approx(velocity / np.linalg.norm(velocity), rel=1e-5)
    assert np.linalg.norm(fit.tangent_at(rho), axis=1) == pytest.approx(1.0)
    assert isinstance(fit.curvature_at(0.5), float)
    assert np.shape(fit.curvature_at(rho)) == (60,)
    with pytest.raises(TypeError, match="a number from 0 to 1"):
        fit.point_at("middle")


def test_length_and_nearest_are_those_of_a_straight_line() -> None:
    fit = lariat.fit([[0, 0], [1, 0], [2, 0], [3, 0]], 1)
    assert fit.length() == pytest.approx(3.0)
    assert fit.nearest((1.5, 2.0)) == pytest.approx((0.5, 2.0))


def test_a_traced_curve_is_fitted_as_it_is(image: Image) -> None:
    curve = lariat.trace(image).curves[0]
    fit = lariat.fit(curve)
    assert fit.control_points.shape == (9, 2)
    assert np.array_equal(fit.control_points, lariat.fit(curve.points).control_points)


def test_a_closed_rope_is_a_fourier_series() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    circle = np.stack([100.0 + 30.0 * np.cos(turn), 50.0 + 30.0 * np.sin(turn)], axis=-1)
    fit = lariat.fit(circle, closed=True)
    assert fit.basis == "fourier" and fit.closed and fit.rms < 1e-9
    assert fit.length() == pytest.approx(60.0 * np.pi, rel=1e-6)
    assert fit.curvature_at(0.3) == pytest.approx(1.0 / 30.0)


@pytest.mark.parametrize("basis", ["bezier", "bspline", "rational", "points", "mass"])
def test_every_family_fits(basis: lariat.BasisName) -> None:
    fit = lariat.fit(noisy(), 10, basis)
    assert fit.basis == basis
    assert (fit.weights is not None) == (basis == "rational")
    assert (fit.knots is not None) == (basis == "bspline")
    assert np.isfinite(fit.point_at(0.3)).all()
    assert fit._repr_html_().startswith("<svg")


def test_the_order_can_be_chosen_by_the_points() -> None:
    assert lariat.fit(bernstein(4, 120) @ np.random.default_rng(3).normal(0, 50, (5, 2)), "auto").order == 4


def test_weights_leave_out_what_is_not_seen() -> None:
    points = wave(120)
    points[50] += 40.0
    weights = np.ones(120)
    weights[50] = 0.0
    seen = lariat.fit(points, weights=weights)
    assert np.abs(seen.point_at(50 / 119) - wave(120)[50]).max() < 0.5
    assert lariat.fit(points, robust=True).rms < 0.2 * lariat.fit(points).rms


def test_a_fitter_fits_again_and_again() -> None:
    fitter = lariat.Fitter(120, 8)
    first, second = fitter.fit(wave(120)), fitter.fit(wave(120) + 5.0)
    assert second.control_points == pytest.approx(first.control_points + 5.0, abs=1e-8)
    assert fitter.matrix.shape == (9, 120)
    assert fitter.matrix @ wave(120) == pytest.approx(first.control_points, abs=1e-8)
    assert repr(fitter) == "<lariat.Fitter of a Bezier curve of order 8 to 120 points>"


def test_what_is_wrong_is_said_in_a_sentence() -> None:
    def wrong(*arguments: object, **settings: object) -> str:
        with pytest.raises(ValueError) as error:
            lariat.fit(*arguments, **settings)  # type: ignore[arg-type]
        return str(error.value)

    assert "choose a Bezier curve of order 17" in wrong(wave(120), 24, solver="cholesky")
    assert "give at least 9 points" in wrong(wave(5))
    assert "choose one from 1 to 31" in wrong(wave(120), 40)
    assert '"auto"' in wrong(wave(120), "best")
    assert "choose one of bezier, bspline" in wrong(wave(120), basis="nurbs")
    assert "shape (n, 2)" in wrong(np.zeros((20, 3)))
    assert "shape (n, 2)" in wrong(np.zeros(20))
    assert "no place in a picture" in wrong(np.full((20, 2), np.nan))
    assert "give one for each" in wrong(wave(120), weights=np.ones(3))
    with pytest.raises(ValueError, match="made for 120"):
        lariat.Fitter(120).fit(wave(20))
