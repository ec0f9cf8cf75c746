// Which backend is meant.
#include "backend/backend.h"

#include "omma/error.h"

namespace omma {

const Backend& find_backend(const std::string& name) {
  std::string names;
  for (const Backend& backend : backends()) {
    if (name.empty() || name == backend.name) return backend;
    names += (names.empty() ? "" : ", ") + std::string(backend.name);
  }
  throw Error("backend: expected one that is built in (" + names + "), found \"" + name + "\"");
}

}  // namespace omma
