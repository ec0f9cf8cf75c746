// OpenEXR pictures (.exr), by OpenEXR's own library: scanlines or tiles, half, float or whole
// numbers, any compression; colour or grey. The first part of a file that has several; level 0 of
// tiles. Colour is light as it is: alpha is not used, since colour is premultiplied with it.
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfTileDescription.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "io/image_formats.h"
#include "omma/error.h"

namespace omma {
namespace {

using StreamPosition = decltype(std::declval<Imf::IStream&>().tellg());

class MemoryStream : public Imf::IStream {
 public:
  explicit MemoryStream(EncodedImage bytes) : Imf::IStream("it"), bytes_(bytes) {}
  bool read(char target[], int count) override {
    if (count < 0 || static_cast<std::size_t>(count) > bytes_.size() - at_)
      throw std::runtime_error("it is cut off");
    std::memcpy(target, bytes_.data() + at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::size_t>(count);
    return at_ < bytes_.size();
  }
  StreamPosition tellg() override { return at_; }
  void seekg(StreamPosition position) override {
    if (position > bytes_.size()) throw std::runtime_error("it is cut off");
    at_ = static_cast<std::size_t>(position);
  }

 private:
  EncodedImage bytes_;
  std::size_t at_ = 0;
};

// OpenEXR 3.1 asks for as much memory as an attribute claims before it reads it. So the headers are
// walked through first: attributes of name, type, size and value, ended by a name of no letters; in
// a file of several parts an empty header ends them.
void check_attributes(EncodedImage bytes, const std::string& place) {
  std::size_t at = 8;
  const auto pass_text = [&] {
    while (at < bytes.size() && bytes[at] != 0) ++at;
    ++at;
  };
  const bool multipart = bytes.size() >= 8 && (bytes[5] & 0x10) != 0;
  for (bool in_header = false; at < bytes.size();) {
    if (bytes[at] == 0) {
      if (!multipart || !in_header) return;
      in_header = false;
      ++at;
      continue;
    }
    in_header = true;
    pass_text();
    pass_text();
    if (at + 4 > bytes.size()) break;
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < 4; ++i) size |= std::uint32_t{bytes[at + i]} << (8 * i);
    at += 4;
    if (size > bytes.size() - at) break;
    at += size;
  }
  throw Error(place + ": the image is cut off in its header");
}

// Runs `work` with what OpenEXR throws as an omma::Error.
template <typename Work>
auto with_errors_of(const std::string& place, const Work& work) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const Cancelled&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    throw Error(place + ": the image does not decode: " + problem.what());
  }
}

std::string text(const Imath::Box2i& window) {
  return std::to_string(window.min.x) + " " + std::to_string(window.min.y) + " to " +
         std::to_string(window.max.x) + " " + std::to_string(window.max.y);
}

// Pixels from one side of a window to the other.
std::int64_t extent(int first, int last) {
  return std::int64_t{last} - first + 1;
}

// Where the file's channels go in RGBA; grey goes to R first.
std::array<const char*, 3> colour_channels(const Imf::Header& header, const std::string& place) {
  const Imf::ChannelList& channels = header.channels();
  const auto whole = [&](const char* name) {
    const Imf::Channel* channel = channels.findChannel(name);
    return channel != nullptr && channel->xSampling == 1 && channel->ySampling == 1;
  };
  if (whole("R") && whole("G") && whole("B")) return {"R", "G", "B"};
  if (whole("Y") && channels.findChannel("RY") == nullptr) return {"Y", nullptr, nullptr};
  std::string found;
  for (auto c = channels.begin(); c != channels.end(); ++c)
    found += (found.empty() ? "" : ", ") + std::string(c.name());
  throw Error(place + ": expected channels R, G and B, or Y alone for grey, one value a pixel; " +
              "found " + (found.empty() ? "none" : found));
}

ImageClaim claim_of(const Imf::Header& header) {
  const Imath::Box2i window = header.dataWindow();
  ImageClaim claim;
  claim.width = extent(window.min.x, window.max.x);
  claim.height = extent(window.min.y, window.max.y);
  claim.most_pixels = std::numeric_limits<std::uint64_t>::max();  // flat ones pack to nothing
  if (claim.width < 1 || claim.height < 1) return claim;
  // What is unpacked at once has all channels: tiles, or up to 256 lines (DWAB).
  std::uint64_t channels = 0;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) ++channels;
  const auto width = static_cast<std::uint64_t>(claim.width),
             height = static_cast<std::uint64_t>(claim.height);
  std::uint64_t unpacked = width * std::min<std::uint64_t>(height, 256);
  if (header.hasTileDescription()) {
    const Imf::TileDescription& tiles = header.tileDescription();
    unpacked = std::max(width, std::uint64_t{tiles.xSize}) * tiles.ySize;
  }
  // Windows have less than 2^32 each way, so this may overflow; a double says so.
  const double memory = 16.0 * static_cast<double>(width) * static_cast<double>(height) +
                        8.0 * static_cast<double>(channels) * static_cast<double>(unpacked);
  claim.memory = memory < 1e18 ? static_cast<std::uint64_t>(memory)
                               : std::numeric_limits<std::uint64_t>::max();
  return claim;
}

}  // namespace

ImageClaim openexr_claim(EncodedImage bytes, const std::string& place) {
  check_attributes(bytes, place);
  return with_errors_of(place, [&] {
    MemoryStream stream(bytes);
    const Imf::MultiPartInputFile file(stream, 0);
    return claim_of(file.header(0));
  });
}

Image decode_openexr(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  check_attributes(bytes, place);
  return with_errors_of(place, [&] {
    MemoryStream stream(bytes);
    Imf::MultiPartInputFile file(stream, 0);
    const Imf::Header& header = file.header(0);
    if (header.hasType() && Imf::isDeepData(header.type()))
      throw Error(place + ": expected a flat image, found deep data");
    const Imath::Box2i window = header.dataWindow();
    if (window != header.displayWindow())
      throw Error(place + ": expected pixels for all of its display window (" +
                  text(header.displayWindow()) + "), found its data window " + text(window));
    const std::array<const char*, 3> channels = colour_channels(header, place);
    if (channels[1] != nullptr && Imf::hasChromaticities(header)) {
      const Imf::Chromaticities& of = Imf::chromaticities(header);
      check_primaries({of.red.x, of.red.y, of.green.x, of.green.y, of.blue.x, of.blue.y, of.white.x,
                       of.white.y},
                      place);
    }

    Image image;
    image.width = static_cast<int>(extent(window.min.x, window.max.x));
    image.height = static_cast<int>(extent(window.min.y, window.max.y));
    const std::size_t row = static_cast<std::size_t>(image.width) * 4;
    image.rgba_linear.resize(row * static_cast<std::size_t>(image.height), 1.0f);
    Imf::FrameBuffer target;
    for (std::size_t c = 0; c < 3; ++c)
      if (channels[c] != nullptr)
        target.insert(channels[c],
                      Imf::Slice::Make(Imf::FLOAT, image.rgba_linear.data() + c, window,
                                       4 * sizeof(float), row * sizeof(float)));
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(target);
    constexpr int lines_at_a_time = 256;
    for (int y = 0; y < image.height; y += lines_at_a_time) {
      work.reach(static_cast<double>(y) / image.height);
      part.readPixels(window.min.y + y,
                      window.min.y + std::min(y + lines_at_a_time, image.height) - 1);
    }
    if (channels[1] == nullptr)
      for (std::size_t i = 0; i < image.rgba_linear.size(); i += 4)
        image.rgba_linear[i + 1] = image.rgba_linear[i + 2] = image.rgba_linear[i];
    return image;
  });
}

}  // namespace omma
