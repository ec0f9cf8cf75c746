// Photoreceptors: what looks through a lens. An ommatidium has one or several receptors, each of a
// type; types can be mixed over the eye.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "omma/acceptance.h"

namespace omma {

struct ReceptorType {
  std::string name;  // e.g. "green"
  // Spectral sensitivity: a visual pigment of this peak (Govardovskii et al. 2000), or a table of
  // relative sensitivities to equal numbers of photons, linear between, 0 outside.
  double peak_wavelength_nm = 0;      // 0: the table
  std::vector<double> wavelength_nm;  // [knot], ascending
  std::vector<double> sensitivity;    // [knot], the largest 1
  // Azimuth of the microvilli about the ommatidium's axis, from its up vector towards its right,
  // and the ratio of responses to light polarised along and across them; 1: none.
  double microvillus_angle_rad = 0;
  double polarisation_sensitivity = 1;
  // Of the rhabdom: absorption coefficient and length; 0: not known.
  double absorption_per_m = 0;
  double length_m = 0;
  // Where the receptor looks, from the ommatidium's axis: along its right and its up vector.
  double right_rad = 0, up_rad = 0;
  // Its own acceptance; none: the ommatidium's.
  std::optional<Acceptance> acceptance;

  bool operator==(const ReceptorType&) const = default;
};

// Throws omma::Error naming the parameter; `where` begins the message.
void validate_receptor_type(const ReceptorType& type, const std::string& where);

// The light that receptors are asked about: RGB says something of the second part of this range and
// nothing of the ultraviolet below it.
inline constexpr double ultraviolet_from_nm = 300, visible_from_nm = 400, visible_to_nm = 700;

// Absorbance of a visual pigment with chromophore A1 and an alpha band that peaks at a wavelength,
// relative to that peak: its two bands, Govardovskii et al. 2000 (Vis Neurosci 17:509), equations
// 1, 2 and 4, 5. A pigment's absorbance is their sum.
double pigment_alpha_band(double peak_wavelength_nm, double wavelength_nm);
double pigment_beta_band(double peak_wavelength_nm, double wavelength_nm);

// Relative sensitivity of a receptor to equal numbers of photons at these wavelengths. That of a
// pigment a(w) in a rhabdom of known absorption k and length l is what it absorbs,
// [1 - exp(-k l a)] / [1 - exp(-k l)], which is broader than a; a table is taken as it is.
void eval_spectral_sensitivity(const ReceptorType& type, std::span<const double> wavelength_nm,
                               std::span<double> sensitivity);

// Spectra that stand for the linear sRGB primaries: the parts of white's photons that red, green
// and blue take (receptor/primary_spectra.h). They add up to 1 from 400 to 700 nm and are 0
// elsewhere.
std::array<double, 3> primary_spectra(double wavelength_nm);

// What a receptor makes of linear sRGB: weights of red, green and blue,
//   M_c = integral of R s_c dw / integral of R dw, over 300 to 700 nm.
// R is its sensitivity, s_c the spectrum of a primary. So white is equal numbers of photons over
// what is visible to us, and a receptor gets less from it by its part of ultraviolet.
// `ultraviolet`: light from 300 to 400 nm is this mix of the three channels, as (0, 0, 1) for as
// much as blue.
std::array<double, 3> receptor_weights(const ReceptorType& type,
                                       std::array<double, 3> ultraviolet = {0, 0, 0});

}  // namespace omma
