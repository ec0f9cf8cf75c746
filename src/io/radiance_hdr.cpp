// Radiance HDR pictures, after G. Ward, "Real Pixels", Graphics Gems II (1991), and Radiance's own
// description of the format: a text header, a line with the size, then scanlines that are plain or
// run-length encoded by component.
#include "io/radiance_hdr.h"

#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "omma/error.h"

namespace omma {
namespace {

struct Reader {
  std::span<const std::uint8_t> bytes;
  std::size_t at;
  std::string place;

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

}  // namespace

bool is_radiance_hdr(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

Image decode_radiance_hdr(std::span<const std::uint8_t> bytes, const std::string& place) {
  Reader reader{bytes, 0, place};
  bool rgbe_format = false;
  for (std::string line = reader.line(); !line.empty(); line = reader.line())
    if (line == "FORMAT=32-bit_rle_rgbe") rgbe_format = true;
  if (!rgbe_format) throw Error(place + ": expected FORMAT=32-bit_rle_rgbe in its header");
  Image image;
  const std::string size = reader.line();
  if (std::sscanf(size.c_str(), "-Y %9d +X %9d", &image.height, &image.width) != 2)
    throw Error(place + ": expected its size as \"-Y height +X width\"");
  // A run packs at most 127 pixels into 2 bytes of each component.
  const std::size_t left = bytes.size() - reader.at;
  if (image.width < 1 || image.height < 1 ||
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) > left * 16)
    throw Error(place + ": the image claims " + std::to_string(image.width) + " x " +
                std::to_string(image.height) + " pixels, more than its " +
                std::to_string(bytes.size()) + " bytes can hold");

  const auto row = static_cast<std::size_t>(image.width) * 4;
  image.rgba_linear.resize(row * static_cast<std::size_t>(image.height));
  std::vector<std::uint8_t> rgbe(row);
  for (std::size_t first = 0; first < image.rgba_linear.size(); first += row) {
    read_scanline(reader, rgbe, image.width);
    for (std::size_t i = 0; i < row; i += 4) {
      float* pixel = &image.rgba_linear[first + i];
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = rgbe[i + 3] == 0
                       ? 0.0f
                       : std::ldexp(static_cast<float>(rgbe[i + c]), rgbe[i + 3] - 136);
      pixel[3] = 1.0f;
    }
  }
  return image;
}

}  // namespace omma
