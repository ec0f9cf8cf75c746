// JPEG, by libjpeg-turbo: baseline and progressive, grey, colour and the CMYK of printers. Profiles
// are ignored, as glTF 2.0 (section 3.8.3) wants.
#include <cstddef>
#include <cstdio>  // jpeglib.h uses it without including it

#include <jpeglib.h>
// After the library itself.
#include <jerror.h>

#include <csetjmp>

#include "io/image_formats.h"
#include "omma/error.h"

namespace omma {
namespace {

// A file of a few kB can have so many scans over a large image that they take hours. Encoders make
// about ten.
constexpr int max_scans = 100;

// libjpeg returns from an error by a jump, so the functions that it may jump back into have nothing
// to destroy.
struct JpegReader {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr watch{};
  const WorkPart* work = nullptr;
  std::jmp_buf jump;
  char problem[JMSG_LENGTH_MAX] = "";

  JpegReader() = default;
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }

  [[noreturn]] void fail(const std::string& place) const {
    if (work != nullptr) work->reach(0);  // what it was ended for, if anything
    throw Error(place + ": the image does not decode: " + problem);
  }
};

[[noreturn]] void keep_problem(j_common_ptr jpeg) {
  auto& reader = *static_cast<JpegReader*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, reader.problem);
  std::longjmp(reader.jump, 1);
}

// libjpeg puts grey where data are missing or make no sense and calls it a warning.
void judge_message(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  switch (jpeg->err->msg_code) {
    case JWRN_ARITH_BAD_CODE:
    case JWRN_BOGUS_PROGRESSION:
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_JPEG_EOF:
    case JWRN_MUST_RESYNC:
      keep_problem(jpeg);
    default:
      break;  // odd, but all pixels are there
  }
}

void print_nothing(j_common_ptr) {}

void look_at_watch(j_common_ptr jpeg) {
  auto& reader = *static_cast<JpegReader*>(jpeg->client_data);
  const bool cancelled = reader.work->state != nullptr && reader.work->state->cancelled;
  if (!cancelled && reader.jpeg.input_scan_number <= max_scans) return;
  std::snprintf(reader.problem, sizeof reader.problem, "it has more than %d scans", max_scans);
  std::longjmp(reader.jump, 1);
}

// All up to the pixels. False where that fails; so with the functions below.
bool read_header(JpegReader& reader, EncodedImage bytes) {
  reader.jpeg.err = jpeg_std_error(&reader.errors);
  reader.jpeg.client_data = &reader;
  reader.errors.error_exit = keep_problem;
  reader.errors.emit_message = judge_message;
  reader.errors.output_message = print_nothing;
  if (setjmp(reader.jump)) return false;
  jpeg_create_decompress(&reader.jpeg);
  jpeg_mem_src(&reader.jpeg, bytes.data(), bytes.size());
  jpeg_read_header(&reader.jpeg, TRUE);
  return true;
}

bool has_four_inks(const JpegReader& reader) {
  return reader.jpeg.jpeg_color_space == JCS_CMYK || reader.jpeg.jpeg_color_space == JCS_YCCK;
}

bool start(JpegReader& reader, const WorkPart& work) {
  if (setjmp(reader.jump)) return false;
  reader.work = &work;
  reader.watch.progress_monitor = look_at_watch;
  reader.jpeg.progress = &reader.watch;
  reader.jpeg.out_color_space = has_four_inks(reader) ? JCS_CMYK : JCS_EXT_RGBA;
  jpeg_start_decompress(&reader.jpeg);
  return true;
}

bool read_row(JpegReader& reader, JSAMPROW row) {
  if (setjmp(reader.jump)) return false;
  jpeg_read_scanlines(&reader.jpeg, &row, 1);
  return true;
}

bool finish(JpegReader& reader) {
  if (setjmp(reader.jump)) return false;
  jpeg_finish_decompress(&reader.jpeg);
  return true;
}

// What is left of white paper's light. Adobe's programs, and all that follow them, store 255 for no
// ink; only a file without their marker says it the other way round.
void rgba_from_inks(std::vector<std::uint8_t>& pixels, bool stored_as_paper) {
  for (std::size_t i = 0; i < pixels.size(); i += 4) {
    int left[4];
    for (std::size_t c = 0; c < 4; ++c)
      left[c] = stored_as_paper ? pixels[i + c] : 255 - pixels[i + c];
    for (std::size_t c = 0; c < 3; ++c)
      pixels[i + c] = static_cast<std::uint8_t>((left[c] * left[3] + 127) / 255);
    pixels[i + 3] = 255;
  }
}

}  // namespace

bool is_jpeg(EncodedImage bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

ImageClaim jpeg_claim(EncodedImage bytes, const std::string& place) {
  JpegReader reader;
  if (!read_header(reader, bytes)) reader.fail(place);
  ImageClaim claim{reader.jpeg.image_width, reader.jpeg.image_height, 0, 0};
  const auto pixels = static_cast<std::uint64_t>(claim.width * claim.height);
  // Where there are several scans libjpeg holds all coefficients until the last.
  const auto components = static_cast<std::uint64_t>(reader.jpeg.num_components);
  claim.memory = pixels * (4 + (jpeg_has_multiple_scans(&reader.jpeg) ? 2 * components : 0));
  claim.most_pixels = std::uint64_t{bytes.size()} * 64 * 8;  // a bit for each block of 64
  return claim;
}

Image decode_jpeg(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  JpegReader reader;
  if (!read_header(reader, bytes) || !start(reader, work)) reader.fail(place);
  Image image;
  image.width = static_cast<int>(reader.jpeg.output_width);
  image.height = static_cast<int>(reader.jpeg.output_height);
  const std::size_t row = static_cast<std::size_t>(image.width) * 4;
  image.rgba_srgb8.resize(row * static_cast<std::size_t>(image.height));
  for (std::size_t at = 0; at < image.rgba_srgb8.size(); at += row) {
    work.reach(static_cast<double>(at) / static_cast<double>(image.rgba_srgb8.size()));
    if (!read_row(reader, &image.rgba_srgb8[at])) reader.fail(place);
  }
  if (!finish(reader)) reader.fail(place);
  if (has_four_inks(reader))
    rgba_from_inks(image.rgba_srgb8, reader.jpeg.saw_Adobe_marker != FALSE);
  return image;
}

}  // namespace omma
