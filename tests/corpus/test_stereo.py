"""Stereo reconstruction on made-up cameras: exact without noise, and as noisy as the pixels with it."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.corpus.stereo import (
    calibrate_camera,
    calibrate_cameras,
    drop_outliers,
    project_points,
    read_calibration,
    read_view,
    reconstruct,
)
from phonanim.errors import CorpusError

FOCAL, WIDE = 2000.0, 600.0  # pixels, millimetres from the face to each camera
CUBE = np.array([[x, y, z] for x in (-80, 0, 80) for y in (-90, 90) for z in (-60.0, 50.0)])


def camera(degrees: float) -> np.ndarray:
    """A camera in front of the face, turned about the vertical axis."""
    turn = np.radians(degrees)
    rotation = np.array([[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]])
    inner = np.array([[FOCAL, 0, 640], [0, FOCAL, 360], [0, 0, 1.0]])
    return inner @ np.column_stack([rotation, [0, 0, WIDE]])


CAMERAS = [camera(0), camera(60)]


def face(rng: np.random.Generator, frames: int = 40, points: int = 12) -> np.ndarray:
    return rng.uniform(-50, 50, (frames, points, 3))


def calibrated(rng: np.random.Generator, noise: float = 0.0) -> list[np.ndarray]:
    return [
        calibrate_camera(CUBE, project_points(c, CUBE) + rng.normal(0, noise, (len(CUBE), 2)))
        for c in CAMERAS
    ]


def test_a_calibrated_camera_is_the_one_that_saw() -> None:
    for found, made in zip(calibrated(np.random.default_rng(0)), CAMERAS, strict=True):
        np.testing.assert_allclose(found / found[2, 3], made / made[2, 3], atol=1e-7)


def test_points_without_noise_are_exact() -> None:
    rng = np.random.default_rng(1)
    points = face(rng)
    found = reconstruct(calibrated(rng), [project_points(c, points) for c in CAMERAS])
    np.testing.assert_allclose(found.points, points, atol=1e-6)
    assert found.apart.max() < 1e-6


def test_noise_of_pixels_becomes_that_of_millimetres() -> None:
    """Half a pixel is 0.15 mm across; two views at 60 degrees see depth about as well."""
    rng = np.random.default_rng(2)
    points, noise = face(rng, frames=400), 0.5
    views = [project_points(c, points) + rng.normal(0, noise, (*points.shape[:2], 2)) for c in CAMERAS]
    found = reconstruct(CAMERAS, views)
    error = found.points - points
    across = noise * WIDE / FOCAL
    height = error[..., 1].std()  # both views see it: their mean
    assert height == pytest.approx(across / np.sqrt(2), rel=0.1)
    assert across * 0.5 < error[..., 2].std() < 3 * across
    assert abs(error.mean(axis=(0, 1))).max() < 0.02
    # It is as good as the best solution of pixels, found by a small step in each direction.
    residual = (found.apart**2).sum(axis=0)
    for step in 0.05 * np.eye(3):
        for sign in (-1, 1):
            moved = [
                project_points(c, found.points + sign * step) - v for c, v in zip(CAMERAS, views, strict=True)
            ]
            assert (sum((m**2).sum(axis=-1) for m in moved) > residual).mean() > 0.95


def test_noise_in_the_calibration_stays_small() -> None:
    rng = np.random.default_rng(3)
    points = face(rng)
    views = [project_points(c, points) for c in CAMERAS]
    found = reconstruct(calibrated(rng, noise=0.2), views)
    assert np.linalg.norm(found.points - points, axis=-1).mean() < 0.3


def test_a_point_that_one_view_sees_is_unknown_and_a_third_view_helps() -> None:
    rng = np.random.default_rng(4)
    points, cameras = face(rng), [*CAMERAS, camera(-40)]
    views = [project_points(c, points) for c in cameras]
    views[0][3, 5] = np.nan
    views[1][3, 6] = views[0][3, 6] = np.nan
    found = reconstruct(cameras, views).points
    np.testing.assert_allclose(found[3, 5], points[3, 5], atol=1e-6)
    assert np.isnan(found[3, 6]).all()
    assert np.isfinite(found).all(axis=-1).sum() == points[..., 0].size - 1


def test_points_that_no_view_agrees_on_are_left_out() -> None:
    rng = np.random.default_rng(5)
    points = face(rng)
    views = [project_points(c, points) for c in CAMERAS]
    views[1][2, 1, 1] += 30
    found = drop_outliers(reconstruct(CAMERAS, views), 5)
    assert np.isnan(found.points[2, 1]).all()
    assert np.isfinite(found.points).all(axis=-1).sum() == points[..., 0].size - 1


def test_points_that_determine_no_camera() -> None:
    seen = project_points(CAMERAS[0], CUBE)
    with pytest.raises(CorpusError, match="needs 6 known points, and only 5 are seen"):
        calibrate_camera(CUBE[:5], seen[:5])
    flat = CUBE * [1, 1, 0]
    with pytest.raises(CorpusError, match="lie in one plane"):
        calibrate_camera(flat, project_points(CAMERAS[0], flat))


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    """Two views of a face, and a calibration table with a point that the second view did not see."""
    points = face(np.random.default_rng(6))
    seen = [project_points(c, CUBE) for c in CAMERAS]
    with (tmp_path / "cube.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(("x", "y", "z", "u1", "v1", "u2", "v2"))
        rows.writerows([*CUBE[n], *seen[0][n], *(seen[1][n] if n else ("", ""))] for n in range(len(CUBE)))
    for name, one in zip(("front", "side"), CAMERAS, strict=True):
        np.save(tmp_path / f"{name}.npy", project_points(one, points))
    np.save(tmp_path / "wanted.npy", points)
    return tmp_path


def test_the_command(shot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    views = [str(shot / "front.npy"), str(shot / "side.npy")]
    output = shot / "face.npy"
    assert (
        run(["corpus", "reconstruct", *views, "--calibration", str(shot / "cube.csv"), "-o", str(output)])
        == 0
    )
    np.testing.assert_allclose(np.load(output), np.load(shot / "wanted.npy"), atol=1e-5)
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "calibration: front.npy 0.00, side.npy 0.00 px"
    assert told[1].endswith("480 points, 0.00 px from the views; 0 unseen, 0 beyond 5 px")
    np.save(shot / "short.npy", np.zeros((39, 12, 2)))
    assert (
        run(
            [
                "corpus",
                "reconstruct",
                views[0],
                str(shot / "short.npy"),
                "--calibration",
                str(shot / "cube.csv"),
                "-o",
                str(shot / "no.npy"),
            ]
        )
        == 2
    )
    assert "short.npy: has frames and points (39, 12), but" in capsys.readouterr().err
    assert not (shot / "no.npy").exists()


def test_calibrations_that_determine_no_cameras(shot: Path) -> None:
    lines = (shot / "cube.csv").read_text().splitlines()
    few = [*lines[:7], *(",".join(line.split(",")[:5]) for line in lines[7:])]
    (shot / "few.csv").write_text("\n".join(few))
    with pytest.raises(CorpusError, match=r"few\.csv, view 2: a camera needs 6 known points, and only 5"):
        calibrate_cameras(shot / "few.csv", 2)
    cells = [line.split(",")[:5] for line in lines[1:]]
    (shot / "twice.csv").write_text("\n".join([lines[0], *(",".join([*row, *row[3:]]) for row in cells)]))
    with pytest.raises(CorpusError, match=r"twice\.csv: all views are from one place"):
        calibrate_cameras(shot / "twice.csv", 2)


def test_files_that_are_no_views(shot: Path) -> None:
    np.save(shot / "flat.npy", np.zeros((4, 2)))
    (shot / "text.npy").write_text("x")
    with pytest.raises(CorpusError, match=r"flat\.npy: must be an array of pixels"):
        read_view(shot / "flat.npy")
    with pytest.raises(CorpusError, match=r"text\.npy: cannot be read as an array"):
        read_view(shot / "text.npy")
    with pytest.raises(CorpusError, match=r"cube\.csv: lacks the column 'u3'"):
        read_calibration(shot / "cube.csv", 3)
    (shot / "bad.csv").write_text("x,y,z,u1,v1,u2,v2\n1,2,3,4,five,6,7\n")
    with pytest.raises(CorpusError, match=r"bad\.csv, line 2: 'five' is not a number"):
        read_calibration(shot / "bad.csv", 2)
    with pytest.raises(CorpusError, match=r"none\.csv: cannot be read as a table"):
        read_calibration(shot / "none.csv", 2)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_calibration_that_is_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "k.csv")
    with pytest.raises(CorpusError, match=r"k\.csv: cannot be read as a table \(it is a pipe or a device"):
        read_calibration(tmp_path / "k.csv", 2)
