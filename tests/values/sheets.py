"""A small bent sheet as arrays and as text, and what every file that holds it must give."""

import numpy as np

from glcloth.geometry.shapes import grid_triangles

N = 5
_u, _v = (c.ravel() for c in np.meshgrid(np.linspace(0, 1, N), np.linspace(0, 1, N)))
P = np.column_stack([_u - 0.5, _v - 0.5, 0.1 * np.sin(3 * _u) * np.cos(2 * _v)]).round(6)
UV = np.column_stack([_u, _v])
T = grid_triangles(N, N)[:, ::-1].astype(int)


def area(mesh):
    p = mesh.positions[mesh.triangles].astype(float)
    return float(np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2)


def facing(mesh):
    """Share of the triangles' corners whose normal is on the winding's side."""
    p = mesh.positions[mesh.triangles].astype(float)
    S = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    return float((np.einsum("tc,tkc->tk", S, mesh.normals[mesh.triangles]) > 0).mean())


AREA = float(np.linalg.norm(np.cross(P[T][:, 1] - P[T][:, 0], P[T][:, 2] - P[T][:, 0]), axis=1).sum() / 2)


def assert_is_the_sheet(mesh, uv=True, places=P, tolerance=2e-5):
    """Area, bounds, one side, and at every vertex the normal and the yarn of the sheet, either side up."""
    assert abs(area(mesh) - AREA) < 1e-4 * AREA and len(mesh.triangles) == len(T)
    assert np.allclose(mesh.bounds, [places.min(0), places.max(0)], atol=tolerance)
    assert facing(mesh) == 1.0
    reference = REFERENCE()
    nearest = np.linalg.norm(mesh.positions[:, None] - places[None], axis=2).argmin(1)
    used = np.unique(mesh.triangles)
    sides = np.sum(mesh.normals * reference.normals[nearest], axis=1)[used]
    assert (sides > 0.999).all() or (sides < -0.999).all()
    if uv:
        assert mesh.uv is not None and np.allclose(mesh.uv[used], UV[nearest][used], atol=1e-4)
        assert (np.sum(mesh.tangents[:, :3] * reference.tangents[nearest, :3], axis=1)[used] > 0.9999).all()
        assert len(set(mesh.tangents[used, 3])) == 1, "one handedness"


def REFERENCE():
    from glcloth.geometry.mesh import build_mesh

    return build_mesh("sheet", P, T, UV)


def obj(places=P, faces=None, corner="{0}/{0}", uv="vt {:.6f} {:.6f}", head="", normals=None):
    """OBJ text of the sheet."""
    rows = ["v {:.6f} {:.6f} {:.6f}".format(*row) for row in places.tolist()]
    rows += [uv.format(*row) for row in UV.tolist()] if uv else []
    rows += [] if normals is None else ["vn {:.6f} {:.6f} {:.6f}".format(*row) for row in normals.tolist()]
    faces = T if faces is None else faces
    rows += ["f " + " ".join(corner.format(i + 1) for i in face) for face in np.asarray(faces).tolist()]
    return head + "\n".join(rows) + "\n"
