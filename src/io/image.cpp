// Images in and out: PNG, JPEG and Radiance HDR are read, PNG is written. stb does PNG and JPEG;
// what a file claims is compared with its size first, so that no claim alone allocates memory.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string_view>

#include "io/atomic_file.h"
#include "io/radiance_hdr.h"
#include "omma/error.h"
#include "omma/io.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 65536
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb_image.h>
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace omma {
namespace {

constexpr std::uint64_t max_pixels = std::uint64_t{1} << 28;

template <typename T>
using StbPixels = std::unique_ptr<T, decltype(&stbi_image_free)>;

bool starts_with(std::span<const std::uint8_t> bytes, std::string_view signature) {
  return bytes.size() >= signature.size() &&
         std::equal(signature.begin(), signature.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

// A JPEG cut off within its scan decodes, its rest grey. Whole ones have an end-of-image marker
// after the start of their first scan (thumbnails with markers of their own come before it).
bool has_jpeg_end(std::span<const std::uint8_t> bytes) {
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && bytes[at] == 0xFF) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const std::size_t length = bytes[at + 2] * 256u + bytes[at + 3];
    if (marker == 0xDA) break;
    at += 2 + length;
  }
  for (; at + 2 <= bytes.size(); ++at)
    if (bytes[at] == 0xFF && bytes[at + 1] == 0xD9) return true;
  return false;
}

// Checks what the header says against the bytes that are there.
void check_size(std::span<const std::uint8_t> bytes, int width, int height, bool png,
                const std::string& place) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (width < 1 || height < 1) throw Error(place + ": the image has no pixels (" + size + ")");
  if (pixels > max_pixels)
    throw Error(place + ": the image is too large: " + size + " pixels, at most " +
                std::to_string(max_pixels) + " are read");
  // Deflate packs at most 1032 bytes into one, and a byte of a PNG holds at most 8 pixels; a JPEG
  // spends at least a bit on each block of 64 pixels.
  const std::uint64_t most_per_byte = png ? 1032 * 8 : 64 * 8;
  if (pixels > bytes.size() * most_per_byte)
    throw Error(place + ": the image claims " + size + " pixels, more than its " +
                std::to_string(bytes.size()) + " bytes can hold");
}

[[noreturn]] void fail_decoding(const std::string& place) {
  const char* why = stbi_failure_reason();
  throw Error(place + ": the image does not decode" +
              (why ? ": " + std::string(why) : std::string()));
}

// IEC 61966-2-1, as glTF 2.0 refers to it.
float linear_from_srgb(double encoded) {
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92
                                               : std::pow((encoded + 0.055) / 1.055, 2.4));
}

void decode_16_bit(const stbi_uc* bytes, int size, Image& image, const std::string& place) {
  int width = 0, height = 0, components = 0;
  const StbPixels<stbi_us> pixels(
      stbi_load_16_from_memory(bytes, size, &width, &height, &components, 4), stbi_image_free);
  if (!pixels) fail_decoding(place);
  static const auto linear = [] {
    std::vector<float> table(65536);
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = linear_from_srgb(static_cast<double>(i) / 65535.0);
    return table;
  }();
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4;
  image.rgba_linear.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    image.rgba_linear[i] =
        i % 4 == 3 ? static_cast<float>(pixels.get()[i]) / 65535.0f : linear[pixels.get()[i]];
}

}  // namespace

Image decode_image(std::span<const std::uint8_t> bytes, const std::string& place) {
  using namespace std::string_view_literals;
  const bool png = starts_with(bytes, "\x89PNG\r\n\x1a\n"sv);
  const bool jpeg = starts_with(bytes, "\xFF\xD8\xFF"sv);
  if (is_radiance_hdr(bytes)) return decode_radiance_hdr(bytes, place);
  if (!png && !jpeg) throw Error(place + ": is not an image: expected PNG, JPEG or Radiance HDR");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw Error(place + ": the image is too large: " + std::to_string(bytes.size()) + " bytes");
  const stbi_uc* data = bytes.data();
  const int size = static_cast<int>(bytes.size());

  Image image;
  int components = 0;
  if (!stbi_info_from_memory(data, size, &image.width, &image.height, &components))
    throw Error(place + ": the image does not decode: its header is broken or claims too much");
  check_size(bytes, image.width, image.height, png, place);
  if (jpeg && !has_jpeg_end(bytes)) throw Error(place + ": the image is cut off");

  const std::size_t count =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4;
  int width = 0, height = 0;
  if (stbi_is_16_bit_from_memory(data, size)) {
    decode_16_bit(data, size, image, place);
  } else {
    const StbPixels<stbi_uc> pixels(
        stbi_load_from_memory(data, size, &width, &height, &components, 4), stbi_image_free);
    if (!pixels) fail_decoding(place);
    image.rgba_srgb8.assign(pixels.get(), pixels.get() + count);
  }
  return image;
}

Image load_image(const std::string& path) {
  const std::string bytes = read_file(path);
  Image image =
      decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path);
  image.name = path;
  return image;
}

void save_png(const std::string& path, std::span<const std::uint8_t> pixels, int width, int height,
              int components) {
  if (components != 3 && components != 4)
    throw Error(path + ": a PNG of " + std::to_string(components) +
                " components, expected 3 (RGB) or 4 (RGBA)");
  // stb computes sizes as int.
  constexpr std::int64_t max_bytes = std::int64_t{1} << 30;
  if (width < 1 || height < 1 || std::int64_t{width} * components > max_bytes / height)
    throw Error(path + ": a PNG of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels cannot be written");
  const std::int64_t expected = std::int64_t{width} * height * components;
  if (static_cast<std::uint64_t>(expected) != pixels.size())
    throw Error(path + ": a PNG of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels needs " + std::to_string(expected) + " bytes, found " +
                std::to_string(pixels.size()));
  int size = 0;
  const std::unique_ptr<unsigned char, decltype(&std::free)> png(
      stbi_write_png_to_mem(pixels.data(), width * components, width, height, components, &size),
      std::free);
  if (!png) throw Error(path + ": the PNG could not be made: out of memory");
  write_file_atomically(path,
                        {reinterpret_cast<const char*>(png.get()), static_cast<std::size_t>(size)});
}

}  // namespace omma
