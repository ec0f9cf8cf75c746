// Which backend is meant.
#include "backend/backend.h"

#include "omma/error.h"

namespace omma {

const Backend& find_backend(std::string_view name) {
  std::string names;
  for (const Backend& backend : backends()) {
    if (name.empty() || name == backend.name) return backend;
    names += (names.empty() ? "" : ", ") + std::string(backend.name);
  }
  throw Error("backend: expected one that is built in (" + names + "), found \"" +
              std::string(name) + "\"");
}

void expect_no_devices(const char* backend, std::span<const int> devices) {
  if (devices.empty()) return;
  std::string found;
  for (const int device : devices) found += (found.empty() ? "" : ", ") + std::to_string(device);
  throw Error("devices: expected none with the backend \"" + std::string(backend) +
              "\", which runs on the processor (graphics cards are of \"cuda\"); found " + found);
}

}  // namespace omma
