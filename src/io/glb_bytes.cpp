// The container of .glb files: see glb_bytes.h.
#include "io/glb_bytes.h"

#include <cstdint>
#include <limits>

#include "omma/error.h"

namespace omma {
namespace {

std::string little_endian_u32(std::size_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xFF);
  return bytes;
}

}  // namespace

std::string glb_bytes(nlohmann::json document, std::string binary, const std::string& what) {
  if (!binary.empty()) document["buffers"] = {{{"byteLength", binary.size()}}};
  binary.resize((binary.size() + 3) / 4 * 4);
  std::string text;
  try {
    text = document.dump();
  } catch (const nlohmann::json::exception&) {
    throw Error(what + " has texts that are not UTF-8, which glTF cannot hold");
  }
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t size = 28 + text.size() + binary.size();
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error(what + " is too large for a .glb file: " + std::to_string(size) + " bytes");
  return "glTF" + little_endian_u32(2) + little_endian_u32(size) + little_endian_u32(text.size()) +
         "JSON" + text + little_endian_u32(binary.size()) + std::string("BIN\0", 4) + binary;
}

}  // namespace omma
