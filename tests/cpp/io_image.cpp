// Images: PNG, JPEG, Radiance HDR and OpenEXR of every kind, and those that are broken; whole files
// written at once.
#include <array>
#include <cmath>
#include <random>

#include "encoded_images.h"
#include "gltf_builder.h"
#include "io/atomic_file.h"
#include "io/image.h"

namespace omma::test {
namespace {

std::span<const std::uint8_t> bytes_in(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Image decode(const std::string& bytes) {
  return decode_image(bytes_in(bytes), "place");
}

template <typename Work>
void expect_cancelled(const Work& work) {
  EXPECT_THROW(work(), Cancelled);
}

using Bytes = std::vector<std::uint8_t>;

void expect_as(const Image& image, const EncodedKind& kind) {
  EXPECT_EQ(image.width, kind.expected.width);
  EXPECT_EQ(image.height, kind.expected.height);
  ASSERT_EQ(image.rgba_srgb8.size(), kind.expected.rgba_srgb8.size());
  ASSERT_EQ(image.rgba_linear.size(), kind.expected.rgba_linear.size());
  for (std::size_t i = 0; i < image.rgba_srgb8.size(); ++i)
    ASSERT_NEAR(image.rgba_srgb8[i], kind.expected.rgba_srgb8[i], kind.tolerance) << i;
  for (std::size_t i = 0; i < image.rgba_linear.size(); ++i)
    ASSERT_NEAR(image.rgba_linear[i], kind.expected.rgba_linear[i], kind.tolerance) << i;
}

TEST(Image, PngOf8Bits) {
  EXPECT_EQ(decode(png<std::uint8_t>(1, 1, 1, {7})).rgba_srgb8, (Bytes{7, 7, 7, 255}));
  EXPECT_EQ(decode(png<std::uint8_t>(1, 1, 2, {7, 8})).rgba_srgb8, (Bytes{7, 7, 7, 8}));
  EXPECT_EQ(decode(png<std::uint8_t>(1, 1, 3, {7, 8, 9})).rgba_srgb8, (Bytes{7, 8, 9, 255}));
  EXPECT_EQ(decode(png<std::uint8_t>(1, 1, 4, {7, 8, 9, 10})).rgba_srgb8, (Bytes{7, 8, 9, 10}));
  const Image two = decode(png<std::uint8_t>(2, 1, 1, {1, 2}));
  EXPECT_EQ(two.width, 2);
  EXPECT_EQ(two.height, 1);
  EXPECT_EQ(two.rgba_srgb8, (Bytes{1, 1, 1, 255, 2, 2, 2, 255}));
  EXPECT_EQ(decode(png<std::uint8_t>(1, 2, 1, {1, 2})).rgba_srgb8[4], 2);  // row 0 is first
}

TEST(Image, PngOf16Bits) {
  // IEC 61966-2-1 of 13107/65535 = 0.2: ((0.2 + 0.055) / 1.055)^2.4; 1285/65535 is on its
  // straight part. Single precision.
  const float dark = 1285.0f / 65535.0f / 12.92f, mid = 0.0331048f;
  const auto expect_pixel = [](const Image& image, const std::array<float, 4>& expected) {
    EXPECT_TRUE(image.rgba_srgb8.empty());
    ASSERT_EQ(image.rgba_linear.size(), 4u);
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(image.rgba_linear[c], expected[c], 1e-7) << c;
  };
  expect_pixel(decode(png<std::uint16_t>(1, 1, 1, {13107})), {mid, mid, mid, 1});
  expect_pixel(decode(png<std::uint16_t>(1, 1, 2, {13107, 13107})), {mid, mid, mid, 0.2f});
  expect_pixel(decode(png<std::uint16_t>(1, 1, 3, {0, 1285, 65535})), {0, dark, 1, 1});
  expect_pixel(decode(png<std::uint16_t>(1, 1, 4, {13107, 0, 1285, 0})), {mid, 0, dark, 0});
}

TEST(Image, Jpeg) {
  const Image color = decode(color_jpeg()), grey = decode(grey_jpeg());
  EXPECT_EQ(color.width, 8);
  EXPECT_EQ(color.height, 8);
  for (std::size_t i = 0; i < 256; i += 4) {
    EXPECT_NEAR(color.rgba_srgb8[i], 200, 1);  // the transform rounds
    EXPECT_NEAR(color.rgba_srgb8[i + 1], 100, 1);
    EXPECT_NEAR(color.rgba_srgb8[i + 2], 50, 1);
    EXPECT_EQ(color.rgba_srgb8[i + 3], 255);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(grey.rgba_srgb8[i + c], 160);
  }
}

std::string hdr(const std::string& size, const std::string& pixels) {
  return "#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + pixels;
}

TEST(Image, RadianceHdr) {
  // value = (mantissa + 1/2) * 2^(exponent - 136)
  const Image plain = decode(hdr("-Y 1 +X 2", std::string("\x80\x40\x20\x81\x01\x02\x03\x00", 8)));
  EXPECT_EQ(plain.rgba_linear,
            (std::vector<float>{257 / 256.0f, 129 / 256.0f, 65 / 256.0f, 1, 0, 0, 0, 1}));
  // Run-length encoded, 8 pixels: a run of 8, a literal of 8, runs of 3 and 5, a run of 8.
  std::string packed("\x02\x02\x00\x08", 4);
  packed += "\x88\x80";
  packed += std::string("\x08\x00\x10\x20\x30\x40\x50\x60\x70", 9);
  packed += std::string("\x83\x00\x85\x80", 4);
  packed += "\x88\x82";
  const Image runs = decode(hdr("-Y 1 +X 8", packed));
  ASSERT_EQ(runs.rgba_linear.size(), 32u);
  EXPECT_EQ(runs.rgba_linear[4 * 7], 257 / 128.0f);
  EXPECT_EQ(runs.rgba_linear[4 * 7 + 1], 225 / 128.0f);
  EXPECT_EQ(runs.rgba_linear[4 * 2 + 2], 1 / 128.0f);
  EXPECT_EQ(runs.rgba_linear[4 * 3 + 2], 257 / 128.0f);
  expect_error([&] { decode(hdr("-Y 2 +X 8", packed)); }, {"place", "cut off"});
  expect_error([&] { decode(hdr("-Y 1 +X 8", packed.substr(0, 9))); }, {"place", "cut off"});
  packed[4] = '\x89';
  expect_error([&] { decode(hdr("-Y 1 +X 8", packed)); }, {"place", "does not decode"});
  expect_error([&] { decode(hdr("-Y 99999 +X 99999", packed)); }, {"place", "99999 x 99999"});
  expect_error([&] { decode(hdr("+X 8 -Y 1", packed)); }, {"place", "size"});
  // What a program multiplied all radiances by, once or more, is divided by.
  const std::string one("\x80\x40\x20\x81", 4), head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";
  const auto exposed = [&](const std::string& lines) {
    return decode(head + lines + "\n-Y 1 +X 1\n" + one).rgba_linear[0];
  };
  EXPECT_FLOAT_EQ(exposed("EXPOSURE=0.25\n"), 4 * exposed(""));
  EXPECT_FLOAT_EQ(exposed("EXPOSURE= 2\nEXPOSURE=4\n"), exposed("") / 8);
  for (const char* bad : {"EXPOSURE=\n", "EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n"})
    expect_error([&] { exposed(bad); }, {"place", "EXPOSURE"});
  // Colours one by one too, whatever the exposure.
  const Image red = decode(head + "COLORCORR=2 1 4\nEXPOSURE=2\n\n-Y 1 +X 1\n" + one);
  EXPECT_EQ(red.rgba_linear, (std::vector<float>{257 / 1024.0f, 129 / 512.0f, 65 / 2048.0f, 1}));
  for (const char* bad : {"COLORCORR=1 1\n", "COLORCORR=1 0 1\n", "PRIMARIES=1 2\n"})
    expect_error([&] { exposed(bad); }, {"place", std::string(bad).substr(0, 8)});
  // Of the primaries only sRGB's, and Radiance's own, which are nearly these.
  EXPECT_FLOAT_EQ(exposed("PRIMARIES=.64 .33 .29 .6 .15 .06 .333 .333\n"), exposed(""));
  const char* aces = "PRIMARIES=0.713 0.293 0.165 0.83 0.128 0.044 0.32168 0.33767\n";
  expect_error([&] { exposed(aces); }, {"place", "0.713", "sRGB"});
  expect_error([&] { decode("#?RADIANCE\nFORMAT=x\n\n-Y 1 +X 1\nabcd"); }, {"place", "FORMAT"});
}

// Written as Radiance writes it (Ward 1991, `setcolr`): mantissas are cut off, which must not make
// pictures darker.
TEST(Image, RadianceHdrKeepsMeans) {
  constexpr int width = 7, height = 1000;  // narrower than 8: plain
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  std::string pixels;
  std::vector<double> truth;
  for (int i = 0; i < width * height; ++i) {
    const std::array value{std::exp(8 * uniform(random) - 4), uniform(random), uniform(random)};
    int exponent = 0;
    std::frexp(std::max({value[0], value[1], value[2]}), &exponent);
    for (const double v : value) {
      pixels += static_cast<char>(static_cast<int>(std::ldexp(v, 8 - exponent)));
      truth.push_back(v);
    }
    pixels += static_cast<char>(exponent + 128);
  }
  const Image image = decode(hdr("-Y 1000 +X 7", pixels));
  for (std::size_t c = 0; c < 3; ++c) {
    // Half a step of a pixel, s, is s / sqrt(3) off; a mean of n of these off by more than four of
    // its standard errors once in 16,000 times. Without the half it is off by a whole half step.
    double off = 0, half_steps = 0, squares = 0;
    for (std::size_t i = 0; i < truth.size() / 3; ++i) {
      off += static_cast<double>(image.rgba_linear[4 * i + c]) - truth[3 * i + c];
      const double half_step = std::ldexp(0.5, static_cast<std::uint8_t>(pixels[4 * i + 3]) - 136);
      half_steps += half_step;
      squares += half_step * half_step / 3;
    }
    EXPECT_LT(std::fabs(off), 4 * std::sqrt(squares));
    EXPECT_LT(4 * std::sqrt(squares), half_steps / 2);  // so that it could be seen
  }
}

TEST(Image, TruncationsAreErrors) {
  Bytes noise(16 * 16 * 3);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint8_t>(i * 97);
  const std::string png_bytes = png<std::uint8_t>(16, 16, 3, noise);
  for (std::size_t size = 0; size < png_bytes.size(); ++size)
    expect_error([&] { decode(png_bytes.substr(0, size)); }, {"place"});
  const std::string jpeg_bytes = color_jpeg();
  for (std::size_t size = 0; size < jpeg_bytes.size(); ++size)
    expect_error([&] { decode(jpeg_bytes.substr(0, size)); }, {"place"});
}

// The same with another size in its header.
std::string with_size(const std::string& png, std::uint32_t width, std::uint32_t height) {
  const std::string header =
      big_endian_u32(width) + big_endian_u32(height) + png.substr(24, 5);  // 13 bytes from 16 on
  return png.substr(0, 8) + png_chunk("IHDR", header) + png.substr(33);
}

TEST(Image, ClaimsOfSizeDoNotAllocate) {
  const std::string one = png<std::uint8_t>(1, 1, 1, {0});
  const auto expect_refused = [&](std::uint32_t width, std::uint32_t height,
                                  const std::vector<std::string>& parts) {
    expect_error([&] { decode(with_size(one, width, height)); }, parts);
  };
  expect_refused(70000, 60, {"place", "70000 x 60", "at most 65536 each way"});
  expect_refused(60000, 60000, {"place", "60000 x 60000", "too large"});
  expect_refused(20000, 20000, {"place", "20000 x 20000", "too large"});
  expect_refused(10000, 10000, {"place", "10000 x 10000", "can hold"});
  expect_refused(0xFFFFFFFF, 0xFFFFFFFF, {"place", "does not decode"});
  expect_refused(0, 1, {"place", "does not decode"});
}

// As animations begin: how many frames, and how often they are played.
std::string with_frames(const std::string& png, std::uint32_t frames) {
  const std::string control = png_chunk("acTL", big_endian_u32(frames) + big_endian_u32(0));
  return png.substr(0, 33) + control + png.substr(33);
}

TEST(Image, WhatIsNoOnePictureIsRefusedByName) {
  const std::string one = png<std::uint8_t>(1, 1, 1, {7});
  EXPECT_EQ(decode(with_frames(one, 1)).rgba_srgb8, decode(one).rgba_srgb8);
  expect_error([&] { decode(with_frames(one, 3)); }, {"place", "PNG animation", "one picture"});
  expect_error([] { decode("GIF89a and so on"); }, {"place", "a GIF", "expected PNG"});
  expect_error([] { decode("BM and so on"); }, {"place", "a BMP", "expected PNG"});
  const std::string counts("\0*", 2);
  expect_error([&] { decode("MM" + counts); }, {"place", "a TIFF", "expected PNG"});
  expect_error([] { decode(std::string("II*\0", 4)); }, {"place", "a TIFF", "expected PNG"});
  expect_error([] { decode("BGIF8"); }, {"place", "is not an image"});
}

TEST(Image, EveryKind) {
  for (const EncodedKind& kind : images_of_every_kind()) {
    SCOPED_TRACE(kind.name);
    expect_as(decode(kind.bytes), kind);
    // Those that the fuzzers start from, whatever versions of the libraries made them.
    expect_as(load_image(OMMA_SEEDS "/image/" + kind.name), kind);
  }
}

// Whatever comes of it, it is an image or an omma::Error, and nothing is printed.
TEST(Image, EveryKindCutOffAndBroken) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const EncodedKind& kind : images_of_every_kind()) {
    SCOPED_TRACE(kind.name);
    for (std::size_t size = 0; size < kind.bytes.size(); ++size)
      expect_error([&] { decode(kind.bytes.substr(0, size)); }, {"place"});
    std::size_t refused = 0;
    for (std::size_t at = 0; at < kind.bytes.size(); ++at)
      for (const int flipped : {1, 0x80, 0xFF}) {
        std::string bytes = kind.bytes;
        bytes[at] = static_cast<char>(bytes[at] ^ flipped);
        try {
          decode(bytes);
        } catch (const Error& error) {
          EXPECT_TRUE(std::string(error.what()).starts_with("place: ")) << error.what();
          ++refused;
        }
      }
    EXPECT_GT(refused, 0u);
    // All of a PNG is under checksums, its signature tells what it is.
    if (kind.name.ends_with(".png")) {
      EXPECT_EQ(refused, 3 * kind.bytes.size());
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Image, JpegsOfOtherKinds) {
  for (const EncodedKind& kind :
       {jpeg_image("whole chroma", {}), jpeg_image("progressive, 4:2:0", {true, false, true, 2}),
        jpeg_image("ink", {false, true, false}), jpeg_image("progressive ink", {true, true})}) {
    SCOPED_TRACE(kind.name);
    expect_as(decode(kind.bytes), kind);
  }
}

TEST(Image, JpegOfTooManyScans) {
  // A scan for each coefficient of each component; over a large image, each takes its time.
  JpegWay way{true};
  way.scan_each_coefficient = true;
  expect_error([&] { decode(jpeg_image("", way).bytes); }, {"place", "100 scans"});
}

TEST(Image, OpenExrOfEveryCompression) {
  // None, RLE, ZIP by line and by 16, PIZ: those that keep all bits.
  for (int compression = 0; compression <= 4; ++compression)
    for (const bool half : {false, true})
      for (const bool tiled : {false, true}) {
        SCOPED_TRACE(compression);
        const EncodedKind kind = exr_image("", {{"R", "G", "B"}, half, tiled, compression, -5});
        expect_as(decode(kind.bytes), kind);
      }
}

TEST(Image, OpenExrThatIsNoPanorama) {
  const auto decode_exr = [](const ExrWay& way) { decode(exr_image("", way).bytes); };
  expect_error([&] { decode_exr({{"R", "G"}}); }, {"place", "R, G and B", "found G, R"});
  expect_error([&] { decode_exr({{"Z"}}); }, {"place", "R, G and B", "found Z"});
  expect_error([&] { decode_exr({{"Y", "RY", "BY"}}); }, {"place", "found BY, RY, Y"});
  ExrWay wide;
  wide.chromaticities = {0.713f, 0.293f, 0.165f,   0.83f,
                         0.128f, 0.044f, 0.32168f, 0.33767f};  // ACES
  expect_error([&] { decode_exr(wide); }, {"place", "0.713", "sRGB"});
  wide.channels = {"Y"};  // greys have no colour
  decode_exr(wide);
  wide = {};
  wide.chromaticities = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
  decode_exr(wide);
  ExrWay cropped;
  cropped.crop_x = 4;
  expect_error([&] { decode_exr(cropped); },
               {"place", "display window (0 3 to 12 13)", "data window 0 3 to 16 13"});
}

TEST(Image, OpenExrClaimsDoNotAllocate) {
  ExrWay way;
  way.attribute = "words";
  way.tiled = true;
  const std::string bytes = exr_image("", way).bytes;
  // With other bytes from `skip` behind the name and type of an attribute on.
  const auto with = [&](std::string claim, const std::string& attribute, std::size_t skip,
                        const std::string& value) {
    return claim.replace(claim.find(attribute) + attribute.size() + skip, value.size(), value);
  };
  // 2 GiB of text, and of something that the library does not know.
  const std::string huge = little_endian_u32(0x7FFFFFF0);
  const std::string text("text\0string\0", 12);
  const std::string claim = with(bytes, text, 0, huge);
  expect_error([&] { decode(claim); }, {"place", "cut off in its header"});
  expect_error([&] { decode(with(claim, std::string("text\0", 5), 0, "S")); },
               {"place", "cut off in its header"});
  const std::string tiles("tiles\0tiledesc\0", 15);
  expect_error(
      [&] { decode(with(bytes, tiles, 4, little_endian_u32(8191) + little_endian_u32(8191))); },
      {"place", "17 x 11", "need 16", "are expected"});
  std::string large = bytes;
  const std::string corner = little_endian_u32(15999) + little_endian_u32(15999);
  for (const char* window : {"dataWindow", "displayWindow"})
    large = with(large, std::string(window) + '\0' + "box2i" + '\0', 4 + 8, corner);
  expect_error([&] { decode(large); }, {"place"});
}

TEST(Image, BrokenJpegTables) {
  // Tables of 16 x 255 codes, which some decoders write past their array for.
  std::string bad = grey_jpeg();
  bad.replace(bad.find("\xFF\xC4") + 5, 16, std::string(16, '\xFF'));
  expect_error([&] { decode(bad); }, {"place", "does not decode", "Huffman table"});
}

TEST(Image, PackedDataThatUnpackForever) {
  // A packed stream of literals that ends without an end: some decoders go on with zeros.
  std::string bytes = png<std::uint16_t>(4, 4, 4, std::vector<std::uint16_t>(64));
  const std::size_t data = bytes.find("IDAT") + 4;
  bytes.replace(data + 2, 3, std::string("\x63\x60\x60", 3));
  expect_error([&] { decode(bytes.substr(0, data + 5)); }, {"place"});
  expect_error([&] { decode(bytes); }, {"place"});
}

TEST(Image, WhatIsNone) {
  expect_error([] { decode(""); }, {"place", "PNG"});
  expect_error([] { decode("GIF89a"); }, {"place", "PNG"});
  expect_error([] { decode("\xFF\xD8\xFF"); }, {"place"});
}

TEST(Image, Files) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "picture.png").string();
  const Bytes rgb = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};
  save_png(path, rgb, 3, 2, 3);
  const Image image = load_image(path);
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.rgba_srgb8[4], 4);
  EXPECT_EQ(image.rgba_srgb8[4 * 5 + 2], 18);
  save_png(path, Bytes{1, 2, 3, 4}, 1, 1, 4);  // over the old one
  EXPECT_EQ(load_image(path).rgba_srgb8, (Bytes{1, 2, 3, 4}));
  expect_error([&] { save_png(path, rgb, 3, 3, 3); }, {path, "needs 27 bytes, found 18"});
  expect_error([&] { save_png(path, rgb, 18, 1, 1); }, {path, "components"});
  expect_error([&] { save_png(path, rgb, 0, 1, 3); }, {path, "0 x 1"});
  expect_error([&] { save_png(path, rgb, 1 << 30, 1 << 30, 3); }, {path});
  expect_error([&] { load_image((folder.path / "none.png").string()); },
               {"none.png", "no such file"});
}

TEST(Image, PngsThatAreNotWanted) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "picture.png").string();
  const Bytes pixels(64 * 64 * 3);
  save_png(path, Bytes{1, 2, 3}, 1, 1, 3);
  expect_cancelled([&] { save_png(path, pixels, 64, 64, 3, [](double) { return false; }); });
  EXPECT_EQ(load_image(path).width, 1);  // the old one
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
  expect_cancelled([&] { load_image(path, [](double) { return false; }); });
  // Before the first rows are coded and decoded it is looked at.
  WorkState ended;
  ended.cancelled = true;
  expect_cancelled([&] { encode_png(pixels, 64, 64, 3, PngPacking::small, path, {&ended}); });
  for (const EncodedKind& kind : images_of_every_kind()) {
    SCOPED_TRACE(kind.name);
    expect_cancelled([&] { decode_claimed_image(bytes_in(kind.bytes), "place", {&ended}); });
  }
}

TEST(AtomicFile, NothingHalfWrittenIsLeft) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "out.bin").string();
  const std::string bytes("a\0b\n", 4);
  write_file_atomically(path, bytes);
  EXPECT_EQ(read_file(path), bytes);
  write_file_atomically(path, std::string("other"));
  EXPECT_EQ(read_file(path), "other");
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(folder.path), {});
  };
  EXPECT_EQ(files(), 1);  // no temporary file is left
  const std::string in_none = (folder.path / "none/out.bin").string();
  expect_error([&] { write_file_atomically(in_none, bytes); }, {in_none, "cannot be written"});
  expect_error([&] { write_file_atomically(folder.path.string(), bytes); },
               {folder.path.string(), "directory"});
  expect_error([&] { write_file_atomically("/dev/null", bytes); }, {"/dev/null", "regular"});
  expect_error([&] { write_file_atomically("", bytes); }, {"file"});
  EXPECT_EQ(files(), 1);
}

TEST(AtomicFile, FollowsLinks) {
  const TemporaryFolder folder;
  const std::string target = folder.write("target.bin", "old"),
                    link = (folder.path / "link").string();
  std::filesystem::create_symlink(target, link);
  write_file_atomically(link, std::string("new"));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(read_file(target), "new");
}

}  // namespace
}  // namespace omma::test
