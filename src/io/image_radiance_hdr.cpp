// Radiance HDR pictures, after G. Ward, "Real Pixels", Graphics Gems II (1991), and Radiance's own
// description of the format: a text header, a line with the size, then scanlines that are plain or
// run-length encoded by component. Read by hand: what reads them in distributions' packages is part
// of whole image systems (OpenImageIO, FreeImage, ImageMagick), each many times the size of Omma.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "io/image_formats.h"
#include "model/text.h"
#include "omma/error.h"

namespace omma {
namespace {

struct Reader {
  EncodedImage bytes;
  std::string place;
  std::size_t at = 0;

  std::uint8_t next() {
    if (at >= bytes.size()) throw Error(place + ": the image is cut off");
    return bytes[at++];
  }
  std::string line() {
    std::string text;
    for (char c = static_cast<char>(next()); c != '\n'; c = static_cast<char>(next())) text += c;
    return text;
  }
};

// One component of a scanline, written to every fourth byte from `rgbe` on.
void read_runs(Reader& reader, std::uint8_t* rgbe, int width) {
  for (int x = 0; x < width;) {
    int count = reader.next();
    const bool run = count > 128;
    if (run) count -= 128;
    if (count == 0 || count > width - x)
      throw Error(reader.place + ": the image does not decode: a run passes its scanline's end");
    std::uint8_t value = run ? reader.next() : std::uint8_t{0};
    for (; count > 0; --count, ++x) {
      if (!run) value = reader.next();
      rgbe[4 * x] = value;
    }
  }
}

void read_scanline(Reader& reader, std::vector<std::uint8_t>& rgbe, int width) {
  for (std::size_t i = 0; i < 4; ++i) rgbe[i] = reader.next();
  const bool encoded = width >= 8 && width < 32768 && rgbe[0] == 2 && rgbe[1] == 2 &&
                       rgbe[2] * 256 + rgbe[3] == width;
  if (encoded)
    for (int c = 0; c < 4; ++c) read_runs(reader, rgbe.data() + c, width);
  else
    for (std::size_t i = 4; i < rgbe.size(); ++i) rgbe[i] = reader.next();
}

using Rgb = std::array<double, 3>;

struct Header {
  ImageClaim claim;
  Rgb exposure = {1, 1, 1};  // by which red, green and blue have been multiplied
};

// Lines NAME=numbers that tell by what colours were multiplied; each one is by itself, and all of
// them were multiplied in.
void multiply_exposure(const std::string& line, const std::string& place, Rgb& exposure) {
  Rgb by = {};
  const bool one = std::sscanf(line.c_str(), "EXPOSURE=%lf", &by[0]) == 1;
  if (one) by[1] = by[2] = by[0];
  const bool three =
      std::sscanf(line.c_str(), "COLORCORR=%lf %lf %lf", &by[0], &by[1], &by[2]) == 3;
  const auto is_factor = [](double x) { return x > 0 && std::isfinite(x); };
  if (!(one || three) || !std::all_of(by.begin(), by.end(), is_factor))
    throw Error(place +
                ": expected EXPOSURE= and a number, or COLORCORR= and three numbers, above " +
                "0 in its header, found " + readable_text(line));
  for (std::size_t c = 0; c < 3; ++c) exposure[c] *= by[c];
}

// A line PRIMARIES=xr yr xg yg xb yb xw yw.
Primaries primaries_of(const std::string& line, const std::string& place) {
  Primaries p = {};
  if (std::sscanf(line.c_str(), "PRIMARIES=%lf %lf %lf %lf %lf %lf %lf %lf", &p[0], &p[1], &p[2],
                  &p[3], &p[4], &p[5], &p[6], &p[7]) != 8)
    throw Error(place + ": expected PRIMARIES= and eight numbers in its header, found " +
                readable_text(line));
  return p;
}

// The header, up to the pixels.
Header read_header(Reader& reader) {
  const std::string& place = reader.place;
  bool rgbe_format = false;
  Rgb exposure = {1, 1, 1};
  for (std::string line = reader.line(); !line.empty(); line = reader.line()) {
    if (line == "FORMAT=32-bit_rle_rgbe") rgbe_format = true;
    if (line.starts_with("EXPOSURE=") || line.starts_with("COLORCORR="))
      multiply_exposure(line, place, exposure);
    if (line.starts_with("PRIMARIES=")) check_primaries(primaries_of(line, place), place);
  }
  if (!rgbe_format) throw Error(place + ": expected FORMAT=32-bit_rle_rgbe in its header");
  const std::string size = reader.line();
  int width = 0, height = 0;
  if (std::sscanf(size.c_str(), "-Y %9d +X %9d", &height, &width) != 2)
    throw Error(place + ": expected its size as \"-Y height +X width\", found " +
                readable_text(size));
  ImageClaim claim{width, height, 0, 0};
  if (width < 1 || height < 1) return {claim, exposure};
  claim.memory = static_cast<std::uint64_t>(claim.width * claim.height) * 4 * sizeof(float);
  // A run packs at most 127 pixels into 2 bytes of each component.
  claim.most_pixels = std::uint64_t{reader.bytes.size() - reader.at} * 16;
  return {claim, exposure};
}

}  // namespace

bool is_radiance_hdr(EncodedImage bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

ImageClaim radiance_hdr_claim(EncodedImage bytes, const std::string& place) {
  Reader reader{bytes, place};
  return read_header(reader).claim;
}

Image decode_radiance_hdr(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  Reader reader{bytes, place};
  const auto [claim, exposure] = read_header(reader);
  Image image;
  image.width = static_cast<int>(claim.width);
  image.height = static_cast<int>(claim.height);
  const auto row = static_cast<std::size_t>(image.width) * 4;
  image.rgba_linear.resize(row * static_cast<std::size_t>(image.height));
  std::vector<std::uint8_t> rgbe(row);
  for (std::size_t first = 0; first < image.rgba_linear.size(); first += row) {
    work.reach(static_cast<double>(first) / static_cast<double>(image.rgba_linear.size()));
    read_scanline(reader, rgbe, image.width);
    for (std::size_t i = 0; i < row; i += 4) {
      float* pixel = &image.rgba_linear[first + i];
      // Writers cut mantissas off, so a value is in the middle of what gave its own: (m + ½)
      // 2^(e-136) (Ward 1991, `colrval`). Without the half all pictures are 0.2 to 0.4 % too dark,
      // and dark components of saturated colours are up to a half.
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = rgbe[i + 3] == 0 ? 0.0f
                                    : static_cast<float>(std::ldexp(
                                          (rgbe[i + c] + 0.5) / exposure[c], rgbe[i + 3] - 136));
      pixel[3] = 1.0f;
    }
  }
  return image;
}

}  // namespace omma
