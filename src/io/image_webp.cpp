// WebP in, by libwebp: glTF files have it with EXT_texture_webp. Colours are sRGB, as those of PNG;
// profiles are ignored. Of animations there is no one picture, so they are refused.
#include <webp/decode.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "io/image_formats.h"
#include "omma/error.h"

namespace omma {
namespace {

[[noreturn]] void fail(const std::string& place, VP8StatusCode status) {
  const bool cut_off = status == VP8_STATUS_SUSPENDED || status == VP8_STATUS_NOT_ENOUGH_DATA;
  const char* why = cut_off                                  ? "it is cut off"
                    : status == VP8_STATUS_OUT_OF_MEMORY     ? "out of memory"
                    : status == VP8_STATUS_UNSUPPORTED_FEATURE ? "it has what is not supported"
                                                             : "it is damaged";
  throw Error(place + ": the image does not decode: " + why);
}

WebPBitstreamFeatures features_of(EncodedImage bytes, const std::string& place) {
  WebPBitstreamFeatures features;
  const VP8StatusCode status = WebPGetFeatures(bytes.data(), bytes.size(), &features);
  if (status != VP8_STATUS_OK) fail(place, status);
  if (features.has_animation)
    throw Error(place + ": the image is a WebP animation, expected one picture");
  return features;
}

// Between two looks at whether the work is to end.
constexpr std::size_t bytes_at_a_time = 1 << 16;

}  // namespace

bool is_webp(EncodedImage bytes) {
  constexpr std::uint8_t riff[] = {'R', 'I', 'F', 'F'}, webp[] = {'W', 'E', 'B', 'P'};
  return bytes.size() >= 12 && std::equal(riff, riff + 4, bytes.begin()) &&
         std::equal(webp, webp + 4, bytes.begin() + 8);
}

ImageClaim webp_claim(EncodedImage bytes, const std::string& place) {
  const WebPBitstreamFeatures features = features_of(bytes, place);
  const auto pixels = static_cast<std::uint64_t>(features.width) *
                      static_cast<std::uint64_t>(features.height);
  // What is without loss is decoded into memory of its own first. An even picture has hardly a byte,
  // whatever its size.
  return {features.width, features.height, pixels * (features.format == 2 ? 8 : 4),
          std::numeric_limits<std::uint64_t>::max()};
}

Image decode_webp(EncodedImage bytes, const std::string& place, const WorkPart& work) {
  const WebPBitstreamFeatures features = features_of(bytes, place);
  Image image;
  image.width = features.width;
  image.height = features.height;
  const int row = 4 * features.width;
  image.rgba_srgb8.resize(static_cast<std::size_t>(row) *
                          static_cast<std::size_t>(features.height));
  const std::unique_ptr<WebPIDecoder, decltype(&WebPIDelete)> decoder(
      WebPINewRGB(MODE_RGBA, image.rgba_srgb8.data(), image.rgba_srgb8.size(), row), WebPIDelete);
  if (decoder == nullptr) throw std::bad_alloc();
  VP8StatusCode status = VP8_STATUS_SUSPENDED;
  for (std::size_t there = 0; there < bytes.size() && status == VP8_STATUS_SUSPENDED;) {
    work.reach(static_cast<double>(there) / static_cast<double>(bytes.size()));
    there = std::min(there + bytes_at_a_time, bytes.size());
    status = WebPIUpdate(decoder.get(), bytes.data(), there);
  }
  if (status != VP8_STATUS_OK) fail(place, status);
  return image;
}

}  // namespace omma
