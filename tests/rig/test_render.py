import struct
import time
import zlib

import numpy as np
import pytest
from animations import line, only

from phonanim.media.pixels import draw_text, png_bytes, shortened, text_width
from phonanim.media.raster import EMPTY, rasterize
from phonanim.rig.head import load_head
from phonanim.rig.render import blur, downsample, lower_face, render, to_srgb, whole_head

SQUARE = np.array([[2, 2, 0], [10, 2, 0], [10, 10, 0], [2, 10, 0]], np.float32)
HALVES = np.array([[0, 2, 1], [0, 3, 2]])  # anticlockwise as seen, with rows that count down


def covered_slowly(points, triangles, height, width):
    """The nearest triangle of every pixel, one pixel at a time."""
    face = np.full((height, width), EMPTY)
    depth = np.full((height, width), -np.inf)
    for number, corners in enumerate(triangles):
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[corners].astype(float)
        area = (cx - ax) * (by - ay) - (bx - ax) * (cy - ay)
        if area <= 0:
            continue
        for y in range(height):
            for x in range(width):
                a = ((cy - by) * x + (bx - cx) * y + by * cx - bx * cy) / area
                b = ((ay - cy) * x + (cx - ax) * y + cy * ax - cx * ay) / area
                z = a * az + b * bz + (1 - a - b) * cz
                if min(a, b, 1 - a - b) >= 0 and z > depth[y, x]:
                    face[y, x], depth[y, x] = number, z
    return face, depth


def test_the_rasterizer_agrees_with_the_slow_one():
    rng = np.random.default_rng(1)
    points = (rng.uniform(-4, 28, (30, 3)) + 0.00137).astype(np.float32)
    triangles = rng.permuted(np.tile(np.arange(30), (40, 1)), axis=1)[:, :3]
    picture = rasterize(points, triangles, 20, 24)
    face, depth = covered_slowly(points, triangles, 20, 24)
    assert (picture.face == EMPTY).mean() < 0.5
    np.testing.assert_array_equal(picture.face == EMPTY, face == EMPTY)
    np.testing.assert_allclose(picture.depth, depth, atol=1e-3)


def test_values_are_interpolated_between_corners():
    picture = rasterize(SQUARE, HALVES, 12, 12)
    pixels = picture.covered()
    assert len(pixels) == 81
    row, column = np.divmod(pixels, 12)
    found = picture.at(pixels, SQUARE[:, :2].copy())
    np.testing.assert_allclose(found, np.column_stack([column, row]), atol=1e-5)


def test_backs_and_edges_are_not_drawn():
    assert len(rasterize(SQUARE, HALVES[:, ::-1], 12, 12).covered()) == 0
    assert len(rasterize(SQUARE[:, [0, 0, 2]], HALVES, 12, 12).covered()) == 0
    assert len(rasterize(SQUARE + 100, HALVES, 12, 12).covered()) == 0


def test_the_nearer_is_seen():
    points = np.concatenate([SQUARE, np.add(SQUARE, [0, 0, 1])]).astype(np.float32)
    for order in ([HALVES, HALVES + 4], [HALVES + 4, HALVES]):
        picture = rasterize(points, np.concatenate(order), 12, 12)
        assert picture.depth[5, 5] == 1
        assert set(picture.corners[picture.face[picture.face != EMPTY]].ravel()) == {4, 5, 6, 7}


@pytest.fixture(scope="module")
def head():
    return load_head()


def mouth(head, **weights):
    held = only(line(1), **weights)
    shape = head.shape(head.weights(held.values, held.channels))[0]
    return render(shape, head, lower_face(head, 96, yaw=0)).astype(float)


def test_an_open_mouth_is_dark_inside(head):
    closed, opened = mouth(head), mouth(head, jawOpen=0.5)
    middle = (slice(40, 56), slice(44, 52))
    assert opened[middle].mean() < 0.75 * closed[middle].mean()


def test_a_head_that_faces_the_camera_is_as_wide_on_both_sides(head):
    picture = render(head.vertices, head, whole_head(head, 96, 96)).astype(float)
    skin = (picture[..., 0] > 1.2 * picture[..., 2])[:60]
    np.testing.assert_allclose(skin.mean(), skin[:, ::-1].mean())
    assert np.abs(skin.astype(int) - skin[:, ::-1]).mean() < 0.03


def test_turning_moves_the_nose(head):
    left, right = (render(head.vertices, head, whole_head(head, 96, 96, yaw)) for yaw in (30, -30))
    assert np.abs(left.astype(float) - right).mean() > 4


def test_the_same_input_gives_the_same_bytes(head):
    assert png_bytes(mouth(head).astype(np.uint8)) == png_bytes(mouth(head).astype(np.uint8))


def test_pictures_are_drawn_fast(head):
    start = time.process_time()
    for _ in range(4):
        render(head.vertices, head, lower_face(head, 200))
    assert time.process_time() - start < 4 * 0.25  # a third of a sheet's budget, for slow machines


def test_small_steps():
    assert to_srgb(np.array([0.0, 0.2159, 5.0])).tolist() == [0, 128, 255]
    np.testing.assert_array_equal(
        downsample(np.arange(12, dtype=np.float32).reshape(2, 2, 3), 2), [[[4.5, 5.5, 6.5]]]
    )
    constant = np.full((9, 7), 3.0, np.float32)
    np.testing.assert_allclose(blur(constant, 2), constant, rtol=1e-6)
    dot = np.zeros((9, 9), np.float32)
    dot[4, 4] = 1
    np.testing.assert_allclose(blur(dot, 1).sum(), 1, rtol=1e-5)


def test_png_holds_the_pixels():
    image = np.random.default_rng(0).integers(0, 256, (5, 4, 3), dtype=np.uint8)
    data = png_bytes(image)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack_from(">II", data, 16) == (4, 5)
    length = struct.unpack_from(">I", data, 33)[0]
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(5, 13)
    assert set(rows[:, 0]) == {2}
    np.testing.assert_array_equal(np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(5, 4, 3), image)


def test_letters():
    image = np.zeros((30, 200, 3), np.uint8)
    draw_text(image, "ʃɪp ã", 10, 4, (255, 128, 0), "large")
    inked = np.flatnonzero(image.any(axis=(0, 2)))
    assert inked.min() >= 9
    assert inked.max() <= 11 + text_width("ʃɪp ã", "large")
    assert (image[..., 2] == 0).all()
    draw_text(image, "cut", -8, -6, (255, 255, 255))
    draw_text(image, "cut", 195, 25, (255, 255, 255))
    assert text_width("a\u0303") == text_width("a")
    assert text_width("\U0001f600") == text_width("?")


def test_long_texts_are_shortened():
    assert shortened("word", 200) == "word"
    short = shortened("a very long word", 60)
    assert short.endswith("…")
    assert text_width(short) <= 60
