// PNG in and out, by libpng. Read as glTF 2.0 (section 3.8.3) wants its images: gamma and profiles
// are ignored; grey, palettes, few bits and transparent colours all become RGBA. Of animations
// there is no one picture, so they are refused.
#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <new>

#include "io/image_formats.h"
#include "omma/error.h"

namespace omma {
namespace {

// Bytes that libpng takes or gives, and what it complains of. libpng returns from an error by a
// jump, so the functions that it may jump back into have nothing to destroy.
struct PngStream {
  EncodedImage bytes;
  std::size_t at = 0;
  std::string written = {};
  char problem[128] = "";
};

[[noreturn]] void keep_problem(png_structp png, png_const_charp message) {
  auto& stream = *static_cast<PngStream*>(png_get_error_ptr(png));
  std::strncpy(stream.problem, message, sizeof stream.problem - 1);
  png_longjmp(png, 1);
}

// A warning is of something that libpng knows how to read on from, such as bytes too many.
void pass_over(png_structp, png_const_charp) {}

void give_bytes(png_structp png, png_bytep target, std::size_t count) {
  auto& stream = *static_cast<PngStream*>(png_get_io_ptr(png));
  if (count > stream.bytes.size() - stream.at) png_error(png, "it is cut off");
  std::copy_n(stream.bytes.begin() + static_cast<std::ptrdiff_t>(stream.at), count, target);
  stream.at += count;
}

void take_bytes(png_structp png, png_bytep source, std::size_t count) {
  bool good = true;
  try {
    static_cast<PngStream*>(png_get_io_ptr(png))
        ->written.append(reinterpret_cast<const char*>(source), count);
  } catch (const std::bad_alloc&) {
    good = false;  // an exception must not pass through C
  }
  if (!good) png_error(png, "out of memory");
}

void flush_nothing(png_structp) {}

struct PngReader {
  PngStream stream;
  png_structp png = nullptr;
  png_infop info = nullptr;
  png_uint_32 width = 0, height = 0;
  int bits = 0, color_type = 0;
  bool is_animated = false;

  explicit PngReader(EncodedImage bytes) : stream{bytes} {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &stream, keep_problem, pass_over);
    if (png != nullptr) info = png_create_info_struct(png);
    if (info == nullptr) {
      png_destroy_read_struct(&png, &info, nullptr);
      throw std::bad_alloc();
    }
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }

  [[noreturn]] void fail(const std::string& place) const {
    throw Error(place + ": the image does not decode: " + stream.problem);
  }
};

// What animations have before their pixels: how many frames they are (PNG, 3rd edition, 11.3.6.1).
constexpr png_byte animation_control[] = "acTL";

bool has_frames(const png_unknown_chunk& chunk) {
  return std::memcmp(chunk.name, animation_control, 4) == 0 && chunk.size >= 4 &&
         png_get_uint_32(chunk.data) > 1;
}

// All up to the pixels. False where that fails; so with the functions below.
bool read_header(PngReader& reader) {
  png_structp png = reader.png;
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_read_fn(png, &reader.stream, give_bytes);
  // The caller judges the size; profiles, texts and times are not even unpacked.
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, animation_control, 1);
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, reader.info);
  png_get_IHDR(png, reader.info, &reader.width, &reader.height, &reader.bits, &reader.color_type,
               nullptr, nullptr, nullptr);
  png_unknown_chunkp chunks = nullptr;
  const int count = png_get_unknown_chunks(png, reader.info, &chunks);
  for (int i = 0; i < count; ++i) reader.is_animated |= has_frames(chunks[i]);
  return true;
}

// Asks for RGBA of 8 or 16 bits; how many passes over the rows it takes, 0 where that fails.
int ask_for_rgba(PngReader& reader) {
  png_structp png = reader.png;
  if (setjmp(png_jmpbuf(png))) return 0;
  png_set_expand(png);  // palettes, fewer bits than 8, transparent colours
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, 0xFFFF, PNG_FILLER_AFTER);
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, reader.info);
  return passes;
}

bool read_rows(PngReader& reader, png_bytepp rows, int count) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_read_rows(reader.png, rows, nullptr, static_cast<png_uint_32>(count));
  return true;
}

bool read_end(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_read_end(reader.png, nullptr);
  return true;
}

// Rows at a time between two looks at whether the work is to end: a few MB.
constexpr int rows_at_a_time = 64;

// IEC 61966-2-1, as glTF 2.0 refers to it.
float linear_from_srgb(double encoded) {
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92
                                               : std::pow((encoded + 0.055) / 1.055, 2.4));
}

// Converts rows of 16-bit values to floats in place: each row lies at the end of its floats'
// memory, so that writing never reaches what is still to be read.
void linear_from_16_bits(std::vector<float>& values, std::size_t row) {
  static const auto linear = [] {
    std::vector<float> table(65536);
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = linear_from_srgb(static_cast<double>(i) / 65535.0);
    return table;
  }();
  for (std::size_t first = 0; first < values.size(); first += row) {
    const char* encoded = reinterpret_cast<const char*>(&values[first]) + 2 * row;
    for (std::size_t i = 0; i < row; ++i) {
      std::uint16_t code;
      std::memcpy(&code, encoded + 2 * i, 2);
      values[first + i] = i % 4 == 3 ? static_cast<float>(code) / 65535.0f : linear[code];
    }
  }
}

struct PngWriter {
  PngStream stream;
  png_structp png = nullptr;
  png_infop info = nullptr;

  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &stream, keep_problem, pass_over);
    if (png != nullptr) info = png_create_info_struct(png);
    if (info == nullptr) {
      png_destroy_write_struct(&png, &info);
      throw std::bad_alloc();
    }
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

// zlib's: half the time of its default.
constexpr int quick_level = 3;

bool write_header(PngWriter& writer, int width, int height, int components, PngPacking packing) {
  png_structp png = writer.png;
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_write_fn(png, &writer.stream, take_bytes, flush_nothing);
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_IHDR(png, writer.info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               8, components == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (packing == PngPacking::quick) {
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
    png_set_compression_level(png, quick_level);
  }
  png_write_info(png, writer.info);
  return true;
}

bool write_row(PngWriter& writer, const std::uint8_t* row) {
  if (setjmp(png_jmpbuf(writer.png))) return false;
  png_write_row(writer.png, row);
  return true;
}

bool write_end(PngWriter& writer) {
  if (setjmp(png_jmpbuf(writer.png))) return false;
  png_write_end(writer.png, nullptr);
  return true;
}

}  // namespace

bool is_png(EncodedImage bytes) {
  constexpr std::array<std::uint8_t, 8> signature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  return bytes.size() >= signature.size() &&
         std::equal(signature.begin(), signature.end(), bytes.begin());
}

ImageClaim png_claim(EncodedImage bytes, const std::string& place) {
  PngReader reader(bytes);
  if (!read_header(reader)) reader.fail(place);
  if (reader.is_animated)
    throw Error(place + ": the image is a PNG animation, expected one picture");
  const std::uint64_t pixel_bytes = reader.bits == 16 ? 4 * sizeof(float) : 4;
  // Deflate packs at most 1032 bytes into one, and a byte of a PNG holds at most 8 pixels.
  return {reader.width, reader.height, std::uint64_t{reader.width} * reader.height * pixel_bytes,
          std::uint64_t{bytes.size()} * 1032 * 8};
}

Image decode_png(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  PngReader reader(bytes);
  if (!read_header(reader)) reader.fail(place);
  const int passes = ask_for_rgba(reader);
  if (passes == 0) reader.fail(place);
  Image image;
  image.width = static_cast<int>(reader.width);
  image.height = static_cast<int>(reader.height);
  const std::size_t row = std::size_t{reader.width} * 4;
  const bool sixteen = reader.bits == 16;
  if (sixteen)
    image.rgba_linear.resize(row * reader.height);
  else
    image.rgba_srgb8.resize(row * reader.height);
  std::vector<png_bytep> rows(reader.height);
  for (std::size_t y = 0; y < rows.size(); ++y)
    rows[y] = sixteen ? reinterpret_cast<png_bytep>(&image.rgba_linear[y * row]) + 2 * row
                      : &image.rgba_srgb8[y * row];
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < image.height; y += rows_at_a_time) {
      work.reach((pass + static_cast<double>(y) / image.height) / passes);
      if (!read_rows(reader, &rows[static_cast<std::size_t>(y)],
                     std::min(rows_at_a_time, image.height - y)))
        reader.fail(place);
    }
  if (!read_end(reader)) reader.fail(place);
  if (sixteen) linear_from_16_bits(image.rgba_linear, row);
  return image;
}

std::string encode_png(std::span<const std::uint8_t> pixels, int width, int height, int components,
                       PngPacking packing, const std::string& place, const WorkPart& work) {
  PngWriter writer;
  bool good = write_header(writer, width, height, components, packing);
  const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(components);
  for (int y = 0; good && y < height; ++y) {
    work.reach(static_cast<double>(y) / height);
    good = write_row(writer, pixels.data() + static_cast<std::size_t>(y) * row);
  }
  if (!good || !write_end(writer))
    throw Error(place + ": the PNG could not be made: " + writer.stream.problem);
  return std::move(writer.stream.written);
}

}  // namespace omma
