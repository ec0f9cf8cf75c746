"""The light a nocturnal bee gains: Land's sensitivity of *Megalopta* against a honeybee's.

S = (π/4)² D² Δρ² kl/(2.3 + kl): facet D, acceptance angle Δρ, absorption k, rhabdom length l (Land
1981). Greiner et al. 2004 (Cell Tissue Res 316:377) found 27 times the honeybee's. *Megalopta*'s
lengths are recalled, not verified: omma.species.facts("megalopta") says so.

python examples/python/nocturnal_bee.py
"""

import omma
from omma.species.facts import number


def sensitivities():
    """{step: S in m² sr} from a honeybee to Megalopta, one change after the other."""
    bee, night = "honeybee_worker", "megalopta"
    absorption = number(bee, "absorption")

    def sensitivity(facet, rhabdom, focal, length):
        return omma.receptors.optical_sensitivity(
            number(facet, "largest_facet_diameter" if facet == bee else "facet_diameter"),
            number(rhabdom, "rhabdom_diameter") / number(focal, "focal_length"),
            number(length, "rhabdom_length"),
            absorption,
        )

    return {
        "honeybee": sensitivity(bee, bee, bee, bee),
        "with wide facets": sensitivity(night, bee, bee, bee),
        "and wide rhabdoms": sensitivity(night, night, bee, bee),
        "and a longer focus": sensitivity(night, night, night, bee),
        "Megalopta": sensitivity(night, night, night, night),
    }


def main():
    found = sensitivities()
    for step, value in found.items():
        print(f"{step:20s} {value * 1e12:6.3f} µm² sr  {value / found['honeybee']:5.1f} times")


if __name__ == "__main__":
    main()
