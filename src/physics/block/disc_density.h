// How dense the rays of an ommatidium are in a disc of the sky, or in a cone that it aims at: at
// one direction, at most, and over the whole.
#pragma once

#include "physics/light/sky.h"
#include "physics/rays/head_motion.h"
#include "physics/rays/rays.h"
#include "physics/rays/replicates.h"
#include "physics/sampling/acceptance_sampling.h"
#include "physics/sampling/path_points.h"
#include "physics/views/light_view.h"

namespace omma {

// Density of an ommatidium's rays per solid angle, at a polar angle and an azimuth from its axis.
// `scale`: EyeView::scale, by which sines of polar angles of its warp are multiplied.
OMMA_HD double eye_pdf(const AcceptanceWarpView& warp, double scale, double theta_rad,
                       double azimuth_rad) {
  if (scale == 1) return acceptance_pdf(warp, theta_rad, azimuth_rad);
  const double sine = sin(theta_rad) / scale;
  if (sine >= 1) return 0;
  const double cosine = sqrt(1 - sine * sine);
  const double unscaled_rad = atan2(sine, cos(theta_rad) < 0 ? -cosine : cosine);
  return acceptance_pdf(warp, unscaled_rad, azimuth_rad) * fabs(cos(theta_rad)) /
         (scale * scale * cosine);
}

// What a replicate (replicates.h) is when it looks at a disc: everything that stays the same over
// its points.
struct DiscTask {
  const FrameView* frame = nullptr;
  const BlockTask* task = nullptr;
  const AcceptanceWarpView* warp = nullptr;
  const DiscView* disc = nullptr;
  const Replicate* replicate = nullptr;
  std::uint32_t hash = 0;  // of replicate and disc
};

// How much of what comes from the rim's side is darkened, of a direction at this chord^2 from the
// centre; 0 there.
OMMA_HD double disc_darkening(const DiscView& disc, double chord_2) {
  const double sine_2 = chord_2 * (1 - 0.25 * chord_2);
  const double cosine_2 = 1 - sine_2 * static_cast<double>(disc.per_sine_2);
  return 1 - sqrt(fmax(cosine_2, 0.0));
}

// A point of the unit circle, evenly, of two numbers in (0, 1).
template <typename F>
OMMA_HD DiscPoints<F> even_disc_points(const UnitPair<F>& pair) {
  const F radius = sqrt_lanes(pair.x);
  const SineCosine<F> turn = sine_cosine((2.0f * pair.y - 1.0f) * 3.14159265f);
  return {radius * turn.cosine, radius * turn.sine};
}

// A direction in a disc, `x` and `y` in the unit circle, which is mapped evenly by solid angle.
OMMA_HD Vec3 disc_direction(const DiscView& disc, float x, float y) {
  const Vec3 n = disc.direction;
  const Axes<float> axes = make_axes(vector_of(n));
  const Vector3<float>&s = axes.tangent, &t = axes.bitangent;
  const float chord_2 = (x * x + y * y) * disc.chord_2;
  const float across = sqrtf(disc.chord_2 * (1.0f - 0.25f * chord_2)),
              along = 1.0f - 0.5f * chord_2;
  return vec_of(vector_of(n) * along + (s * x + t * y) * across);
}

// Density of the replicate's rays in a world direction, where the head is turned by `turn`.
OMMA_HD double unit_pdf(const DiscTask& of, Vec3 direction, const float (&turn)[3][4]) {
  const Replicate& replicate = *of.replicate;
  const float w[3] = {direction.x, direction.y, direction.z};
  double x = 0, y = 0, z = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = static_cast<double>(turn[0][c] * w[0] + turn[1][c] * w[1] + turn[2][c] * w[2]);
    x += d * static_cast<double>(replicate.s[c]);
    y += d * static_cast<double>(replicate.t[c]);
    z += d * static_cast<double>(replicate.axis[c]);
  }
  const double azimuth = of.warp->azimuth == nullptr ? 0 : atan2(y, x);
  return eye_pdf(*of.warp, static_cast<double>(replicate.scale), atan2(sqrt(x * x + y * y), z),
                 azimuth);
}

// How the head is turned when sample `sample` looks, and where its centre is: as HeadMotion's
// nodes.
OMMA_HD void disc_turn(const DiscTask& of, std::uint32_t hash, int sample, float (&turn)[3][4]) {
  if (of.task->motion != nullptr) {
    head_turn<float, std::int32_t>(*of.task->motion, hash, static_cast<std::uint32_t>(sample),
                                   turn);
    return;
  }
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) turn[r][c] = r == c ? 1.0f : 0.0f;
}

// How far from its axis a replicate sees anything, rad: an angle over 2 pi where S has no end.
// Beyond 3.5 widths a Gaussian is below 2e-15 of its peak.
OMMA_HD double reach_of(const AcceptanceWarpView& warp, double scale) {
  const bool ends =
      warp.sensitivity.kernel == Kernel::gaussian || warp.sensitivity.kernel == Kernel::pillbox;
  return ends ? 3.5 * scale * fmax(warp.sensitivity.width_rad, warp.sensitivity.minor_width_rad)
              : 3 * pi;
}

// Bound on the density of the replicate's rays in the disc: where it is nearest to the axis, in its
// middle and where it is furthest, at some times of a frame that lasts.
OMMA_HD double most_unit_pdf(const DiscTask& of) {
  const Replicate& replicate = *of.replicate;
  const AcceptanceWarpView& warp = *of.warp;
  const double radius_rad = 2 * asin(0.5 * sqrt(static_cast<double>(of.disc->chord_2)));
  const double scale = static_cast<double>(replicate.scale);
  const double reach_rad = radius_rad + reach_of(warp, scale);
  const int times = of.task->motion != nullptr ? 32 : 1;
  double most = 0;
  for (int k = 0; k < times; ++k) {
    float turn[3][4];
    disc_turn(of, of.hash, k, turn);
    double local[3] = {};
    const float w[3] = {of.disc->direction.x, of.disc->direction.y, of.disc->direction.z};
    for (int c = 0; c < 3; ++c) {
      const double d =
          static_cast<double>(turn[0][c] * w[0] + turn[1][c] * w[1] + turn[2][c] * w[2]);
      local[0] += d * static_cast<double>(replicate.s[c]);
      local[1] += d * static_cast<double>(replicate.t[c]);
      local[2] += d * static_cast<double>(replicate.axis[c]);
    }
    const double from_axis_2 =
        local[0] * local[0] + local[1] * local[1] + (local[2] - 1) * (local[2] - 1);
    if (from_axis_2 > reach_rad * reach_rad) continue;  // a chord is shorter than its arc
    const double theta = atan2(sqrt(local[0] * local[0] + local[1] * local[1]), local[2]);
    const double azimuth = warp.azimuth == nullptr ? 0 : atan2(local[1], local[0]);
    for (const double at : {fmax(theta - radius_rad, 0.0), theta, fmin(theta + radius_rad, pi)})
      most = fmax(most, eye_pdf(warp, scale, at, azimuth));
  }
  return most;
}

// By what light from a direction d counts in its moments about an axis a, at the angle θ from it:
// θ², and (θ/sin θ)(d − (d·a) a), of length θ, from the axis towards d. A Gaussian's derivatives by
// its width and its axis are made of these (python/omma/rendering/gaussian_scores.py).
struct AxisMoments {
  double factor[axis_moments];
};

OMMA_HD AxisMoments axis_moments_at(const Replicate& replicate, Vec3 direction) {
  const double d[3] = {direction.x, direction.y, direction.z};
  double along = 0, sine_2 = 0, across[3];
  for (int c = 0; c < 3; ++c) along += d[c] * static_cast<double>(replicate.axis[c]);
  for (int c = 0; c < 3; ++c) {
    across[c] = d[c] - along * static_cast<double>(replicate.axis[c]);
    sine_2 += across[c] * across[c];
  }
  const double sine = sqrt(sine_2), theta = atan2(sine, along);
  const double per_sine = sine > 0 ? theta / sine : 1;
  return {{theta * theta, per_sine * across[0], per_sine * across[1], per_sine * across[2]}};
}

// ∫ over the disc of the density of the replicate's rays, [0], and times the darkening, [1];
// `moments`: the same of that times each factor of AxisMoments, where they are asked for.
struct DiscIntegral {
  double whole[2] = {}, moments[2][axis_moments] = {};
};

// In how many pieces and turns integrate_disc goes.
struct DiscSteps {
  int pieces, turns;
};

// Small ones where S has edges, or changes much within the disc. About the centre of a disc of
// radius r as wide as a Gaussian of width w, at up to 3.5 w from its axis, m turns leave out
// exp(-m^2 / (2 x)) of what it adds, x = 8 ln 2 r (r + 3.5 w) / w^2: 2e-5 at most.
OMMA_HD DiscSteps steps_on_disc(const DiscTask& of) {
  const Kernel kernel = of.warp->sensitivity.kernel;
  if (kernel == Kernel::pillbox || kernel == Kernel::table) return {4, 128};
  const double minor_rad =
      static_cast<double>(of.replicate->scale) * of.warp->sensitivity.minor_width_rad;
  double width_rad = sqrt(static_cast<double>(of.replicate->acceptance_sr) / 1.133);
  if (minor_rad > 0) width_rad = fmin(width_rad, minor_rad);
  const double radius_rad = sqrt(static_cast<double>(of.disc->chord_2));
  if (radius_rad < 0.5 * width_rad) return {1, 16};
  return radius_rad < 1.2 * width_rad ? DiscSteps{2, 32} : DiscSteps{4, 64};
}

// In cosines at the disc by Gauss and Legendre's rule, which limb darkening is smooth in, and in
// turns about its centre. While the head moves a mean over times too.
OMMA_HD DiscIntegral integrate_disc(const DiscTask& of) {
  constexpr double node[8] = {0.0198550717512319, 0.1016667612931866, 0.2372337950418355,
                              0.4082826787521751, 0.5917173212478249, 0.7627662049581645,
                              0.8983332387068134, 0.9801449282487681};
  constexpr double weight[8] = {0.0506142681451881, 0.1111905172266872, 0.1568533229389436,
                                0.1813418916891810, 0.1813418916891810, 0.1568533229389436,
                                0.1111905172266872, 0.0506142681451881};
  const auto [pieces, turns] = steps_on_disc(of);
  const int times = of.task->motion != nullptr ? 16 : 1;
  const DiscView& disc = *of.disc;
  DiscIntegral integral;
  int k = 0;
  for (int ring = 0; ring < 8 * pieces; ++ring) {
    const double cosine = (ring / 8 + node[ring % 8]) / pieces;
    const double part = weight[ring % 8] / pieces * 2 * cosine / (turns * times);
    const double radius_2 = 1 - cosine * cosine, radius = sqrt(radius_2);
    const double darkened = disc_darkening(disc, radius_2 * static_cast<double>(disc.chord_2));
    for (int j = 0; j < turns; ++j) {
      const SineCosine<float> at =
          sine_cosine(static_cast<float>((2.0 * (j + 0.5) / turns - 1) * pi));
      const Vec3 direction = disc_direction(disc, static_cast<float>(radius) * at.cosine,
                                            static_cast<float>(radius) * at.sine);
      for (int i = 0; i < times; ++i) {
        float turn[3][4];
        disc_turn(of, of.hash, k++, turn);
        const double x = part * unit_pdf(of, direction, turn);
        integral.whole[0] += x;
        integral.whole[1] += x * darkened;
        if (!of.frame->beside_moments) continue;
        const AxisMoments moments = axis_moments_at(*of.replicate, direction);
        for (int m = 0; m < axis_moments; ++m) {
          integral.moments[0][m] += x * moments.factor[m];
          integral.moments[1][m] += x * moments.factor[m] * darkened;
        }
      }
    }
  }
  for (int i = 0; i < 2; ++i) {
    integral.whole[i] /= static_cast<double>(disc.density);
    for (double& x : integral.moments[i]) x /= static_cast<double>(disc.density);
  }
  return integral;
}

}  // namespace omma
