// What a world is lit by, in absolute units: a sky, discs far away such as the sun, and the lamps
// and shining surfaces of its scene.
//
// Spectral radiance is in photons m^-2 s^-1 sr^-1 nm^-1, or in W m^-2 sr^-1 nm^-1. Polarised light
// is a Stokes vector (I, Q, U): with psi the angle of the electric vector from a reference axis,
// turning to the right as one looks towards the light, and p the degree of polarisation,
// Q = p I cos 2 psi, U = p I sin 2 psi. The reference axis of light from afar points up, in the
// plane of its direction and the vertical. Circular polarisation is not simulated.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "omma/spectrum.h"
#include "omma/vec.h"

namespace omma {

enum class LightUnit : std::uint8_t { photons, watts };

// Radiance from afar by direction, bilinear between nodes. Columns are azimuths: column c looks
// 2 pi c / columns to the right of -Z, seen from above. Rows are elevations, evenly from the horizon
// (row 0) to the zenith, and from the horizon to the nadir: the horizon belongs to both halves, so
// that light may change there at once. At the zenith and the nadir all columns look one way, but
// each has a reference axis of its own.
struct SkyMap {
  int columns = 0;     // 4 or more
  int rows = 0;        // of each half, 2 or more
  int components = 1;  // 1: I; 3: I, Q, U
  int channels = 0;    // numbers of each component: bands, or what band_from_channel takes
  std::vector<float> radiance;  // [above, below][row][column][component][channel]
  // [band][channel], as for a panorama in RGB; empty: channels are the bands.
  std::vector<double> band_from_channel;

  bool operator==(const SkyMap&) const = default;
};

// A disc far away, unpolarised: the sun, the moon.
struct Disc {
  Vec3 direction{0, 1, 0};       // towards its centre, unit
  double angular_radius_rad = 0; // 1e-6 or more, below a tenth
  std::vector<double> radiance;  // [band], mean over the disc
  // [band], u in L(mu) = L(1) (1 - u (1 - mu)), mu the cosine at the disc's own surface; empty: 0.
  std::vector<double> limb_darkening;

  bool operator==(const Disc&) const = default;
};

// A level layer of clouds as it shades what lies below it from discs: of their light it lets
// exp(-depth / sin e) through, e the elevation of a disc's centre, where the way to that centre
// crosses the layer. Bilinear between nodes, and the map repeats without end. Skies have their
// clouds in them already.
struct CloudShadow {
  int columns = 0, rows = 0;  // 2 or more each
  double spacing_m = 0;       // between nodes
  double height_m = 0;        // in the world; what lies higher is not shaded
  double first_x_m = 0, first_z_m = 0;  // where the node of row 0 and column 0 is
  std::vector<float> optical_depth;     // [row][column], upwards; columns along +X, rows along +Z

  bool operator==(const CloudShadow&) const = default;
};

struct Light {
  Bands bands;
  LightUnit unit = LightUnit::photons;
  std::shared_ptr<const SkyMap> sky;  // null: dark
  std::vector<Disc> discs;
  // [band], m^-1, of the air between surfaces: haze, mist, fog, which shows the sky's horizon
  // (physics/path/air.h); empty: clear.
  std::vector<double> extinction_per_m;
  // Whether that air goes on below without end, as deep water does: who looks down sees the sky
  // below the horizon in place of the horizon.
  bool bottomless = false;
  std::shared_ptr<const CloudShadow> cloud_shadow;  // null: none
  // [material of the scene, and at the end of meshes without one], reflectance below 400 nm of what
  // is known in RGB only, as weights of linear red, green, blue and of 1; empty: none reflects any.
  std::vector<std::array<double, 4>> ultraviolet;
  // What white emission of 1 is, cd m^-2, of materials without a spectrum of what they emit. Files
  // mean 1 (glTF, KHR_materials_emissive_strength).
  double emission_cd_m2 = 1;
};

}  // namespace omma
