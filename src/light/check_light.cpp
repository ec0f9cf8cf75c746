// Checks of a Light, where it is made. Written so that NaN fails each of them.
#include "light/check_light.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "omma/error.h"
#include "omma/scene_kinds.h"
#include "threads/parallel.h"

namespace omma {
namespace {

std::string number_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

[[noreturn]] void refuse(const std::string& member, const std::string& expected,
                         const std::string& found) {
  throw Error(member + ": expected " + expected + ", found " + found);
}

bool is_radiance(double x) {
  return x >= 0 && x <= most_radiance;
}

const std::string a_radiance = "radiance of 0 to 1e30";

void check_bands(const Bands& bands) {
  const std::size_t samples = bands.wavelength_nm.size();
  if (samples == 0) refuse("bands.wavelength_nm", "at least one wavelength", "none");
  double before = 0;
  for (const double nm : bands.wavelength_nm) {
    if (!(nm > before) || !(nm >= 100 && nm <= 5000))
      refuse("bands.wavelength_nm", "wavelengths of 100 to 5000 nm that ascend",
             number_text(nm) + " after " + number_text(before));
    before = nm;
  }
  if (!bands.cell_nm.empty() && bands.cell_nm.size() != samples)
    refuse("bands.cell_nm", "none or " + std::to_string(samples) + " widths",
           std::to_string(bands.cell_nm.size()));
  for (const double width_nm : bands.cell_nm)
    if (!(width_nm >= 0 && width_nm <= 5000))
      refuse("bands.cell_nm", "widths of 0 to 5000 nm", number_text(width_nm));
  const std::size_t count = bands.weight.size() / samples;
  if (count * samples != bands.weight.size() || count == 0 || count > std::size_t{most_bands})
    refuse(
        "bands.weight",
        "1 to " + std::to_string(most_bands) + " rows of " + std::to_string(samples) + " weights",
        std::to_string(bands.weight.size()) + " weights");
  for (std::size_t b = 0; b < count; ++b) {
    double sum = 0;
    for (std::size_t i = 0; i < samples; ++i) {
      const double w = bands.weight[b * samples + i];
      if (!(w >= 0))
        refuse("bands.weight", "weights of 0 or more",
               number_text(w) + " in band " + std::to_string(b));
      sum += w;
    }
    if (!(std::fabs(sum - 1) <= 1e-6))
      refuse("bands.weight", "weights that add up to 1 in each band",
             number_text(sum) + " in band " + std::to_string(b));
  }
}

// Of the nodes in a row of a map, whether any number is none that light can have.
bool is_row_valid(const SkyMap& sky, std::size_t row) {
  const auto columns = static_cast<std::size_t>(sky.columns);
  const auto channels = static_cast<std::size_t>(sky.channels);
  const auto components = static_cast<std::size_t>(sky.components);
  for (std::size_t c = 0; c < columns; ++c) {
    const float* at = sky.radiance.data() + (row * columns + c) * components * channels;
    for (std::size_t k = 0; k < channels; ++k) {
      const double i = static_cast<double>(at[k]);
      if (!is_radiance(i)) return false;
      if (components == 1) continue;
      const double q = static_cast<double>(at[channels + k]);
      const double u = static_cast<double>(at[2 * channels + k]);
      // A thousandth for what tables are rounded to.
      if (!(q * q + u * u <= i * i * (1 + 1e-3))) return false;
    }
  }
  return true;
}

[[noreturn]] void refuse_node(const SkyMap& sky, std::size_t row) {
  const auto rows = static_cast<std::size_t>(sky.rows);
  refuse("sky.radiance", a_radiance + " and Q^2 + U^2 of at most I^2 at each node",
         "others in row " + std::to_string(row % rows) + (row < rows ? " above" : " below") +
             " the horizon");
}

void check_sky(const SkyMap& sky, std::size_t bands) {
  if (sky.columns < 4 || sky.columns > most_sky_columns)
    refuse("sky.columns", "4 to " + std::to_string(most_sky_columns), std::to_string(sky.columns));
  if (sky.rows < 2 || sky.rows > most_sky_rows)
    refuse("sky.rows", "2 to " + std::to_string(most_sky_rows), std::to_string(sky.rows));
  if (sky.components != 1 && sky.components != 3)
    refuse("sky.components", "1 (I) or 3 (I, Q, U)", std::to_string(sky.components));
  if (sky.channels < 1 || sky.channels > most_bands)
    refuse("sky.channels", "1 to " + std::to_string(most_bands), std::to_string(sky.channels));
  const auto channels = static_cast<std::size_t>(sky.channels);
  if (sky.band_from_channel.empty() && channels != bands)
    refuse("sky.channels", "one for each of " + std::to_string(bands) + " bands",
           std::to_string(channels));
  if (!sky.band_from_channel.empty()) {
    if (sky.band_from_channel.size() != bands * channels)
      refuse("sky.band_from_channel",
             std::to_string(bands) + " rows of " + std::to_string(channels) + " weights",
             std::to_string(sky.band_from_channel.size()) + " weights");
    for (const double w : sky.band_from_channel)
      if (!(w >= 0 && w <= 1e6))
        refuse("sky.band_from_channel", "weights of 0 to 1e6", number_text(w));
  }
  const std::size_t rows = 2 * static_cast<std::size_t>(sky.rows);
  const std::size_t size = rows * static_cast<std::size_t>(sky.columns) *
                           static_cast<std::size_t>(sky.components) * channels;
  if (sky.radiance.size() != size)
    refuse("sky.radiance", std::to_string(size) + " numbers", std::to_string(sky.radiance.size()));
  std::atomic<std::size_t> bad = rows;
  parallel_for(std::size_t{0}, rows, [&](std::size_t row) {
    if (is_row_valid(sky, row)) return;
    std::size_t first = bad;
    while (row < first && !bad.compare_exchange_weak(first, row)) {
    }
  });
  if (bad < rows) refuse_node(sky, bad);
}

void check_disc(const Disc& disc, std::size_t bands, const std::string& name) {
  if (!(std::fabs(length(to_double(disc.direction)) - 1) <= 1e-4))
    refuse(name + ".direction", "a unit vector",
           "one of length " + number_text(length(to_double(disc.direction))));
  // In single precision directions within a smaller one are not told from those beside it.
  if (!(disc.angular_radius_rad >= 1e-6 && disc.angular_radius_rad < 0.1))
    refuse(name + ".angular_radius_rad", "1e-6 or more and below 0.1",
           number_text(disc.angular_radius_rad));
  if (disc.radiance.size() != bands)
    refuse(name + ".radiance", "one for each of " + std::to_string(bands) + " bands",
           std::to_string(disc.radiance.size()));
  for (const double x : disc.radiance)
    if (!is_radiance(x)) refuse(name + ".radiance", a_radiance, number_text(x));
  if (!disc.limb_darkening.empty() && disc.limb_darkening.size() != bands)
    refuse(name + ".limb_darkening", "one for each of " + std::to_string(bands) + " bands, or none",
           std::to_string(disc.limb_darkening.size()));
  for (const double u : disc.limb_darkening)
    if (!(u >= 0 && u <= 1)) refuse(name + ".limb_darkening", "0 to 1", number_text(u));
}

void check_cloud_shadow(const CloudShadow& shadow) {
  const std::string name = "cloud_shadow.";
  if (shadow.columns < 2 || shadow.rows < 2)
    refuse(name + "optical_depth", "2 or more rows and columns",
           std::to_string(shadow.rows) + " x " + std::to_string(shadow.columns));
  if (shadow.optical_depth.size() !=
      static_cast<std::size_t>(shadow.rows) * static_cast<std::size_t>(shadow.columns))
    refuse(name + "optical_depth", "one number for each row and column",
           std::to_string(shadow.optical_depth.size()));
  for (const float x : shadow.optical_depth)
    if (!(x >= 0 && x <= 1e6f))
      refuse(name + "optical_depth", "numbers of 0 to 1e6", number_text(static_cast<double>(x)));
  if (!(shadow.spacing_m >= 1e-3 && shadow.spacing_m <= 1e6))
    refuse(name + "spacing_m", "0.001 to 1e6", number_text(shadow.spacing_m));
  const std::pair<const char*, double> places[] = {{"height_m", shadow.height_m},
                                                   {"first_x_m", shadow.first_x_m},
                                                   {"first_z_m", shadow.first_z_m}};
  for (const auto& [member, x] : places)
    if (!(x >= -1e9 && x <= 1e9)) refuse(name + member, "-1e9 to 1e9", number_text(x));
}

}  // namespace

void validate_light(const Light& light, std::size_t materials) {
  check_bands(light.bands);
  const std::size_t bands = light.bands.count();
  if (light.sky != nullptr) check_sky(*light.sky, bands);
  for (std::size_t i = 0; i < light.discs.size(); ++i)
    check_disc(light.discs[i], bands, "discs[" + std::to_string(i) + "]");
  const std::vector<double>& extinction = light.extinction_per_m;
  if (!extinction.empty() && extinction.size() != bands)
    refuse("extinction_per_m", "one for each of " + std::to_string(bands) + " bands, or none",
           std::to_string(extinction.size()));
  for (const double x : extinction)
    if (!(x >= 0 && x <= most_extinction_per_m))
      refuse("extinction_per_m", "numbers of 0 to 1000", number_text(x));
  if (light.cloud_shadow != nullptr) check_cloud_shadow(*light.cloud_shadow);
  if (!(light.emission_cd_m2 >= 0 && light.emission_cd_m2 <= 1e15))
    refuse("emission_cd_m2", "a number of 0 to 1e15", number_text(light.emission_cd_m2));
  if (!light.ultraviolet.empty() && light.ultraviolet.size() != materials)
    refuse("ultraviolet",
           "none, or " + std::to_string(materials) +
               ": one for each material and one for meshes without",
           std::to_string(light.ultraviolet.size()));
  for (const auto& weights : light.ultraviolet) {
    for (const double w : weights)
      if (!(w >= 0)) refuse("ultraviolet", "weights of 0 or more", number_text(w));
    const double white = weights[0] + weights[1] + weights[2] + weights[3];
    if (!(white <= 1 + 1e-6))
      refuse("ultraviolet", "weights that add up to 1 at most", number_text(white));
  }
}

}  // namespace omma
