// Small images of every kind that is read, encoded by the formats' own libraries, with the pixels
// that they must decode to. The fuzzers' seeds are made of them too.
#pragma once

#include <string>
#include <vector>

#include "omma/scene.h"

namespace omma::test {

struct EncodedKind {
  std::string name, bytes;
  Image expected;
  double tolerance = 0;  // in units of `expected`
};

// Each has 17 x 11 pixels, so that no block, tile or pass ends with it.
std::vector<EncodedKind> images_of_every_kind();

// Ways to make an image that no seed needs.
struct JpegWay {
  bool progressive = false, four_inks = false, adobe_marker = true;
  int sampling = 1;  // pixels of a chroma sample each way
  bool scan_each_coefficient = false;
};
EncodedKind jpeg_image(const std::string& name, const JpegWay& way);

struct ExrWay {
  std::vector<std::string> channels = {"R", "G", "B"};
  bool half = true, tiled = false;
  int compression = 0;          // of ImfCompression.h
  int first_x = 0, crop_x = 0;  // of the data window, and what of it the display window leaves out
  std::string attribute = {};   // a text to store, if any
  std::vector<float> chromaticities = {};  // x and y of red, green, blue and white, if any
};
EncodedKind exr_image(const std::string& name, const ExrWay& way);

}  // namespace omma::test
