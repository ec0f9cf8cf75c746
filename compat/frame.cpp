// Frames: display values and the PPM file, see frame.h.
#include "frame.h"

#include <algorithm>
#include <cmath>

#include "omma/error.h"
#include "omma/io.h"

namespace omma::compat {

void resize(Frame& frame, int width, int height) {
  width = std::max(width, 1), height = std::max(height, 1);
  // A gigapixel, 4 GB; beyond it a wrong argument is likelier than a wish.
  if (static_cast<long long>(width) * height > 1LL << 30)
    throw Error("the rendering buffer cannot be " + std::to_string(width) + " x " +
                std::to_string(height) + " pixels, at most 2^30 in all");
  frame.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), {});
  frame.width = width, frame.height = height;
}

Rgba display_color(const float* rgb) {
  Rgba color{0, 0, 0, 255};
  for (std::size_t k = 0; k < 3; ++k) {
    const float shown = std::pow(std::clamp(rgb[k], 0.0f, 1.0f), 1 / 2.2f) * 255.0f;
    color[k] = static_cast<std::uint8_t>(shown);
  }
  return color;
}

void save_ppm(const std::string& path, const Frame& frame) {
  std::string bytes =
      "P6\n" + std::to_string(frame.width) + " " + std::to_string(frame.height) + "\n255\n";
  bytes.reserve(bytes.size() + 3 * frame.pixels.size());
  const auto width = static_cast<std::size_t>(frame.width);
  for (std::size_t row = static_cast<std::size_t>(frame.height); row-- > 0;)
    for (std::size_t column = 0; column < width; ++column) {
      const Rgba& pixel = frame.pixels[row * width + column];
      for (std::size_t k = 0; k < 3; ++k) bytes.push_back(static_cast<char>(pixel[k]));
    }
  write_file_atomically(path, bytes);
}

}  // namespace omma::compat
