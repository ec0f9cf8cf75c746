// In place of image_openexr.cpp in a build without OpenEXR's library: its files are refused.
#include "io/image_formats.h"
#include "omma/error.h"

namespace omma {
namespace {

[[noreturn]] void refuse(const std::string& place) {
  throw Error(place + ": is OpenEXR, which this build of Omma does not read; expected PNG, JPEG, "
              "WebP or Radiance HDR");
}

}  // namespace

ImageClaim openexr_claim(EncodedImage, const std::string& place) {
  refuse(place);
}

Image decode_openexr(EncodedImage, const std::string& place, const WorkPart&) {
  refuse(place);
}

}  // namespace omma
