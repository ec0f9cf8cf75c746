// Real spherical harmonics to degree 3 in the order and with the signs that Gaussian splats have
// (Kerbl et al. 2023; constants as in Ramamoorthi and Hanrahan 2001, doi:10.1145/383259.383317).
#pragma once

#include "omma/vec.h"
#include "physics/search/splats_view.h"

namespace omma {

// Of the first `terms`, 1, 4, 9 or 16; `d` is unit.
OMMA_HD void eval_harmonics(Vec3 d, int terms, float (&y)[most_harmonics]) {
  const float xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z;
  y[0] = 0.28209479f;  // 1 / (2 √π)
  if (terms < 4) return;
  y[1] = -0.48860251f * d.y;
  y[2] = 0.48860251f * d.z;
  y[3] = -0.48860251f * d.x;
  if (terms < 9) return;
  y[4] = 1.09254843f * d.x * d.y;
  y[5] = -1.09254843f * d.y * d.z;
  y[6] = 0.31539157f * (2.0f * zz - xx - yy);
  y[7] = -1.09254843f * d.x * d.z;
  y[8] = 0.54627422f * (xx - yy);
  if (terms < 16) return;
  y[9] = -0.59004359f * d.y * (3.0f * xx - yy);
  y[10] = 2.89061144f * d.x * d.y * d.z;
  y[11] = -0.45704580f * d.y * (4.0f * zz - xx - yy);
  y[12] = 0.37317633f * d.z * (2.0f * zz - 3.0f * xx - 3.0f * yy);
  y[13] = -0.45704580f * d.x * (4.0f * zz - xx - yy);
  y[14] = 1.44530572f * d.z * (xx - yy);
  y[15] = -0.59004359f * d.x * (xx - 3.0f * yy);
}

}  // namespace omma
