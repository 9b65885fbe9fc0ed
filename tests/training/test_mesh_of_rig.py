"""The motion of the shipped head's mesh is learned and written again, from the clips to scores and a film."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from phonanim.media.glb import read_glb
from phonanim.rig.head import load_head

pytest.importorskip("torch")
pytest.importorskip("trimesh")
pytest.importorskip("matplotlib")


@pytest.mark.slow
def test_the_mesh_of_a_head_is_learned(shared_data: Path, tmp_path: Path) -> None:
    from benchmarks.mesh_of_rig import main

    recordings = shared_data / "grid_s1"
    done = CliRunner().invoke(main, [str(recordings), str(tmp_path), "--clips", "4", "--epochs", "1"])
    assert done.exit_code == 0, done.output
    head = load_head()
    captured = sorted((tmp_path / "scored" / "captured").glob("second_*.npy"))
    assert len(captured) == 1
    found = np.load(tmp_path / "scored" / "phones" / captured[0].name)
    wanted = np.load(captured[0])
    assert found.shape == wanted.shape == (90, len(head.vertices), 3)
    still = np.abs(wanted - 1.1 * 1000 * head.vertices)
    assert (
        np.abs(found - wanted).mean() < 0.8 * still.mean()
    )  # it follows the line, on its own speaker's face
    glb = read_glb(tmp_path / "sound.take2.glb")
    rest = glb.accessor(glb.tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
    np.testing.assert_allclose(rest, 1.1 * head.vertices, atol=1e-5)  # metres
    assert (tmp_path / "heat.png").stat().st_size > 10_000
    assert "sd ratio" in (tmp_path / "compared" / "benchmark.md").read_text("utf-8")
