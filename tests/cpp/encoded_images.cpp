#include "encoded_images.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputFile.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include <jpeglib.h>

namespace omma::test {
namespace {

constexpr int width = 17, height = 11;

// Code values from 0 to 255, smooth, different in x, y and component.
int code(int x, int y, int component) {
  constexpr int step_x[] = {13, 3, 7, 5}, step_y[] = {4, 19, 9, 11};
  return x * step_x[component] + y * step_y[component];
}

template <typename Pixel>
Image image_8_bit(const Pixel& pixel) {
  Image image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int value : std::array<int, 4>(pixel(x, y)))
        image.rgba_srgb8.push_back(static_cast<std::uint8_t>(value));
  return image;
}

template <typename Pixel>
Image image_linear(const Pixel& pixel) {
  Image image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const double value : std::array<double, 4>(pixel(x, y)))
        image.rgba_linear.push_back(static_cast<float>(value));
  return image;
}

struct PngWay {
  int bits, color_type;
  bool interlaced = false, key_color = false, profile = false;
  int palette_size = 0;
};

// `row(y)`: its bytes, as PNG packs them.
template <typename Row>
std::string png_bytes(const PngWay& way, const Row& row) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, std::size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))
            ->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, width, height, way.bits, way.color_type,
               way.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (way.palette_size > 0) {
    std::vector<png_color> palette;
    std::vector<png_byte> alpha;
    for (int i = 0; i < way.palette_size; ++i) {
      const auto value = [&](int c) { return static_cast<png_byte>(code(i, i, c)); };
      palette.push_back({value(0), value(1), value(2)});
      alpha.push_back(value(3));
    }
    png_set_PLTE(png, info, palette.data(), way.palette_size);
    png_set_tRNS(png, info, alpha.data(), way.palette_size - 1, nullptr);  // the last is opaque
  }
  if (way.key_color) {
    png_color_16 key{};
    key.gray = 5;
    key.red = static_cast<png_uint_16>(code(2, 1, 0));
    key.green = static_cast<png_uint_16>(code(2, 1, 1));
    key.blue = static_cast<png_uint_16>(code(2, 1, 2));
    png_set_tRNS(png, info, nullptr, 0, &key);
  }
  if (way.profile) {
    png_set_gAMA(png, info, 1.0);  // were it heeded, all would look different
    png_set_text(
        png, info,
        std::array<png_text, 1>{{{PNG_TEXT_COMPRESSION_zTXt, const_cast<char*>("Comment"),
                                  const_cast<char*>("made by a test"), 14, 0, nullptr, nullptr}}}
            .data(),
        1);
  }
  png_write_info(png, info);
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < height; ++y) png_write_row(png, row(y).data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

// Values of a few bits, packed into bytes, the first in the highest bits.
template <typename Value>
std::vector<png_byte> packed_row(int bits, const Value& value) {
  std::vector<png_byte> row(static_cast<std::size_t>(width * bits + 7) / 8);
  for (int x = 0; x < width; ++x)
    row[static_cast<std::size_t>(x * bits / 8)] = static_cast<png_byte>(
        row[static_cast<std::size_t>(x * bits / 8)] | value(x) << (8 - bits - x * bits % 8));
  return row;
}

EncodedKind png_of_palette() {
  const auto index = [](int x, int y) { return (x + 2 * y) % 5; };
  const PngWay way{4, PNG_COLOR_TYPE_PALETTE, false, false, false, 5};
  return {"palette.png",
          png_bytes(way, [&](int y) { return packed_row(4, [&](int x) { return index(x, y); }); }),
          image_8_bit([&](int x, int y) {
            const int i = index(x, y);
            return std::array{code(i, i, 0), code(i, i, 1), code(i, i, 2),
                              i == 4 ? 255 : code(i, i, 3)};
          })};
}

EncodedKind png_of_one_bit() {
  const auto bit = [](int x, int y) { return (x * x + y) / 3 % 2; };
  return {"grey1-interlaced.png",
          png_bytes({1, PNG_COLOR_TYPE_GRAY, true},
                    [&](int y) { return packed_row(1, [&](int x) { return bit(x, y); }); }),
          image_8_bit([&](int x, int y) {
            const int grey = 255 * bit(x, y);
            return std::array{grey, grey, grey, 255};
          })};
}

EncodedKind png_of_four_bits() {
  const auto value = [](int x, int y) { return (x + y) % 16; };
  return {"grey4-key.png",
          png_bytes({4, PNG_COLOR_TYPE_GRAY, false, true},
                    [&](int y) { return packed_row(4, [&](int x) { return value(x, y); }); }),
          image_8_bit([&](int x, int y) {
            const int grey = 17 * value(x, y);
            return std::array{grey, grey, grey, value(x, y) == 5 ? 0 : 255};
          })};
}

EncodedKind png_of_rgb() {
  return {
      "rgb-key-profile.png",
      png_bytes({8, PNG_COLOR_TYPE_RGB, false, true, true},
                [](int y) {
                  std::vector<png_byte> row;
                  for (int x = 0; x < width; ++x)
                    for (int c = 0; c < 3; ++c) row.push_back(static_cast<png_byte>(code(x, y, c)));
                  return row;
                }),
      image_8_bit([](int x, int y) {
        return std::array{code(x, y, 0), code(x, y, 1), code(x, y, 2), x == 2 && y == 1 ? 0 : 255};
      })};
}

EncodedKind png_of_16_bits() {
  const auto value = [](int x, int y, int c) { return 257 * code(x, y, c) + x; };
  return {"rgba16-interlaced.png",
          png_bytes({16, PNG_COLOR_TYPE_RGB_ALPHA, true},
                    [&](int y) {
                      std::vector<png_byte> row;
                      for (int x = 0; x < width; ++x)
                        for (int c = 0; c < 4; ++c) {
                          row.push_back(static_cast<png_byte>(value(x, y, c) >> 8));
                          row.push_back(static_cast<png_byte>(value(x, y, c) & 255));
                        }
                      return row;
                    }),
          image_linear([&](int x, int y) {
            std::array<double, 4> pixel{};
            for (int c = 0; c < 4; ++c) {
              const double v = value(x, y, c) / 65535.0;
              pixel[static_cast<std::size_t>(c)] = c == 3 ? v
                                                   : v <= 0.04045
                                                       ? v / 12.92
                                                       : std::pow((v + 0.055) / 1.055, 2.4);
            }
            return pixel;
          }),
          1e-7};  // single precision
}

EncodedKind radiance_hdr_of_runs() {
  // (mantissa + 1/2) * 2^(exponent - 136), here the power is 1/256: one run and literals.
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 11 +X 17\n";
  for (int y = 0; y < height; ++y) {
    bytes += std::string("\x02\x02\0\x11", 4);
    for (int c = 0; c < 3; ++c) {
      bytes += '\x11';
      for (int x = 0; x < width; ++x) bytes += static_cast<char>(code(x, y, c));
    }
    bytes += "\x91\x80";
  }
  return {"runs.hdr", bytes, image_linear([](int x, int y) {
            const auto value = [&](int c) { return (code(x, y, c) + 0.5) / 256; };
            return std::array{value(0), value(1), value(2), 1.0};
          })};
}

class ExrStream : public Imf::OStream {
 public:
  using Position = decltype(std::declval<Imf::OStream&>().tellp());
  ExrStream() : Imf::OStream("test") {}
  void write(const char source[], int count) override {
    const auto n = static_cast<std::size_t>(count);
    bytes.resize(std::max(bytes.size(), at + n));
    std::copy_n(source, n, bytes.begin() + static_cast<std::ptrdiff_t>(at));
    at += n;
  }
  Position tellp() override { return at; }
  void seekp(Position position) override { at = static_cast<std::size_t>(position); }

  std::string bytes;
  std::size_t at = 0;
};

}  // namespace

EncodedKind jpeg_image(const std::string& name, const JpegWay& way) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = width;
  jpeg.image_height = height;
  jpeg.input_components = way.four_inks ? 4 : 3;
  jpeg.in_color_space = way.four_inks ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  for (int c = 0; c < jpeg.num_components; ++c)
    jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = c == 0 ? way.sampling : 1;
  if (way.progressive) jpeg_simple_progression(&jpeg);
  std::vector<jpeg_scan_info> scans;
  if (way.scan_each_coefficient) {
    scans.push_back({3, {0, 1, 2}, 0, 0, 0, 0});
    for (int c = 0; c < 3; ++c)
      for (int k = 1; k < 64; ++k) scans.push_back({1, {c}, k, k, 0, 0});
    jpeg.scan_info = scans.data();
    jpeg.num_scans = static_cast<int>(scans.size());
  }
  jpeg.write_Adobe_marker = way.four_inks && way.adobe_marker ? TRUE : FALSE;
  jpeg_start_compress(&jpeg, TRUE);
  // Adobe's files say how much paper is left, others how much ink there is.
  const bool ink = way.four_inks && !way.adobe_marker;
  for (int y = 0; y < height; ++y) {
    std::vector<JSAMPLE> row;
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < jpeg.input_components; ++c)
        row.push_back(static_cast<JSAMPLE>(ink ? 255 - code(x, y, c) : code(x, y, c)));
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&jpeg, &rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  EncodedKind kind{name, std::string(reinterpret_cast<char*>(bytes), size),
                   image_8_bit([&](int x, int y) {
                     std::array<int, 4> pixel{};
                     for (int c = 0; c < 3; ++c)
                       pixel[static_cast<std::size_t>(c)] =
                           way.four_inks ? code(x, y, c) * code(x, y, 3) / 255 : code(x, y, c);
                     pixel[3] = 255;
                     return pixel;
                   })};
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  // Quality 100 rounds to whole steps: in the coefficients, in Y, Cb and Cr, and in R, G and B. A
  // chroma sample of 2 x 2 pixels stands a pixel beside the last column and row, where colour
  // changes by up to 19 a pixel.
  kind.tolerance = way.sampling == 1 ? 3 : 16;
  return kind;
}

EncodedKind exr_image(const std::string& name, const ExrWay& way) {
  const Imath::Box2i window({way.first_x, 3}, {way.first_x + width - 1, 3 + height - 1});
  Imath::Box2i display = window;
  display.max.x -= way.crop_x;
  Imf::Header header(display, window);
  header.compression() = static_cast<Imf::Compression>(way.compression);
  if (way.tiled) header.setTileDescription(Imf::TileDescription(8, 4, Imf::ONE_LEVEL));
  if (!way.attribute.empty()) header.insert("text", Imf::StringAttribute(way.attribute));
  if (const auto& of = way.chromaticities; !of.empty())
    Imf::addChromaticities(header,
                           {{of[0], of[1]}, {of[2], of[3]}, {of[4], of[5]}, {of[6], of[7]}});
  const auto value = [](int x, int y, std::size_t c) {
    return std::ldexp(code(x, y, static_cast<int>(c % 4)), static_cast<int>(c) - 4);
  };
  // What the library writes is float; it makes the halves itself.
  std::vector<std::vector<float>> planes(way.channels.size());
  std::vector<std::vector<half>> halves(way.channels.size());
  Imf::FrameBuffer pixels;
  for (std::size_t c = 0; c < way.channels.size(); ++c) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) planes[c].push_back(static_cast<float>(value(x, y, c)));
    halves[c].assign(planes[c].begin(), planes[c].end());
    const Imf::PixelType type = way.half ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(way.channels[c], Imf::Channel(type));
    pixels.insert(way.channels[c], way.half ? Imf::Slice::Make(type, halves[c].data(), window)
                                            : Imf::Slice::Make(type, planes[c].data(), window));
  }
  ExrStream stream;
  if (way.tiled) {
    Imf::TiledOutputFile file(stream, header, 0);
    file.setFrameBuffer(pixels);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(pixels);
    file.writePixels(height);
  }
  const bool grey = way.channels.size() == 1;
  return {name, stream.bytes, image_linear([&](int x, int y) {
            return std::array{value(x, y, 0), value(x, y, grey ? 0 : 1), value(x, y, grey ? 0 : 2),
                              1.0};
          })};
}

std::vector<EncodedKind> images_of_every_kind() {
  return {png_of_palette(),
          png_of_one_bit(),
          png_of_four_bits(),
          png_of_rgb(),
          png_of_16_bits(),
          jpeg_image("baseline-420.jpg", {false, false, true, 2}),
          jpeg_image("progressive.jpg", {true}),
          jpeg_image("four-inks.jpg", {false, true}),
          radiance_hdr_of_runs(),
          exr_image("half-zip.exr", {{"R", "G", "B", "A"}, true, false, Imf::ZIP_COMPRESSION}),
          exr_image("float-tiles-piz.exr", {{"R", "G", "B"}, false, true, Imf::PIZ_COMPRESSION}),
          exr_image("grey-rle.exr", {{"Y"}, true, false, Imf::RLE_COMPRESSION})};
}

}  // namespace omma::test
