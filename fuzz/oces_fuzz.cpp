// Arbitrary bytes as an OCES file, .gltf or .glb: each is a valid eye or an omma::Error. URIs may
// lead to the files in fuzz/beside.
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/oces.h"
#include "omma/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    omma::parse_oces(std::string(reinterpret_cast<const char*>(data), size),
                     OMMA_FUZZ_BESIDE "/eyes.gltf");
  } catch (const omma::Error&) {
  }
  return 0;
}
