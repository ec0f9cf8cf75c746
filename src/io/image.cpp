// Images in and out: PNG, JPEG, WebP, Radiance HDR and OpenEXR are read, PNG is written. Here is what all
// formats have in common; each has a file of its own, the only one to include its library.
#include "io/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "io/atomic_file.h"
#include "omma/error.h"
#include "omma/io.h"

namespace omma {
namespace {

constexpr std::int64_t max_extent = 65536;
constexpr std::uint64_t max_pixels = std::uint64_t{1} << 28;

struct Format {
  bool (*matches)(EncodedImage);
  ImageClaim (*claim)(EncodedImage, const std::string&);
  Image (*decode)(EncodedImage, const std::string&, const WorkPart&);
};

constexpr Format formats[] = {{is_png, png_claim, decode_png},
                              {is_jpeg, jpeg_claim, decode_jpeg},
                              {is_webp, webp_claim, decode_webp},
                              {is_radiance_hdr, radiance_hdr_claim, decode_radiance_hdr},
                              {is_openexr, openexr_claim, decode_openexr}};

// What is no format here, by the first bytes of its files.
constexpr std::pair<std::string_view, std::string_view> other_formats[] = {
    {"GIF8", "GIF"}, {"BM", "BMP"}, {{"II*\0", 4}, "TIFF"}, {{"MM\0*", 4}, "TIFF"}};

const Format& format_of(EncodedImage bytes, const std::string& place) {
  for (const Format& format : formats)
    if (format.matches(bytes)) return format;
  const std::string expected = "expected PNG, JPEG, WebP, Radiance HDR or OpenEXR";
  for (const auto& [start, name] : other_formats)
    if (bytes.size() >= start.size() && std::equal(start.begin(), start.end(), bytes.begin()))
      throw Error(place + ": is a " + std::string(name) + ", which is not read: " + expected);
  throw Error(place + ": is not an image: " + expected);
}

// An image that is charged to no other budget than its own.
Image decode_alone(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  const ImageClaim claim = image_claim(bytes, place);
  const std::uint64_t budget = image_budget(bytes.size());
  if (claim.memory > budget)
    throw Error(place + ": its " + std::to_string(claim.width) + " x " +
                std::to_string(claim.height) + " pixels need " + std::to_string(claim.memory) +
                " bytes of memory; for an image of " + std::to_string(bytes.size()) +
                " bytes at most " + std::to_string(budget) + " are expected");
  return decode_claimed_image(bytes, place, work);
}

}  // namespace

// Here, as a build without OpenEXR's library knows such files too.
bool is_openexr(EncodedImage bytes) {
  constexpr std::array<std::uint8_t, 4> magic = {0x76, 0x2F, 0x31, 0x01};
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

void check_primaries(const Primaries& found, const std::string& place) {
  constexpr Primaries srgb = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
  // Radiance's own, whose white is that of equal energy, are 0.021 from them and count as the same;
  // those of wider gamuts (Adobe RGB, P3, Rec. 2020, ACES) are 0.05 or more away.
  constexpr double same = 0.025;
  bool is_same = true;
  for (std::size_t i = 0; i < srgb.size(); ++i)
    is_same = is_same && std::abs(found[i] - srgb[i]) <= same;
  if (is_same) return;
  std::string shown;
  for (std::size_t i = 0; i < found.size(); i += 2) {
    char pair[64];
    std::snprintf(pair, sizeof pair, "%s(%.4g, %.4g)", i == 0 ? "" : " ", found[i], found[i + 1]);
    shown += pair;
  }
  throw Error(place + ": expected colours of sRGB's primaries (Rec. 709), found red, green, blue " +
              "and white at (x, y) " + shown + ": convert it to linear sRGB first");
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

ImageClaim image_claim(EncodedImage bytes, const std::string& place) {
  const ImageClaim claim = format_of(bytes, place).claim(bytes, place);
  const std::string size = std::to_string(claim.width) + " x " + std::to_string(claim.height);
  if (claim.width < 1 || claim.height < 1)
    throw Error(place + ": the image has no pixels (" + size + ")");
  if (claim.width > max_extent || claim.height > max_extent)
    throw Error(place + ": the image is too large: " + size + " pixels, at most " +
                std::to_string(max_extent) + " each way are read");
  const auto pixels = static_cast<std::uint64_t>(claim.width * claim.height);
  if (pixels > max_pixels)
    throw Error(place + ": the image is too large: " + size + " pixels, at most " +
                std::to_string(max_pixels) + " are read");
  if (pixels > claim.most_pixels)
    throw Error(place + ": the image claims " + size + " pixels, more than its " +
                std::to_string(bytes.size()) + " bytes can hold");
  return claim;
}

std::uint64_t image_budget(std::uint64_t encoded_bytes) {
  return 4 * max_pixels + 256 * encoded_bytes;
}

Image decode_claimed_image(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  return format_of(bytes, place).decode(bytes, place, work);
}

Image decode_image(EncodedImage bytes, const std::string& place) {
  return decode_alone(bytes, place, {});
}

Image load_image(const std::string& path, const std::function<bool(double)>& progress) {
  Image image;
  run_watched(progress, [&](WorkState& state) {
    const WorkPart work{&state};
    const std::string bytes = read_file(path, work.part(0, 0.3));
    image = decode_alone({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path,
                         work.part(0.3, 1));
  });
  image.name = path;
  return image;
}

std::string png_bytes(const std::string& path, std::span<const std::uint8_t> pixels, int width,
                      int height, int components, PngPacking packing,
                      const std::function<bool(double)>& progress) {
  if (components != 3 && components != 4)
    throw Error(path + ": a PNG of " + std::to_string(components) +
                " components, expected 3 (RGB) or 4 (RGBA)");
  if (width < 1 || height < 1)
    throw Error(path + ": a PNG of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels cannot be written");
  const std::uint64_t expected = static_cast<std::uint64_t>(width) *
                                 static_cast<std::uint64_t>(height) *
                                 static_cast<std::uint64_t>(components);
  if (expected != pixels.size())
    throw Error(path + ": a PNG of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels needs " + std::to_string(expected) + " bytes, found " +
                std::to_string(pixels.size()));
  std::string png;
  run_watched(progress, [&](WorkState& state) {
    png = encode_png(pixels, width, height, components, packing, path, {&state});
  });
  return png;
}

void save_png(const std::string& path, std::span<const std::uint8_t> pixels, int width, int height,
              int components, const std::function<bool(double)>& progress) {
  write_file_atomically(path, png_bytes(path, pixels, width, height, components, PngPacking::small,
                                        progress));
}

}  // namespace omma
