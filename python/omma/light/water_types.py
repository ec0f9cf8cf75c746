"""What water of Jerlov's types absorbs and scatters by wavelength, and how much of it backwards."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats

# Absorption, m⁻¹, by Jerlov's water type. IB, II, III, 1C, 3C and 5C: measured from 412 to 715 nm,
# below by the authors' model (Williamson and Hollins, Appl. Opt. 61:9951, 2022, table 7, every
# 10 nm). I, IA, 7C and 9C: of models that fit Jerlov's attenuation of daylight (Solonenko and
# Mobley, Appl. Opt. 54:5392, 2015, tables 4 to 8). Both were read in the tables of the package
# jerlov 0.22.0, which compares them with the papers. The measured ones are Crown copyright, 2022,
# Dstl, under the Open Government Licence 3.0.
_MEASURED_NM = np.arange(300.0, 701.0, 10.0)
_MODELLED_NM = np.array([300.0, 310, *range(350, 701, 25)])
_ABSORBED = {
    "I": "0.163 0.134 0.048 0.03 0.022 0.017 0.018 0.019 0.026 0.046 0.062 0.082 0.228 0.295 0.334"
    " 0.434 0.582",
    "IA": "0.221 0.181 0.0673 0.0413 0.0295 0.0225 0.0221 0.0216 0.0282 0.0468 0.0622 0.0821 0.228"
    " 0.295 0.334 0.435 0.582",
    "IB": "0.149 0.129 0.112 0.0975 0.0841 0.0714 0.0617 0.0556 0.0511 0.0476 0.0448 0.0436 0.043"
    " 0.0426 0.0423 0.0407 0.039 0.0376 0.037 0.0373 0.0398 0.0459 0.0515 0.0519 0.0572 0.0655"
    " 0.073 0.0811 0.1 0.14 0.227 0.273 0.285 0.299 0.314 0.335 0.383 0.417 0.436 0.478 0.573",
    "II": "0.219 0.194 0.173 0.153 0.134 0.115 0.101 0.0919 0.0852 0.0794 0.0745 0.0717 0.0697"
    " 0.0678 0.066 0.0623 0.0588 0.0557 0.0534 0.0522 0.0529 0.0572 0.0615 0.0607 0.065 0.0724"
    " 0.0792 0.0867 0.105 0.145 0.231 0.277 0.288 0.303 0.318 0.338 0.386 0.422 0.44 0.481 0.575",
    "III": "0.349 0.323 0.293 0.26 0.226 0.186 0.16 0.148 0.142 0.135 0.13 0.128 0.127 0.125 0.121"
    " 0.112 0.104 0.0978 0.0911 0.0867 0.0835 0.0835 0.0841 0.0806 0.0825 0.0878 0.0922 0.0983"
    " 0.116 0.156 0.241 0.287 0.3 0.314 0.33 0.351 0.402 0.445 0.462 0.492 0.581",
    "1C": "0.566 0.518 0.465 0.408 0.351 0.287 0.244 0.222 0.209 0.197 0.186 0.181 0.176 0.17 0.163"
    " 0.148 0.137 0.127 0.116 0.11 0.104 0.101 0.1 0.0948 0.0952 0.0988 0.101 0.106 0.124 0.163"
    " 0.248 0.294 0.307 0.322 0.338 0.359 0.413 0.461 0.477 0.501 0.585",
    "3C": "0.572 0.549 0.505 0.45 0.392 0.319 0.273 0.257 0.251 0.243 0.236 0.235 0.233 0.228 0.22"
    " 0.2 0.186 0.174 0.16 0.152 0.144 0.139 0.136 0.128 0.127 0.128 0.127 0.13 0.146 0.185 0.268"
    " 0.314 0.328 0.343 0.358 0.379 0.437 0.493 0.508 0.521 0.598",
    "5C": "1.91 1.7 1.48 1.26 1.06 0.851 0.705 0.621 0.565 0.513 0.469 0.441 0.414 0.388 0.359"
    " 0.313 0.283 0.258 0.23 0.213 0.199 0.188 0.18 0.169 0.163 0.159 0.152 0.151 0.166 0.203 0.285"
    " 0.333 0.349 0.365 0.382 0.402 0.47 0.545 0.558 0.552 0.614",
    "7C": "5.11 4.4 2.17 1.45 1.03 0.753 0.542 0.388 0.29 0.233 0.195 0.175 0.301 0.367 0.403 0.559"
    " 0.621",
    "9C": "5.466 4.9 2.856 2.103 1.613 1.242 0.943 0.709 0.543 0.43 0.348 0.291 0.39 0.436 0.456"
    " 0.604 0.651",
}
# Scattering, m⁻¹, at 400 nm, of small particles, which falls as wavelength^-1.7, and of large ones,
# ^-0.3 (Haltrin, Appl. Opt. 38:6826, 1999): fitted here to the same tables, within 0.5 %.
_SCATTERED = {
    "I": (0.00032, 0.00005), "IA": (0.00302, 0.00035), "IB": (0.01342, 0.12436),
    "II": (0.0292, 0.174), "III": (0.0129, 0.3057), "1C": (0.0, 0.4682), "3C": (0.0, 0.7073),
    "5C": (0.0004, 1.3115), "7C": (3.9955, 0.0226), "9C": (5.3588, 0.0),
}  # fmt: skip

# By type: values, m⁻¹, and their wavelengths, nm; linear between.
ABSORPTION = {
    kind: (np.array(text.split(), np.float64), nm)
    for kind, text in _ABSORBED.items()
    for nm in (_MEASURED_NM, _MODELLED_NM)
    if len(nm) == len(text.split())
}
# What particles turn back of the light that they scatter: 0.0183 (Petzold's mean of measurements,
# as water.py has it); molecules half.
BACK = 0.0183
# What they turn by 45 degrees or more (water.py; tests/python/test_water_volumes.py has it anew).
TURNED = 0.109


def scattering_by_particles(kind: str, nm: Floats) -> Floats:
    """Of a type, m⁻¹."""
    small, large = _SCATTERED[kind]
    return np.asarray(small * (400 / nm) ** 1.7 + large * (400 / nm) ** 0.3)


def scattering_by_molecules(nm: Floats) -> Floats:
    """Scattering of pure sea water, m⁻¹ (Haltrin 1999, eq. 5, after Morel 1974)."""
    return np.asarray(0.005826 * (400 / nm) ** 4.322)
