"""Files of metrics on grids, given to commands for triangles."""

import numpy as np
import pytest

from isoembed.cli import main


@pytest.mark.parametrize("command", ["embed", "inspect", "view"])
def test_where_metrics_on_grids_belong(command, tmp_path, capsys):
    theta, phi = (np.arange(20) + 0.5) * np.pi / 20, np.arange(20) * np.pi / 10
    one = np.ones((20, 20))
    path = tmp_path / "g.npz"
    np.savez(path, theta=theta, phi=phi, q_tt=one, q_tp=0 * one, q_pp=np.sin(theta)[:, None] ** 2 * one)
    assert main([command, str(path)]) == 2
    said = capsys.readouterr().err
    assert f"'isoembed energy {path}'" in said
    assert f"'isoembed triangulate {path} --vertices 1000 -o metric.npz'" in said
    assert main(["energy", str(path), "--quiet"]) == 0
    assert main(["triangulate", str(path), "-o", str(tmp_path / "metric.npz"), "--vertices", "100"]) == 0
