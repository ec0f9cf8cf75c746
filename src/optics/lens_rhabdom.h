// What diffraction at a facet and the rhabdom behind it make of the angular sensitivity.
//
// A distant point at the angle theta makes an Airy pattern in the focal plane, centred f sin(theta)
// from the rhabdom's axis. A rhabdom thin against the wavelength is a waveguide: it takes what of
// the pattern's amplitude overlaps with its modes LP_lm (with one mode S is thus that mode's far
// field: van Hateren 1984, J Comp Physiol A 154, 761), and of each mode it absorbs in proportion to
// the part of the mode's power inside it. That is so as long as little of the light is absorbed: a
// long rhabdom takes all of every mode in the end, and weighs them alike. Modes: Stavenga 2004, J
// Comp Physiol A 190, 115, equations A1 to A4. A wide rhabdom takes all light that falls on its
// tip: the geometric limit.
//
// All lengths in the focal plane are over (lambda f)/(pi D), so that x = (pi D/lambda) sin(theta)
// is where the pattern is, the pupil is the disc of spatial frequencies under 1, and the rhabdom's
// radius is b = pi D d/(2 lambda f).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "omma/acceptance.h"

namespace omma {

// A mode LP_lm of a round step-index waveguide. The field is J_l(u R)/J_l(u) inside, K_l(w
// R)/K_l(w) outside, R over the radius, times the cosine or sine of l times the azimuth.
struct WaveguideMode {
  int l = 0, m = 1;
  double u = 0, w = 0;
  double core_power = 0;  // fraction of the power inside
  double norm = 0;        // integral of the squared field over R dR
};

// V = pi d sqrt(n1^2 - n2^2)/lambda, and the modes that a waveguide of this V carries: u
// J_{l+1}(u)/ J_l(u) = w K_{l+1}(w)/K_l(w), u^2 + w^2 = V^2.
double waveguide_parameter(const Acceptance& acceptance);
std::vector<WaveguideMode> waveguide_modes(double v);

// Hankel transform of a mode's field at the spatial frequency q, both over the rhabdom's radius.
double mode_spectrum(const WaveguideMode& mode, double q);

// Radius b, and the largest V and b that there are tables for.
double rhabdom_radius_x(const Acceptance& acceptance);
inline constexpr double most_waveguide_parameter = 40, most_rhabdom_radius_x = 50;

// S over x, largest 1, in knots that lie profile_step apart, with slopes; beyond the last knot the
// mean over a dark ring, tail / (number of the knot)^3. Of `airy` and `lens_rhabdom` (not
// `snyder`).
inline constexpr int profile_knots = 1025;
inline constexpr double profile_step = 0.19634954084936207;  // pi/16: 16 knots a ring, 64 rings
struct LensProfile {
  std::vector<double> knots;  // [profile_knots][S, slope per knot]
  double tail = 0;
};
std::shared_ptr<const LensProfile> make_lens_profile(const Acceptance& acceptance);

// Of the light of a distant point that the facet lets in, what is inside the rhabdom where S is 1;
// 1 of all kinds but `lens_rhabdom` by modes or by rays, of which S says nothing absolute.
double coupling_efficiency(const Acceptance& acceptance);

// Modulation transfer at spatial frequencies over half the cut-off's: 0 from 2 on. Of the lens
// alone and, for each of many frequencies, of lens and waveguide.
double airy_transfer(double frequency);
std::vector<double> waveguide_transfer(const Acceptance& acceptance,
                                       std::span<const double> frequency);

// A lens of nearly the same S over x, out of few: its facet diameter and the angle of its rhabdom
// over lambda/D are whole numbers of steps, of a part `step` each. With as much the same rhabdom.
Acceptance lens_level(const Acceptance& acceptance, double step);

// Full width of Snyder's Gaussian: its square is (lambda/D)^2 + (d/f)^2.
double snyder_width_rad(const Acceptance& acceptance);

// The transform of a disc of radius 1, 2 J1(x)/x; its square is Airy's pattern.
double disc_transform(double x);

}  // namespace omma
