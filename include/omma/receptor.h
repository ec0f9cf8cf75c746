// Photoreceptors: what looks through a lens. An ommatidium has one or several receptors, each of a
// type; types can be mixed over the eye.
#pragma once

#include <optional>
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

}  // namespace omma
