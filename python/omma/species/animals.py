"""The animals, and from whose numbers each is made: their eyes are stored with the package.

How an eye is grown from the numbers is in the module of its kind, bees.py, flies.py and so on.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from omma._core import Error, Eye
from omma.base.arguments import checked, one_of
from omma.receptors.sensitivity import receptor_optical_sensitivity
from omma.species.assumed import Assume, completed
from omma.species.facts import LATIN, OTHERS, facts
from omma.species.species import Species
from omma.species.stored import stored, stored_axes


def names() -> list[str]:
    """The animals there are."""
    return list(LATIN)


def known(name: str) -> str:
    """``name`` where there is such an animal; omma.Error says what is known of others."""
    if name not in LATIN and any(fact.animal == name for fact in facts()):
        raise Error(
            f"name: {name} has numbers (facts({name!r})), but too few are known for its eyes; "
            f"expected one of {', '.join(LATIN)}"
        )
    return one_of(name, LATIN, "name", OTHERS)


@cache
def with_catches() -> tuple[str, ...]:
    """The animals of which `omma.receptors.photon_catch` can count photons without an assumption:
    whose facets, rhabdoms and their absorption are all known."""
    eyes = {name: stored(name).eye for name in LATIN}
    return tuple(
        name for name, eye in eyes.items()
        if eye.receptor_types
        and np.isfinite(receptor_optical_sensitivity(eye)).all()
    )  # fmt: skip


def name_of(eye: Eye) -> str | None:
    """The animal whose eyes, or one of whose eyes, these are, by their axes; None: of none here."""
    for name in LATIN:
        axis, side = stored_axes(name)
        if any(np.array_equal(one, eye.axis) for one in (axis, axis[side == 0], axis[side == 1])):
            return name
    return None


@checked
def make(name: str, *, assume: Assume = None) -> Species:
    """The animal of this name, as its own function gives it.

    Args:
        assume: the animal from which numbers are taken that this one lacks for counting photons
            (`omma.receptors.photon_catch`): lengths and absorption of its rhabdoms, and of an
            animal without receptors its pigments, one receptor of each along the axis. Or several
            animals: of each number the first that has it. `Species.assumed` says what was taken
            from whom; what this animal has is kept. Rhabdoms that absorb make sensitivities
            broader. None: nothing is taken.

    Example:
        >>> omma.species.make("bumblebee", assume="honeybee_worker").assumed[0]
        'rhabdom length 320 µm, as of honeybee_worker (measured)'

    Raises:
        omma.Error: no such animal, or a number that none of those in ``assume`` has.
    """
    return completed(stored(known(name)), assume)


@checked
def honeybee_worker(*, assume: Assume = None) -> Species:
    """A honeybee worker, *Apis mellifera*.

    Directions: Giger 1996 as in Stürzl et al. 2010, Bioinspir Biomim 5:036002. Number of facets,
    largest facet, focal length, rhabdom: Somanathan et al. 2009, J Exp Biol 212:2448. Acceptance:
    Eheim & Wehner 1972. Receptors 344, 436 and 544 nm: Peitsch et al. 1992; three types of
    ommatidia, 44:46:10, at random: Wakakuwa et al. 2005. Assumed: the ellipsoid on which the lenses
    sit, from whose spacing follow the facets. Not modelled: the dorsal rim area.

    ``assume`` is that of `make`.
    """
    return completed(stored("honeybee_worker"), assume)


@checked
def honeybee_drone(*, assume: Assume = None) -> Species:
    """A honeybee drone: a dorsal eye of large facets and small angles, which looks for queens.

    The divided eye: Menzel et al. 1991, Tissue Cell 23:525. Acceptance of the dorsal eye: from
    Vallet & Coles 1993, J Comp Physiol A 172:183 (0.41°, 8 %). Receptors: a thesis of the
    University of Vienna, Phaidra o:1268073. About 8,000 facets: popular accounts. Assumed: the
    dorsal angle and facet, the field of view, the surface.

    ``assume`` is that of `make`.
    """
    return completed(stored("honeybee_drone"), assume)


@checked
def bumblebee(*, assume: Assume = None) -> Species:
    """A bumblebee worker, *Bombus terrestris*.

    Number of ommatidia, angles, facets, extent and skew of the eye: computed from the micro-CT of
    a worker, BT_77967, by Taylor et al. 2019 (eLife 8:e40613). Receptor peaks are those of
    *B. hortorum*: Peitsch et al. 1992. Assumed: the smooth course of the angle between the scan's
    percentiles, the acceptance angle and the shares of ommatidia types (the honeybee's).

    ``assume`` is that of `make`.
    """
    return completed(stored("bumblebee"), assume)


@checked
def drosophila(*, assume: Assume = None) -> Species:
    """A female fruit fly, *Drosophila melanogaster*.

    Lenses (857 right, 852 left), angles (median 4.9°, 5-95 %: 3.8-9.5°) and the spacing of lenses:
    computed from the micro-CT of Zhao et al. 2025, Nature, s41586-025-09276-5. Acceptance:
    Gonzalez-Bellido et al. 2011, at second hand. Rhodopsins: Salcedo et al. 1999, J Neurosci
    19:10716. Pale and yellow ommatidia 30:70 at random. R1 to R6 in neural
    superposition. Assumed: the smooth course of the angle from the eye's middle to its edge, the
    field of view, the surface.

    ``assume`` is that of `make`.
    """
    return completed(stored("drosophila"), assume)


@checked
def calliphora(*, assume: Assume = None) -> Species:
    """A female blowfly, *Calliphora*.

    Facet 25 µm, F-number 2.2, rhabdomere 1.4-2.0 µm: the model fly of Stavenga 2004, J Exp Biol
    207:1703, from which the acceptance functions are computed (mode and diffraction). R7 and R8,
    and pale to yellow 2:3: Smola & Meffert 1979, J Comp Physiol 133:41. About 4,500 facets: a
    picture's caption. Assumed: all angles between axes, the field of view, the surface.

    ``assume`` is that of `make`.
    """
    return completed(stored("calliphora"), assume)


@checked
def holcocephala(*, assume: Assume = None) -> Species:
    """A robber fly of 6 mm, *Holcocephala fusca*, each of whose eyes has a frontal fovea.

    In the fovea Δφ 0.28° and lenses of 78 µm, elsewhere about 20 µm and several degrees: Wardill et
    al. 2017, Curr Biol 27:854. "Several thousand lenses": news of the University of Cambridge on
    it. The front's radius of curvature, 16 mm, follows from the first two. Assumed: the number of
    ommatidia, how fast facets and curvature change outside the fovea, that it looks straight ahead,
    and that diffraction alone sets the acceptance angle (the least it can be). Not modelled:
    receptors.

    ``assume`` is that of `make`.
    """
    return completed(stored("holcocephala"), assume)


@checked
def cataglyphis(*, assume: Assume = None) -> Species:
    """A desert ant worker, *Cataglyphis bicolor*, with its dorsal rim area.

    1,000 ommatidia, 80 of them in the rim: Shuker 2001. Where the rim looks and how dense it is:
    Duelli 1975, J Comp Physiol 102:43. Receptors (350 and 510 nm), polarisation sensitivities and
    acceptance angles (3.0° in front, 5.4° in the rim): Labhart 1986, J Comp Physiol A 158:1. A band
    of finer vertical angles along the horizon: Zollikofer et al. 1995, J Exp Biol 198:1637.
    Assumed: the angles outside the rim, the field of view, the surface, and the arrangement of the
    rim: in each
    ommatidium two ultraviolet receptors with microvilli at right angles, turning evenly through
    half a turn from the rim's front to its back.

    ``assume`` is that of `make`.
    """
    return completed(stored("cataglyphis"), assume)


@checked
def melophorus(*, assume: Assume = None) -> Species:
    """A desert ant worker of middling size, *Melophorus bagoti*.

    Numbers of ommatidia, facets, mean interommatidial angle, horizontal field, rhabdom and lens
    blur: Schwarz et al. 2011, Arthropod Struct Dev 40:128. The acceptance angle is Snyder's rule on
    their two parts. Assumed: the vertical field (it follows from number and angle), an even
    lattice, the surface, the receptors (those of *Cataglyphis*).

    ``assume`` is that of `make`.
    """
    return completed(stored("melophorus"), assume)


@checked
def dragonfly(*, assume: Assume = None) -> Species:
    """A large dragonfly, *Anax junius*, with its dorsal acute zone.

    Least Δφ 0.24°: Land 1997, Annu Rev Entomol 42:147. Large dorsal ommatidia, a third of the
    surface, look at a narrow band from the side over the top: Sherk 1978, J Exp Zool 203:61.
    "Up to 30,000" ommatidia: popular accounts. Receptors: *Sympetrum*, Meinertzhagen et al. 1983.
    Assumed: that 0.24° is the angle across the band (along it the eye is far too curved), facets of
    62 µm in it, the eye's size, everything below, the dorsal receptors, acceptance by diffraction.

    ``assume`` is that of `make`.
    """
    return completed(stored("dragonfly"), assume)


@checked
def fiddler_crab(*, assume: Assume = None) -> Species:
    """A fiddler crab, after *Gelasimus* (*Uca*) *vomeris*.

    A panoramic equatorial zone of fine vertical angles, a steeper gradient above it than below,
    little change horizontally, larger facets at the equator: Zeil & Al-Mutairi 1996, J Exp Biol
    199:1569 (*Uca lactea annulipes*). Two streaks just above and below the horizon: Bagheri et al.
    2020, J Exp Biol 223:jeb210195. Receptors: Jordão et al. 2007 (R1-7), J Exp Biol 223:jeb230979
    (R8); microvilli of R3, R4, R7 horizontal, of the others vertical: Alkaladi & Zeil 2014.
    Assumed: every angle's number, the number of ommatidia, the facet, acceptance by diffraction,
    the polarisation sensitivity.

    ``assume`` is that of `make`.
    """
    return completed(stored("fiddler_crab"), assume)
