// Files in memory: see files.h.
#include "files.h"

#include <unistd.h>

namespace omma::web {
namespace {

constexpr const char* folder = "/files";

val file_system() {
  const val system = val::module_property("FS");
  if (!system.call<val>("analyzePath", val(folder))["exists"].as<bool>()) {
    system.call<void>("mkdir", val(folder));
    system.call<void>("chdir", val(folder));
  }
  return system;
}

}  // namespace

MemoryFiles::MemoryFiles(const std::string& name, const val& bytes, const val& others) {
  add(name, bytes);
  const val entries = val::global("Object").call<val>("entries", others);
  const int count = entries["length"].as<int>();
  for (int i = 0; i < count; ++i) add(entries[i][0].as<std::string>(), entries[i][1]);
}

MemoryFiles::~MemoryFiles() {
  for (const std::string& name : names_) ::unlink(name.c_str());
}

void MemoryFiles::add(const std::string& name, const val& bytes) {
  const std::string base = name.substr(name.rfind('/') + 1);
  if (base.empty() || base == "." || base == "..")
    throw Error("name: expected the name of a file, found \"" + name + "\"");
  if (!bytes.instanceof (val::global("Uint8Array")))
    throw Error(base + ": expected its bytes as a Uint8Array, found " + text_of(bytes.typeOf()));
  // Not copied: the file is read before the page has its bytes back.
  val options = val::object();
  options.set("canOwn", true);
  file_system().call<void>("writeFile", base, bytes, options);
  names_.push_back(base);
}

}  // namespace omma::web
