"""How strongly the shading of each fabric follows its environment, by degree of spherical harmonics.

Cloth is a linear operator on its environment, L = <K, L_env>. Over random frames and views the mean squared error that a
residual r leaves is exactly sum_l Q_l sum_m |r_lm|^2 with Q_l = mean of sum_m |K_lm|^2 / (2 l + 1); b_l = sqrt(Q_l / Q_0).
Linen sees degrees up to about 6, silk 12, satin 24.   [own]
"""

import numpy as np

# Measured with 200 random frames per fabric (python tests/measure/bands.py).
# l, linen, silk_crepe_de_chine, silk_shot, satin_charmeuse_front, satin_charmeuse_back, velvet
_MEASURED = np.array(
    [
        [0, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000],
        [1, 0.6289, 0.5806, 0.6572, 0.6631, 0.6332, 0.6452],
        [2, 0.2239, 0.2352, 0.3207, 0.3356, 0.2421, 0.4166],
        [3, 0.1177, 0.1728, 0.2400, 0.2266, 0.1275, 0.3281],
        [4, 0.0787, 0.1186, 0.1833, 0.1644, 0.1018, 0.2350],
        [5, 0.0435, 0.1497, 0.1265, 0.1773, 0.1383, 0.1959],
        [6, 0.0237, 0.1087, 0.1243, 0.1805, 0.1488, 0.1637],
        [7, 0.0198, 0.0735, 0.1364, 0.1493, 0.1216, 0.1446],
        [8, 0.0130, 0.0487, 0.1161, 0.1131, 0.0937, 0.1166],
        [9, 0.0120, 0.0406, 0.0835, 0.0995, 0.0849, 0.0994],
        [10, 0.0077, 0.0363, 0.0597, 0.1304, 0.0724, 0.0759],
        [11, 0.0082, 0.0336, 0.0473, 0.1566, 0.0586, 0.0642],
        [12, 0.0055, 0.0245, 0.0381, 0.1451, 0.0489, 0.0473],
        [13, 0.0061, 0.0227, 0.0329, 0.1181, 0.0435, 0.0421],
        [14, 0.0041, 0.0166, 0.0304, 0.0982, 0.0516, 0.0303],
        [15, 0.0049, 0.0177, 0.0285, 0.0799, 0.0602, 0.0297],
        [16, 0.0032, 0.0138, 0.0251, 0.0695, 0.0579, 0.0213],
        [17, 0.0041, 0.0143, 0.0219, 0.0694, 0.0506, 0.0230],
        [18, 0.0026, 0.0108, 0.0192, 0.0643, 0.0431, 0.0164],
        [19, 0.0035, 0.0119, 0.0177, 0.0551, 0.0376, 0.0186],
        [20, 0.0022, 0.0093, 0.0161, 0.0479, 0.0369, 0.0133],
        [21, 0.0031, 0.0103, 0.0151, 0.0452, 0.0369, 0.0158],
        [22, 0.0019, 0.0081, 0.0139, 0.0455, 0.0334, 0.0113],
        [23, 0.0026, 0.0091, 0.0133, 0.0426, 0.0289, 0.0136],
        [24, 0.0017, 0.0071, 0.0123, 0.0368, 0.0252, 0.0097],
        [25, 0.0023, 0.0082, 0.0117, 0.0326, 0.0221, 0.0120],
        [26, 0.0015, 0.0064, 0.0109, 0.0289, 0.0199, 0.0086],
        [27, 0.0021, 0.0074, 0.0105, 0.0259, 0.0182, 0.0106],
        [28, 0.0013, 0.0058, 0.0099, 0.0247, 0.0160, 0.0076],
        [29, 0.0019, 0.0067, 0.0096, 0.0234, 0.0149, 0.0095],
        [30, 0.0012, 0.0053, 0.0090, 0.0209, 0.0146, 0.0068],
        [31, 0.0017, 0.0061, 0.0088, 0.0185, 0.0140, 0.0086],
        [32, 0.0011, 0.0049, 0.0083, 0.0165, 0.0130, 0.0061],
    ]
)
_FABRICS = ("linen", "silk_crepe_de_chine", "silk_shot", "satin_charmeuse_front", "satin_charmeuse_back", "velvet")
_SHORT = {"silk": "silk_crepe_de_chine", "satin": "satin_charmeuse_front"}
FABRICS = (*_FABRICS, "generic")


def band_weights(fabric: str = "generic") -> np.ndarray:
    """b_l [33] of a built-in fabric ("silk" and "satin" for short), or of "generic", and of any other name.

    The generic curve is the root mean square of linen, silk and satin front. A fit for it serves every fabric about as
    well as a fit for its own curve.
    """
    name = _SHORT.get(fabric, fabric)
    if name in _FABRICS:
        return _MEASURED[:, 1 + _FABRICS.index(name)].copy()
    return np.sqrt(np.mean([np.square(band_weights(typical)) for typical in ("linen", "silk", "satin")], axis=0))
