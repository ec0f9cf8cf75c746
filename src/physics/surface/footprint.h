// How wide a ray is. A ray stands for its part of an ommatidium's solid angle; a texture finer
// than that part is read from a coarser level of its image (physics/surface/texture.h) instead of at one
// texel by chance. The price is that texels of that level widen the acceptance function a little.
//
// How wide they may be. A level with texels of width T is the image averaged over T (variance
// T^2/12 along each axis) and read between texel centres (a tent, T^2/6): together T^2/4, also
// between two levels (find_level). That takes the modulation transfer M of a kernel, at k rad per
// rad, to M exp(-k^2 T^2/8). For a Gaussian of standard deviation s, with x = k^2 s^2/2,
//
//   M - M' = exp(-x) (1 - exp(-x T^2/(4 s^2))) < T^2/(4 e s^2),
//
// largest near x = 1. We ask for 0.008, a fifth below the 0.01 that is promised, to leave room for
// what the average over a square lets pass (aliasing): T = 0.296 s = 0.126 of the full width at
// half maximum. The same bound for the others, found numerically as the largest |M| (1 -
// exp(-k^2 T^2/8)) over all k: a pillbox, M = 2 J1(x)/x with x = k/2 of its width, bears 0.055 of
// it; CompoundRay's kernel, M = exp(-x/2) I0(x/2), with its cusp at the axis, 0.019; Airy's pattern
// 0.122. With a rhabdom it is 0.119 to 0.145 of the width with one mode; it falls to a pillbox's as
// the width grows over lambda/D.
#pragma once

#include "omma/kernel.h"
#include "omma/vec.h"

namespace omma {

// Widest footprint over acceptance angle that changes the modulation transfer by under 0.01;
// `lens_widths`: of a lens_rhabdom, its acceptance angle over lambda/D.
OMMA_HD double widest_footprint(Kernel kernel, double lens_widths) {
  switch (kernel) {
    case Kernel::gaussian:
      return 0.126;
    case Kernel::pillbox:
      return 0.055;
    case Kernel::compoundray:
      return 0.019;
    case Kernel::airy:
      return 0.122;
    case Kernel::lens_rhabdom:
      return fmax(0.055, 0.11 - 0.006 * lens_widths);
    case Kernel::table:
      return 0;  // found from its own transfer
  }
  return 0;
}

// Full width of the footprint of one of `samples` rays, as an angle; `widest`: that it may have. A
// Gaussian's solid angle is 2 pi s^2 = (1.06 acceptance)^2, so a ray's part is a square of about
// acceptance / sqrt(samples): with more rays the footprint vanishes, and with it the bias. 0 for
// single rays along the axis.
OMMA_HD double footprint_width_rad(double widest_rad, double acceptance_rad, int samples) {
  return fmin(widest_rad, acceptance_rad * (1 / sqrt(static_cast<double>(samples))));
}

}  // namespace omma
