// Arbitrary bytes as an .eye file: each is a valid eye or an omma::Error.
#include <cstddef>
#include <cstdint>
#include <string>

#include "omma/error.h"
#include "omma/io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    omma::parse_eye(std::string(reinterpret_cast<const char*>(data), size), "fuzz.eye");
  } catch (const omma::Error&) {
  }
  return 0;
}
