"""What Mitsuba 3 makes of the plugin, evaluated in a process of its own: a renderer that fails must not take us along."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np


class MissingMitsubaError(RuntimeError):
    """Mitsuba cannot be asked here; one line says why."""


def by_mitsuba(numbers: dict, omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
    """The plugin's response f cos(theta_i) [..., 3]. Raises MissingMitsubaError."""
    omega_i, omega_o = np.broadcast_arrays(omega_i, omega_o)
    with tempfile.TemporaryDirectory() as folder:
        given, got = Path(folder) / "given.npz", Path(folder) / "got.npy"
        np.savez(given, i=omega_i.reshape(-1, 3), o=omega_o.reshape(-1, 3), numbers=json.dumps(numbers))
        command = [sys.executable, "-m", f"{__package__}.mitsuba_response", given, got]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode or not got.is_file():
            lines = [line for line in done.stderr.splitlines() if "Error" in line or "ERROR" in line] or ["it stops"]
            why = "Mitsuba is not installed" if "No module named 'mitsuba'" in done.stderr else lines[-1][:160]
            raise MissingMitsubaError(
                f"not measured here ({why}); pip install 'glcloth[mitsuba]', and LLVM 17 or newer"
            )
        return np.load(got).reshape(omega_i.shape)


def _main(given: str, got: str) -> None:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    from .mitsuba_bsdf import register

    register()
    data = np.load(given)
    bsdf = mi.load_dict({"type": "microcylinder", "numbers": str(data["numbers"])})
    si = mi.SurfaceInteraction3f()
    si.wi, si.sh_frame = mi.Vector3f(data["o"].T), mi.Frame3f(mi.Vector3f(0, 0, 1))
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(data["i"].T))
    np.save(got, np.array(value).T)


if __name__ == "__main__":
    _main(*sys.argv[1:])
