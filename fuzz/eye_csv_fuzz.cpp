// Arbitrary bytes as an eye in CSV: each is an omma::Error, or an eye that is the same when it is
// written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "io/eye_csv.h"
#include "omma/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  omma::Eye eye;
  try {
    eye = omma::parse_eye_csv(std::string(reinterpret_cast<const char*>(data), size), "fuzz.csv");
  } catch (const omma::Error&) {
    return 0;
  }
  const std::string text = omma::eye_csv_text(eye);
  if (omma::eye_csv_text(omma::parse_eye_csv(text, "again.csv")) != text) std::abort();
  return 0;
}
