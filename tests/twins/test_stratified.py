"""Samples that fill the square and the interval: every elementary interval holds one, and every key is another sequence."""

import numpy as np

from glcloth.twins.random import stratified

COUNT = 64


def samples(key, first=0):
    index = first + np.arange(COUNT)
    return stratified(index, np.broadcast_to(np.uint32(key), (COUNT, 3)))


def test_every_elementary_interval_holds_one():
    for key in ([1, 2, 3], [2**31, 5, 77]):
        for first in (0, 5 * COUNT):
            x, y, z = samples(key, first).T
            assert set((COUNT * z).astype(int)) == set(range(COUNT))
            for columns in 2 ** np.arange(7):
                cells = (columns * x).astype(int) * (COUNT // columns) + (COUNT // columns * y).astype(int)
                assert set(cells) == set(range(COUNT)), columns


def test_means_are_far_nearer_than_those_of_independent_samples_and_have_no_bias():
    values = [
        (np.cos(3 * p[:, 0]) * p[:, 1] ** 2 * np.exp(p[:, 2])).mean()
        for p in (samples([k, 7, 9 * k]) for k in range(300))
    ]
    exact = np.sin(3) / 3 / 3 * (np.e - 1)
    independent = np.sqrt((0.5 + np.sin(6) / 12) / 5 * (np.e**2 - 1) / 2 - exact**2) / np.sqrt(COUNT)
    assert np.std(values) < 0.35 * independent
    assert abs(np.mean(values) - exact) < 4 * np.std(values) / np.sqrt(300)


def test_keys_are_independent():
    many = np.stack([samples([k, 0, 3])[:, :2].ravel() for k in range(200)])
    correlation = np.corrcoef(many)[np.triu_indices(200, 1)]
    assert abs(correlation.mean()) < 0.005
