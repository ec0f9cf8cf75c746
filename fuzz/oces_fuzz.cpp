// Arbitrary bytes as an OCES file, .gltf or .glb: each is a valid eye or an omma::Error. URIs lead
// into a folder that is not there.
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/oces.h"
#include "omma/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    omma::parse_oces(std::string(reinterpret_cast<const char*>(data), size),
                     "no-such-folder/eyes.gltf");
  } catch (const omma::Error&) {
  }
  return 0;
}
