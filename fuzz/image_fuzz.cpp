// Arbitrary bytes as an image of any kind: each is an image or an omma::Error. Those that claim
// more than a little memory are left alone, as that is their callers' to refuse.
#include <cstddef>
#include <cstdint>

#include "io/image.h"
#include "omma/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    if (omma::image_claim({data, size}, "fuzz").memory > 1 << 26) return 0;
    omma::decode_claimed_image({data, size}, "fuzz", {});
  } catch (const omma::Error&) {
  }
  return 0;
}
