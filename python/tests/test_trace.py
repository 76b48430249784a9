"""Ropes in arrays."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Image, rope_through, wave
from numpy.typing import NDArray

import lariat


def distance_from_wave(points: NDArray[Any]) -> NDArray[Any]:
    """Distances of points from the wave, except those near the tips, which are drawn round."""
    middle = points[8:-8, None]
    distances: NDArray[Any] = np.linalg.norm(middle - wave(2000)[None], axis=-1).min(axis=1)
    return distances


def test_a_drawn_rope_is_found_where_it_was_drawn(image: Image) -> None:
    scene = lariat.trace(image)
    (curve,) = scene.curves
    assert curve.points.shape == (120, 2) and curve.points.dtype == np.float32
    assert distance_from_wave(curve.points).max() < 0.5
    assert curve.width_px == pytest.approx(9.0, abs=0.5)
    assert (curve.status, curve.closed, curve.leaves_image) == ("ok", False, (False, False))
    assert not curve.hidden.any() and curve.hidden.shape == curve.widths_px.shape == (120,)
    assert scene.size == (320, 240) and scene.crossings == [] and scene.notice is None


def test_no_rope_is_an_answer() -> None:
    table = np.full((100, 100, 3), 200, np.uint8)
    assert lariat.trace(table).curves == []


def test_an_array_of_any_strides_says_the_same(image: Image) -> None:
    points = lariat.trace(image).curves[0].points
    for other in [
        np.asfortranarray(image),
        image[::-1][::-1],
        np.pad(image, ((3, 3), (5, 5), (0, 0)))[3:-3, 5:-5],
        np.repeat(image, 2, axis=1)[:, ::2],
        np.dstack([image, image[..., :1]])[..., :3],
        np.ascontiguousarray(image[..., ::-1])[..., ::-1],
    ]:
        assert np.array_equal(lariat.trace(other).curves[0].points, points)
    flipped = lariat.trace(image[:, ::-1]).curves[0].points
    assert np.abs(np.sort(319.0 - flipped[:, 0]) - np.sort(points[:, 0])).max() < 0.1


def test_every_pixel_format_finds_the_rope(image: Image) -> None:
    gray = image.mean(axis=2).astype(np.uint8)
    mosaic = image[..., 1].copy()
    mosaic[::2, ::2], mosaic[1::2, 1::2] = image[::2, ::2, 0], image[1::2, 1::2, 2]
    pictures: list[tuple[lariat.Picture, lariat.PixelFormat]] = [
        (np.dstack([image[..., ::-1], gray]), "bgra"),
        (gray.astype(np.uint16) * np.uint16(257), "gray16"),
        (mosaic, "bayer_rggb8"),
        (gray, "gray"),
        (gray[..., None], "gray"),
        (image, "rgb"),
        (image[..., ::-1], "bgr"),
        (np.dstack([gray, np.full_like(gray, 128)]), "yuyv"),
        (np.dstack([np.full_like(gray, 128), gray]), "uyvy"),
        (np.vstack([gray, np.full((120, 320), 128, np.uint8)]), "nv12"),
    ]
    for picture, pixel_format in pictures:
        scene = lariat.trace(picture, pixel_format=pixel_format)
        assert scene.size == (320, 240), pixel_format
        assert distance_from_wave(scene.curves[0].points).max() < 0.7, pixel_format


def test_gray_of_16_bits_needs_no_name(image: Image) -> None:
    wide = image.mean(axis=2).astype(np.uint16) * np.uint16(257)
    (curve,) = lariat.trace(wide[:, ::-1]).curves
    points = np.asarray(curve.points) * [-1.0, 1.0] + [319.0, 0.0]
    assert distance_from_wave(points).max() < 0.7
    with pytest.raises(TypeError, match="gray16"):
        lariat.trace(wide, pixel_format="nv12")


def test_a_mask_may_be_colours_or_a_picture(image: Image) -> None:
    ranges, agreement = lariat.pick(image)
    assert agreement > 0.8
    rope = image[..., 0] < 120
    masks: list[lariat.MaskImage | lariat.HsvRange | Sequence[lariat.HsvRange]]
    masks = [ranges, ranges[0], rope, rope.astype(np.uint8) * np.uint8(255)]
    for mask in masks:
        (curve,) = lariat.trace(image, mask=mask).curves
        assert distance_from_wave(curve.points).max() < 1.0
    # Instance numbers are accepted as ropes, with a warning.
    with pytest.warns(UserWarning, match="the mask's levels are numbers: 1 counts as rope"):
        (curve,) = lariat.trace(image, mask=rope.astype(np.uint8)).curves
    assert distance_from_wave(curve.points).max() < 1.0
    assert lariat.trace(image, mask={"hue_deg": (0.0, 10.0)}).curves == []
    assert lariat.trace(image, mask=np.zeros((240, 320), bool)).curves == []


def test_the_network_finds_the_rope(image: Image, tmp_path: Path) -> None:
    (curve,) = lariat.trace(image, mask="network").curves
    assert np.abs(curve.points - lariat.trace(image).curves[0].points).max() < 3
    (tmp_path / "my.weights").write_bytes(b"none")
    with pytest.raises(ValueError, match="LARIATN1"):
        lariat.trace(image, mask="network", network=tmp_path / "my.weights")
    with pytest.raises(FileNotFoundError):
        lariat.trace(image, mask="network", network=tmp_path / "other.weights")
    (tmp_path / "my.weights").write_bytes((Path(__file__).parents[2] / "crates/network/ropes.weights").read_bytes())
    with pytest.raises(ValueError, match="have no use for"):
        lariat.trace(image, mask={"hue_deg": (0.0, 10.0)}, network=tmp_path / "my.weights")


def test_only_the_ropes_that_are_meant_are_told(image: Image) -> None:
    (curve,) = lariat.trace(image).curves
    at = (float(curve.points[40, 0]), float(curve.points[40, 1]))
    assert len(lariat.trace(image, at=[at]).curves) == 1
    assert lariat.trace(image, at=[(2.0, 2.0)]).curves == []


def test_colours_are_picked_at_points(image: Image) -> None:
    (middle,) = lariat.trace(image).curves
    points = [(float(middle.points[k][0]), float(middle.points[k][1])) for k in (20, 60, 100)]
    places: list[tuple[float, float] | list[tuple[float, float]]] = [points[0], points]
    for at in places:
        ranges, agreement = lariat.pick(image, at)
        assert agreement > 0.8
        (curve,) = lariat.trace(image, mask=ranges).curves
        assert distance_from_wave(curve.points).max() < 1.0
    strokes = np.full((160, 240, 3), 220, np.uint8)
    for x in range(20, 200, 60):
        for y in range(30, 150, 45):
            # None of them continues another one.
            y += x // 60 % 2 * 20
            strokes[y : y + 5, x : x + 40] = (40, 90, 190)
    with pytest.warns(UserWarning, match="give two more points"):
        lariat.pick(strokes, (40.0, 32.0))


def test_only_the_region_is_read_and_places_are_those_of_the_whole_picture(image: Image) -> None:
    (curve,) = lariat.trace(image, roi=(0, 0, 160, 240)).curves
    assert curve.leaves_image == (False, True)
    assert curve.points[:, 0].max() < 160.0
    assert distance_from_wave(curve.points).max() < 0.5


def test_a_rope_over_itself_is_a_crossing_with_a_sequence() -> None:
    t = np.linspace(-1.35, 1.35, 120)
    loop = np.stack([160.0 + 110.0 * (t**3 - t), 190.0 - 110.0 * t**2], axis=-1)
    scene = lariat.trace(rope_through(loop))
    (crossing,) = scene.crossings
    assert crossing.over == crossing.under == 0
    assert np.abs(np.array(crossing.at) - [160.0, 80.0]).max() < 3.0
    assert scene.curves[0].crossing_sequence in ("O1 U1", "U1 O1")
    assert scene.curves[0].pulls_straight is True


def test_a_tracer_knows_a_rope_again_and_follows_it() -> None:
    tracer = lariat.Tracer()
    tracks, followed = set(), []
    for frame in range(8):
        scene = tracer.trace(rope_through(wave() + [0.5 * frame, 0.0]), at_ns=frame * 33_000_000)
        tracks.add(scene.curves[0].track)
        followed.append(scene.followed)
    assert len(tracks) == 1 and followed[-1] and not followed[0]
    lost = tracer.trace(np.full((240, 320, 3), 200, np.uint8), at_ns=8 * 33_000_000)
    assert [curve.status for curve in lost.curves] == ["lost"]
    assert lost.curves[0].age == pytest.approx(0.033)
    tracer.reset()
    assert tracer.trace(rope_through(wave())).followed is False


def test_an_array_keeps_what_it_shows_alive_and_cannot_be_written_to(image: Image) -> None:
    points = lariat.trace(image).curves[0].points
    before = points.copy()
    lariat.trace(image[::-1])
    assert np.array_equal(points, before)
    assert isinstance(points.base, lariat.Curve)
    with pytest.raises(ValueError, match="read-only"):
        points[0] = 0.0
    with pytest.raises(ValueError):
        points.flags.writeable = True


def test_what_is_wrong_is_said_in_a_sentence(image: Image) -> None:
    def wrong(*arguments: object, **settings: object) -> str:
        with pytest.raises((ValueError, TypeError)) as error:
            lariat.trace(*arguments, **settings)  # type: ignore[arg-type]
        return str(error.value)

    assert "float64" in wrong(image / 255.0) and ".astype(numpy.uint8)" in wrong(image / 255.0)
    assert "numpy.asarray" in wrong([[1, 2], [3, 4]])
    assert "image[..., :3]" in wrong(np.zeros((4, 4, 4), np.uint8))
    assert "choose 2 to 256" in wrong(image, points=1)
    assert "choose one of gray, rgb, bgr" in wrong(image, pixel_format="hsv")
    assert "(height, width, 3)" in wrong(image[..., 0], pixel_format="bgr")
    assert "choose one of skeleton, kmeans" in wrong(image, method="magic")
    assert "hue_deg, saturation and value" in wrong(image, mask={"hue": (0, 1)})
    assert "lariat.pick" in wrong(image, mask="blue")
    assert "of its own size" in wrong(image, mask=np.zeros((3, 3), bool))
    assert "(x, y, width, height)" in wrong(image, roi=(1000, 0, 10, 10))
    assert "at least 1" in wrong(np.zeros((0, 5), np.uint8))


def test_other_threads_run_while_a_picture_is_traced(image: Image) -> None:
    """Each thread has its own tracer; using one tracer in two threads at once is refused safely."""
    results: list[int] = []

    def work() -> None:
        tracer = lariat.Tracer()
        for _ in range(5):
            results.append(len(tracer.trace(image).curves))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [1] * 20


def test_a_notebook_shows_the_ropes(image: Image) -> None:
    scene = lariat.trace(image)
    html = scene._repr_html_()
    assert html.startswith("<svg") and html.count("<polyline") == 1 and "1 rope" in html
    assert "120 points" in scene.curves[0]._repr_html_()
    assert repr(scene) == "<lariat.Scene of 320×240 px: 1 rope, no crossing>"


def test_what_the_mask_is_unsure_of_is_told() -> None:
    scene = lariat.trace(np.zeros((100, 100), np.uint8))
    assert scene.notice is not None
    assert scene.notice.name == "black" and "uncover the lens" in str(scene.notice)
    assert "uncover the lens" in scene._repr_html_()
