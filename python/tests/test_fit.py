"""Curves through points."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import numpy as np
import pytest
from conftest import Image, program, wave
from numpy.typing import NDArray

import lariat


def bernstein(order: int, count: int) -> NDArray[Any]:
    """The matrix B of the paper, from binomials."""
    rho = np.linspace(0.0, 1.0, count)[:, None]
    j = np.arange(order + 1)[None]
    binomial = np.cumprod(np.concatenate([[1.0], (order - np.arange(order)) / (1.0 + np.arange(order))]))
    return np.asarray(binomial * rho**j * (1.0 - rho) ** (order - j))


def noisy(count: int = 120) -> NDArray[Any]:
    return wave(count) + np.random.default_rng(7).normal(0.0, 0.5, (count, 2))


def test_the_control_points_are_those_of_least_squares() -> None:
    points, b = noisy(), bernstein(8, 120)
    fit = lariat.fit(points, 9)
    expected = np.linalg.lstsq(b, points, rcond=None)[0]
    assert np.abs(fit.control_points - expected).max() < 1e-8
    residuals = points - b @ expected
    assert fit.rms == pytest.approx(np.sqrt((residuals**2).sum(axis=1).mean()))
    assert fit.max == pytest.approx(np.linalg.norm(residuals, axis=1).max())
    assert fit.residual_variance == pytest.approx((residuals**2).sum() / (2 * (120 - 9)))
    assert fit.condition == pytest.approx(np.linalg.cond(b))
    assert (fit.basis, fit.degree, fit.closed) == ("bezier", 8, False)


def test_the_covariance_is_that_of_the_regression() -> None:
    b = bernstein(5, 80)
    fit = lariat.fit(noisy(80), 6)
    expected = fit.residual_variance * np.kron(np.linalg.inv(b.T @ b), np.eye(2))
    assert fit.covariance().shape == (12, 12)
    assert np.abs(fit.covariance() - expected).max() < 1e-6 * np.abs(expected).max()


def test_a_point_is_asked_for_by_a_number_or_by_many() -> None:
    fit = lariat.fit(wave(), 7)
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
    fit = lariat.fit([[0, 0], [1, 0], [2, 0], [3, 0]], 2)
    assert fit.length() == pytest.approx(3.0)
    assert fit.nearest((1.5, 2.0)) == pytest.approx((0.5, 2.0))


def test_a_traced_curve_is_fitted_as_it_is(image: Image) -> None:
    curve = lariat.trace(image).curves[0]
    fit = lariat.fit(curve, 9)
    assert fit.control_points.shape == (9, 2)
    assert np.array_equal(fit.control_points, lariat.fit(curve.points, 9).control_points)


def test_without_a_setting_the_curve_is_the_one_that_the_command_chooses(image: Image) -> None:
    curve = lariat.trace(image).curves[0]
    line = {"points": curve.points.tolist(), "width": curve.width_px}
    command = [str(program("lariat")), "fit", "-"]
    said = json.loads(subprocess.run(command, input=json.dumps(line), check=True, capture_output=True, text=True).stdout)
    fit = lariat.fit(curve)
    assert (fit.basis, fit.degree) == (said["basis"], said["degree"])
    assert np.array_equal(fit.control_points, said["control_points"])
    # A thin rope needs more control points than a wide one, and a straight one needs four.
    assert len(lariat.fit(curve, width=2.0).control_points) > len(lariat.fit(curve, width=40.0).control_points)
    assert lariat.fit(np.linspace([0.0, 0.0], [90.0, 30.0], 40)).control_points.shape == (4, 2)


def test_outside_of_0_to_1_there_is_no_rope() -> None:
    fit = lariat.fit(wave(), 7)
    for rho in (-0.1, 1.1, np.nan, [0.0, 1.5]):
        with pytest.raises(ValueError, match="from 0, its first end, to 1"):
            fit.point_at(rho)
    # Steps that add up to 1, except for rounding, reach the end.
    assert sum([0.1] * 10) != 1.0
    assert np.array_equal(fit.point_at(np.cumsum(np.full(49, 1.0 / 49.0)))[-1], fit.point_at(1.0))
    assert np.array_equal(fit.point_at(1.0 + 1e-12), fit.point_at(1.0))


def test_a_closed_rope_is_a_fourier_series() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    circle = np.stack([100.0 + 30.0 * np.cos(turn), 50.0 + 30.0 * np.sin(turn)], axis=-1)
    fit = lariat.fit(circle, closed=True)
    assert fit.basis == "fourier" and fit.closed and fit.rms < 1e-9
    assert fit.length() == pytest.approx(60.0 * np.pi, rel=1e-6)
    assert fit.curvature_at(0.3) == pytest.approx(1.0 / 30.0)


@pytest.mark.parametrize("basis", ["bezier", "bspline", "rational", "points", "mass"])
def test_every_family_fits(basis: lariat.BasisName) -> None:
    fit = lariat.fit(noisy(), 11, basis)
    assert fit.basis == basis
    assert (fit.weights is not None) == (basis == "rational")
    assert (fit.knots is not None) == (basis == "bspline")
    assert np.isfinite(fit.point_at(0.3)).all()
    assert fit._repr_html_().startswith("<svg")


def test_the_control_points_of_a_family_can_be_chosen_by_the_points() -> None:
    points = bernstein(4, 120) @ np.random.default_rng(3).normal(0, 50, (5, 2))
    assert lariat.fit(points, "auto").degree == 4
    assert lariat.fit(points, "auto", "bspline").degree == 3


def test_weights_leave_out_what_is_not_seen() -> None:
    points = wave(120)
    points[50] += 40.0
    weights = np.ones(120)
    weights[50] = 0.0
    seen = lariat.fit(points, 9, weights=weights)
    assert np.abs(seen.point_at(50 / 119) - wave(120)[50]).max() < 0.5
    assert lariat.fit(points, 9, robust=True).rms < 0.2 * lariat.fit(points, 9).rms


def test_a_fitter_fits_again_and_again() -> None:
    fitter = lariat.Fitter(120, 9)
    first, second = fitter.fit(wave(120)), fitter.fit(wave(120) + 5.0)
    assert second.control_points == pytest.approx(first.control_points + 5.0, abs=1e-8)
    assert fitter.matrix.shape == (9, 120)
    assert fitter.matrix @ wave(120) == pytest.approx(first.control_points, abs=1e-8)
    assert repr(fitter) == "<lariat.Fitter of a Bezier curve of 9 control points to 120 points>"


def test_what_is_wrong_is_said_in_a_sentence() -> None:
    def wrong(*arguments: object, **settings: object) -> str:
        with pytest.raises(ValueError) as error:
            lariat.fit(*arguments, **settings)  # type: ignore[arg-type]
        return str(error.value)

    assert "choose a Bezier curve of 18 control points" in wrong(wave(120), 25, solver="cholesky")
    assert "give at least 9 points" in wrong(wave(5), 9)
    assert "2 to 32" in wrong(wave(120), 40)
    assert '"auto"' in wrong(wave(120), "best")
    assert "choose one of auto, bezier, bspline" in wrong(wave(120), basis="nurbs")
    assert "shape (n, 2)" in wrong(np.zeros((20, 3)))
    assert "shape (n, 2)" in wrong(np.zeros(20))
    assert "not a position in a picture" in wrong(np.full((20, 2), np.nan))
    assert "give one for each" in wrong(wave(120), weights=np.ones(3))
    with pytest.raises(ValueError, match="made for 120"):
        lariat.Fitter(120).fit(wave(20))
