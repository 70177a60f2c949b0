"""Domains of glsl/trace."""

import numpy as np

from glcloth.twins.visibility import packed_sums

from . import above_horizon, between, choice, core, directions, directions_and_axes, vectors, woven


def low_corner(rng, count):
    """Low corners of boxes inside [-2, 2]^3; a fifth flat against a face of the cell."""
    v = -rng.uniform(0.1, 1.9, (count, 3))
    return np.where(rng.random((count, 3)) < 0.2, -2.0, v)


def plane(rng, count):
    """Axis-aligned planes, often through the middle."""
    return np.c_[np.eye(3)[rng.integers(0, 3, count)], rng.uniform(-1, 1, count)]


def near(rng, count):
    """Corners of triangles about a metre in front of a ray."""
    v = rng.normal(scale=0.5, size=(count, 3))
    v[:, 2] += 2.0
    return v


def straight_parts(rng, count):
    """What passes through yarns and holes, some of it 0."""
    return rng.random((count, 4)) * (rng.random((count, 4)) < 0.8)


def sum_words(rng, count):
    """Words of `packed_sums`."""
    there = 10.0 ** rng.uniform(-6, 3, (count, 4))
    return packed_sums(rng.random((count, 4)) * there, there)


def seen_quads(name):
    """Corners of flat convex quadrilaterals round a point, some across its horizon, none through the point; a fifth are
    triangles. With a unit normal."""

    def make(rng, count):
        middle = rng.normal(size=(count, 3))
        middle *= (rng.uniform(0.5, 3.0, count) / np.linalg.norm(middle, axis=1))[:, None]
        u = rng.normal(size=(count, 3))
        v = np.cross(u, rng.normal(size=(count, 3)))
        u, v = (0.4 * w / np.linalg.norm(w, axis=1, keepdims=True) * rng.uniform(0.05, 1, (count, 1)) for w in (u, v))
        corners = [middle - u - v, middle + u - v, middle + u + v, middle - u + v]
        corners[3] = np.where(rng.random((count, 1)) < 0.2, corners[2], corners[3])
        n = rng.normal(size=(count, 3))
        values = dict(zip("abcd", corners, strict=True)) | {"n": n / np.linalg.norm(n, axis=1, keepdims=True)}
        return {k: values[k] for k in name}

    return make


def angles(rng, count):
    """Two vectors and the length of their cross product, as float32 have it."""
    both = {k: v.astype(np.float32).astype(float) for k, v in seen_quads("ab")(rng, count).items()}
    return both | {"l": np.linalg.norm(np.cross(both["a"], both["b"]), axis=1)}


def numbered(rng, count):
    """A number below another one."""
    of = rng.choice([1, 1000, 2**20], count)
    return {"i": (rng.random(count) * of).astype(int), "count": of}


def ways(rng, count):
    """From points of a surface to others, some nearly on it, with a normal."""
    n = directions(rng, count)
    flat = rng.random((count, 1)) < 0.5
    d = rng.normal(scale=0.3, size=(count, 3))
    d -= np.where(flat, 1.0, rng.random((count, 1))) * (d * n).sum(1, keepdims=True) * n
    return {"way": d, "n": n}


def edges_about(rng, count):
    """Edges near a point, in a plane with a normal; a tenth go through it, as far as float32 can tell."""
    n = directions(rng, count)
    u = np.cross(n, directions(rng, count))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(n, u)
    p = rng.normal(size=(count, 3))
    h = np.where(rng.random(count) < 0.1, 0.02, rng.uniform(-1.5, 1.5, count))
    x = rng.uniform(-2, 2, (count, 2))
    ends = [p + h[:, None] * v + x[:, k, None] * u + (k * 0.1) * u for k in (0, 1)]
    return {
        "p": p,
        "a": ends[0],
        "b": ends[1] + 0.1 * np.sign(x[:, 1:] - x[:, :1]) * u,
        "n": n,
        "r": rng.uniform(0.3, 1, count),
    }


DOMAINS = {"axis": choice(0, 1, 2), "a": vectors(2.0), "b": vectors(2.0), "c": vectors(2.0)}
DOMAINS["lean"] = between(-0.3, 1.0, 0.0, 0.1, 0.25, 0.5)
DOMAINS |= {
    name: woven.DOMAINS[name]
    for name in ("roughness", "roughness_p", "eta_1", "eta_2", "rho", "k_a", "k_t", "diffuse", "tau")
}
SPECIAL = {
    ("shifted_hammersley", "shift"): lambda rng, count: rng.random((count, 2)),
    ("disc_kernel", "d2"): between(0.0, 2.0),
    ("disc_kernel", "r2"): between(0.1, 2.0),
    ("band_shares", "z"): between(-1.0, 1.0, 0.0, 0.4),
    ("from_bands", "low"): lambda rng, count: rng.random((count, 4)),
    ("from_bands", "middle"): lambda rng, count: rng.random((count, 4)),
    ("from_bands", "top"): between(0.0, 1.0),
    ("response_to", "cos_theta"): between(-1.0, 1.0, 0.0, 0.05, -0.05),
    ("response_to", "flat_share"): between(0.0, 0.9),
    ("ground_place", "p"): lambda rng, count: rng.normal(size=(count, 2)) * np.exp(rng.uniform(-7, 7, (count, 1))),
    ("ground_place", "scale"): between(0.1, 5.0),
    ("ground_place", "rings"): choice(84.0, 20.0),
    ("ground_place", "sectors"): choice(112.0, 16.0),
    ("later_bounces", "albedo"): lambda rng, count: rng.random((count, 3)),
    ("later_bounces", "hidden"): between(0.0, 1.0),
    # More is seen than there is only where there is nothing.
    ("packed_sums", "seen"): lambda rng, count: 1e-3 * rng.random((count, 4)) * (rng.random((count, 4)) < 0.8),
    ("packed_sums", "all"): lambda rng, count: 10.0 ** rng.uniform(-3, 3, (count, 4)),
    ("seen_of_sums", "sums"): sum_words,
    ("all_of_sums", "sums"): sum_words,
    ("safe_inverse", "d"): directions_and_axes,
    ("slab", "o"): vectors(3.0),
    ("slab", "inv_d"): lambda rng, count: 1 / np.where(np.abs(d := directions(rng, count)) < 1e-3, 1e-3, d),
    ("slab", "low"): lambda rng, count: -rng.random((count, 3)) - 0.1,
    ("slab", "high"): lambda rng, count: rng.random((count, 3)) + 0.1,
    ("longest_axis", "d"): directions_and_axes,
    ("axis_last", "v"): vectors(1.0),
    ("shear_of", "d"): lambda rng, count: np.sort(np.abs(directions(rng, count)), axis=1),
    ("spread_bits", "x"): lambda rng, count: rng.integers(0, 1024, count),
    ("morton_code", "p"): lambda rng, count: rng.uniform(-0.01, 1.01, (count, 3)),
    **{("common_prefix", f"code_{k}"): lambda rng, count: rng.integers(0, 8, count) << 27 for k in (1, 2)},
    **{("common_prefix", f"place_{k}"): lambda rng, count: rng.integers(0, 2**20, count) for k in (1, 2)},
    ("cell_direction", "cell"): lambda rng, count: rng.integers(0, 64 * 32, count),
    ("cell_direction", "width"): choice(64),
    ("cell_direction", "height"): choice(32),
    ("cell_direction", "place"): lambda rng, count: rng.random((count, 2)),
    ("hash3", "v"): lambda rng, count: rng.integers(0, 2**32, (count, 3)),
    **{
        (name, "index"): lambda rng, count: rng.integers(0, 2**32, count) for name in ("owen_scrambled", "second_index")
    },
    ("owen_scrambled", "seed"): lambda rng, count: rng.integers(0, 2**32, count),
    ("stratified", "index"): lambda rng, count: rng.integers(0, 2**20, count),
    ("stratified", "key"): lambda rng, count: rng.integers(0, 2**32, (count, 3)),
    ("unit_square", "hash"): lambda rng, count: rng.integers(0, 2**32, (count, 2)),
    ("cosine_direction", "u"): lambda rng, count: rng.random((count, 2)),
    ("facet_direction", "u"): lambda rng, count: 0.999 * rng.random((count, 2)),
    ("facet_direction", "roughness"): between(0.05, 1.0),
    **{(name, "parts"): straight_parts for name in ("hole_chance", "drawn_weight")},
    ("drawn_weight", "hole"): choice(0, 1),
    **{(name, "omega_o"): woven.off_horizon(above_horizon) for name in ("straight_parts", "yarn_direction")},
    ("yarn_direction", "u"): lambda rng, count: 0.999 * rng.random((count, 2)),
    ("yarn_direction", "part"): lambda rng, count: rng.random(count),
    ("edge_function", "p"): lambda rng, count: rng.normal(size=(count, 2)),
    ("edge_function", "q"): lambda rng, count: rng.normal(size=(count, 2)),
    ("hit_triangle", "a"): near,
    ("hit_triangle", "b"): near,
    ("hit_triangle", "c"): near,
    ("hit_triangle", "shear"): lambda rng, count: np.c_[rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(0.6, 1, count)],
    ("sheared", "p"): near,
    ("sheared", "shear"): lambda rng, count: np.c_[rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(0.6, 1, count)],
    # Values of one sign, and of both: hits and misses.
    ("hit_edges", "edges"): lambda rng, count: rng.uniform(-0.2, 1, (count, 3)) * rng.choice([-1.0, 1.0], (count, 1)),
    ("hit_edges", "depths"): lambda rng, count: rng.uniform(0.5, 3, (count, 3)),
    ("hit_edges", "shear"): lambda rng, count: np.c_[rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(0.6, 1, count)],
    **{(name, n): directions for name in ("curved_middle", "middle_normal") for n in ("n_a", "n_b")},
    **{(name, "weights"): core.weights for name in ("weights_of_whole", "part_at", "weights_in_part")},
    **{
        (name, "part"): lambda rng, count: rng.integers(0, 4, count) for name in ("weights_of_whole", "weights_in_part")
    },
    ("disc_point", "n"): lambda rng, count: rng.integers(0, 64, count),
    ("disc_point", "count"): choice(64),
    ("disc_point", "turn"): between(0.0, 1.0),
    ("disc_direction", "middle"): directions_and_axes,
    ("disc_direction", "tan_radius"): between(0.0, 0.2),
    ("disc_direction", "at"): lambda rng, count: rng.uniform(-1.0, 1.0, (count, 2)),
    ("octahedral", "n"): directions_and_axes,
    ("from_octahedral", "p"): lambda rng, count: rng.uniform(-1, 1, (count, 2)),
    ("plane_fraction", "k"): lambda rng, count: rng.integers(0, 7, count),
    ("plane_fraction", "count"): choice(7, 15),
    ("planes_at", "low"): low_corner,
    ("planes_at", "high"): lambda rng, count: rng.uniform(0, 2, (count, 3)),
    ("planes_at", "fraction"): between(0.0, 1.0),
    ("plane_costs", "low"): low_corner,
    ("plane_costs", "high"): lambda rng, count: rng.uniform(0, 2, (count, 3)),
    ("plane_costs", "fraction"): between(0.0, 1.0),
    **{
        ("plane_costs", side): lambda rng, count: rng.integers(0, 2000, (count, 3)).astype(float)
        for side in ("left", "right")
    },
    ("least_axis", "v"): lambda rng, count: rng.integers(0, 4, (count, 3)).astype(float),
    ("side_counts", "low"): low_corner,
    ("side_counts", "high"): lambda rng, count: rng.uniform(-0.1, 2, (count, 3)),
    ("side_counts", "planes"): lambda rng, count: rng.uniform(-0.5, 1, (count, 3)),
    ("gap_plane", "cell_low"): lambda rng, count: np.full((count, 3), -2.0),
    ("gap_plane", "cell_high"): lambda rng, count: np.full((count, 3), 2.0),
    ("gap_plane", "low"): low_corner,
    ("gap_plane", "high"): lambda rng, count: rng.uniform(0, 2, (count, 3)),
    ("gap_plane", "share"): between(0.1, 0.5),
    ("sides", "low"): low_corner,
    ("sides", "high"): lambda rng, count: rng.uniform(-0.1, 2, (count, 3)),
    ("sides", "plane"): plane,
    ("behind_layer", "t"): between(0.0, 30.0),
    ("clipped_box", "plane"): between(-1.0, 1.0, 0.0),
    ("clipped_box", "n"): lambda rng, count: np.eye(3)[rng.integers(0, 3, count)],
    ("clipped_box", "side"): choice(-1.0, 1.0),
}


def across_horizon(rng, count):
    """Points above and below the horizon of a unit normal."""
    values = seen_quads("abn")(rng, count)
    for k, sign in (("a", 1), ("b", -1)):
        z = (values[k] * values["n"]).sum(1, keepdims=True)
        values[k] = values[k] + (sign * (0.1 + np.abs(z)) - z) * values["n"]
    return values


def low_discs(rng, count):
    """Middles of discs about the horizon z = 0, a third of them whole, one in twenty straight above, and their sines."""
    sin_radius = rng.uniform(0.0, 0.17, count)
    z = sin_radius * rng.uniform(-1.5, 1.5, count)
    turn = rng.uniform(0.0, 2.0 * np.pi, count)
    middle = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], -1)
    middle[::20] = 0.0, 0.0, 1.0
    return {"middle": middle, "sin_radius": sin_radius}


JOINT = {
    "disc_above": low_discs,
    "angle_of": angles,
    "edge_factor": seen_quads("abn"),
    "horizon_point": across_horizon,
    "clipped_edge_factor": seen_quads("abn"),
    "quad_factor": seen_quads("abcdn"),
    "shifted_hammersley": numbered,
    "disc_distance": ways,
    "cut_share": edges_about,
}
TOLERANCE = {
    # A sliver of a disc: its height over its share, both small differences.
    "disc_above": (1e-4, 1e-4),
    # A part of 48 turns.
    "disc_point": (1e-4, 5e-5),
    # Ends that float32 moves along an edge near the point.
    "cut_share": (1e-4, 2e-5),
    # The cross product of nearly parallel corners cancels; factors are shares of 1.
    "edge_factor": (1e-4, 3e-6),
    "clipped_edge_factor": (1e-4, 1e-5),
    "quad_factor": (1e-4, 3e-6),
    # As T_sheet of glsl/woven.
    "straight_parts": (3e-5, 1e-5),
    # The root of a difference at the critical angle.
    "yarn_direction": (3e-4, 3e-4),
    # Words are compared as numbers: the last bit of a share.
    "packed_sums": (0.0, 1.0),  # units in the last place of each half
    # 1 / d is up to 1e3, and low - o cancels to 1e-7.
    "slab": (3e-5, 3e-4),
    # t, v and w are divided by the determinant, which is small for triangles seen edge-on.
    "hit_triangle": (2e-3, 2e-3),
    # mix(a, b, f) where the two distances nearly cancel.
    "clipped_box": (3e-5, 1e-5),
}

PACKED = ("packed_sums",)  # words of two 16-bit floats
