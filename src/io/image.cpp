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

namespace {

// The largest piece of memory that stb may ask for, set before each image is decoded. Without it a
// PNG whose packed data are cut off makes versions before 2.29 unpack zeros up to 4 GiB.
thread_local std::size_t largest_piece = 0;

// Zeroed, so that what a broken image leaves undefined is the same every time.
void* limited_malloc(std::size_t size) {
  return size > largest_piece ? nullptr : std::calloc(1, size);
}

void* limited_realloc(void* piece, std::size_t size) {
  return size > largest_piece ? nullptr : std::realloc(piece, size);
}

}  // namespace

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
// Broken images make stb's arithmetic overflow and its copies empty, both without harm; sanitizers
// are to report the rest.
#if defined(__clang__)
#pragma clang attribute push(                                                              \
    __attribute__((no_sanitize("signed-integer-overflow", "shift", "nonnull-attribute"))), \
    apply_to = function)
#endif
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 65536
#define STBI_MALLOC limited_malloc
#define STBI_REALLOC limited_realloc
#define STBI_FREE std::free
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb_image.h>
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#if defined(__clang__)
#pragma clang attribute pop
#endif
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

// Two things that stb passes over: versions before 2.28 leave their arrays for a Huffman table of
// too many codes or one that was never defined, and a JPEG cut off within its scan decodes, its
// rest grey. So all segments are walked up to the end-of-image marker (ITU-T T.81, annex B).
struct JpegCheck {
  std::string place;
  bool progressive = false, has_scan = false;
  bool has_table[2][4] = {};  // [DC, AC][identifier]

  [[noreturn]] void fail(const char* what) const {
    throw Error(place + ": the image does not decode: " + what);
  }

  void tables(std::span<const std::uint8_t> segment) {  // B.2.4.2
    for (std::size_t at = 0; at < segment.size();) {
      std::size_t codes = 0;
      for (std::size_t i = 1; i <= 16 && at + i < segment.size(); ++i) codes += segment[at + i];
      const int kind = segment[at] >> 4, identifier = segment[at] & 15;
      if (kind > 1 || identifier > 3 || codes > 256 || at + 17 + codes > segment.size())
        fail("it has a broken Huffman table");
      has_table[kind][identifier] = true;
      at += 17 + codes;
    }
  }

  void scan(std::span<const std::uint8_t> segment) {  // B.2.3
    const std::size_t components = segment.empty() ? 0 : segment[0];
    if (segment.size() != 4 + 2 * components) fail("it has a broken scan header");
    const bool starts_at_dc = segment[1 + 2 * components] == 0;
    for (std::size_t i = 0; i < components; ++i) {
      const std::uint8_t identifiers = segment[2 + 2 * i];
      const bool has_dc = has_table[0][identifiers >> 4 & 3],
                 has_ac = has_table[1][identifiers & 3];
      if (((!progressive || starts_at_dc) && !has_dc) ||
          ((!progressive || !starts_at_dc) && !has_ac))
        fail("a scan uses a Huffman table that is not there");
    }
    has_scan = true;
  }
};

void check_jpeg(std::span<const std::uint8_t> bytes, const std::string& place) {
  JpegCheck check{place};
  for (std::size_t at = 2;;) {
    while (at < bytes.size() && bytes[at] != 0xFF) ++at;  // entropy-coded data
    while (at < bytes.size() && bytes[at] == 0xFF) ++at;  // fill bytes
    if (at == bytes.size()) break;
    const std::uint8_t marker = bytes[at++];
    const bool alone = marker <= 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    if (alone) continue;  // a byte 255 of the data, or a restart
    if (marker == 0xD9 && check.has_scan) return;
    if (at + 2 > bytes.size()) break;
    const std::size_t length =
        std::max<std::size_t>(bytes[at] * std::size_t{256} + bytes[at + 1], 2);
    if (length > bytes.size() - at) break;
    const std::span<const std::uint8_t> segment = bytes.subspan(at + 2, length - 2);
    if (marker == 0xC2) check.progressive = true;
    if (marker == 0xC4) check.tables(segment);
    if (marker == 0xDA) check.scan(segment);
    at += length;
  }
  throw Error(place + ": the image is cut off");
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

  if (jpeg) check_jpeg(bytes, place);

  Image image;
  int components = 0;
  largest_piece = std::size_t{1} << 20;
  if (!stbi_info_from_memory(data, size, &image.width, &image.height, &components))
    throw Error(place + ": the image does not decode: its header is broken or claims too much");
  check_size(bytes, image.width, image.height, png, place);
  // At most 8 bytes a pixel, twice that while unpacking; JPEGs are padded to whole blocks.
  largest_piece += 32 * (static_cast<std::size_t>(image.width) + 64) *
                       (static_cast<std::size_t>(image.height) + 64) +
                   4 * bytes.size();

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
