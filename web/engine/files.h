// Files that a page hands over as bytes, for readers that take paths.
#pragma once

#include <string>
#include <vector>

#include "values.h"

namespace omma::web {

// Files in the module's own file system, which lies in memory; they are gone with it. They lie in
// one folder, the current one, so that messages name them as the page does.
class MemoryFiles {
 public:
  // `bytes`: a Uint8Array. Of a name only what is behind its last slash counts.
  MemoryFiles(const std::string& name, const val& bytes) { add(name, bytes); }
  // `others`: an object of names and Uint8Arrays, what the file reads beside itself.
  MemoryFiles(const std::string& name, const val& bytes, const val& others);
  MemoryFiles(const MemoryFiles&) = delete;
  MemoryFiles& operator=(const MemoryFiles&) = delete;
  ~MemoryFiles();

  // The path of the first file.
  const std::string& path() const { return names_.front(); }

 private:
  void add(const std::string& name, const val& bytes);

  std::vector<std::string> names_;
};

}  // namespace omma::web
