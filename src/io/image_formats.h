// One file for each image format, and what they share. A decoder tells what its header claims
// before it allocates anything for pixels; whoever asked decides whether that is too much. Messages
// of the libraries become omma::Error, their warnings are never printed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "model/long_work.h"
#include "omma/io.h"
#include "omma/scene.h"

namespace omma {

using EncodedImage = std::span<const std::uint8_t>;

// What an image's header says that decoding will take.
struct ImageClaim {
  std::int64_t width = 0, height = 0;  // pixels
  std::uint64_t memory = 0;            // bytes: the pixels, and what the decoder holds besides
  std::uint64_t most_pixels = 0;       // that the encoded bytes can hold, by their format
};

// CIE 1931 chromaticities x and y of red, green, blue and white.
using Primaries = std::array<double, 8>;

// Throws omma::Error where linear colours are of other primaries than sRGB's (Rec. 709).
void check_primaries(const Primaries& found, const std::string& place);

bool is_png(EncodedImage bytes);
bool is_jpeg(EncodedImage bytes);
bool is_webp(EncodedImage bytes);
bool is_radiance_hdr(EncodedImage bytes);
bool is_openexr(EncodedImage bytes);

// `place` names the bytes in errors.
ImageClaim png_claim(EncodedImage bytes, const std::string& place);
ImageClaim jpeg_claim(EncodedImage bytes, const std::string& place);
ImageClaim webp_claim(EncodedImage bytes, const std::string& place);
ImageClaim radiance_hdr_claim(EncodedImage bytes, const std::string& place);
ImageClaim openexr_claim(EncodedImage bytes, const std::string& place);

// Without a name. Throw omma::Error, or omma::Cancelled where `work` is to end.
Image decode_png(EncodedImage bytes, const std::string& place, const WorkPart& work);
Image decode_jpeg(EncodedImage bytes, const std::string& place, const WorkPart& work);
Image decode_webp(EncodedImage bytes, const std::string& place, const WorkPart& work);
Image decode_radiance_hdr(EncodedImage bytes, const std::string& place, const WorkPart& work);
Image decode_openexr(EncodedImage bytes, const std::string& place, const WorkPart& work);

// 8-bit RGB or RGBA (components 3 or 4), of a size that PNG can have, as a PNG file.
std::string encode_png(std::span<const std::uint8_t> pixels, int width, int height, int components,
                       PngPacking packing, const std::string& place, const WorkPart& work);

}  // namespace omma
