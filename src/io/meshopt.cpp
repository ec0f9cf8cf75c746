// Attributes, lists of triangles and indices, with the filters of attributes, by meshoptimizer, whose
// decoders are made for bytes that nobody trusts.
#include "io/meshopt.h"

#include "io/csv_text.h"
#include "omma/error.h"

#ifdef OMMA_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace omma {

using nlohmann::json;

#ifdef OMMA_HAS_MESHOPTIMIZER

namespace {

struct Packing {
  std::string mode, filter;
  std::size_t count = 0, stride = 0;
};

Packing read_packing(const json& extension, const std::string& place) {
  Packing p;
  p.mode = extension["mode"].get<std::string>();
  p.filter = extension.value("filter", "NONE");
  p.count = extension["count"].get<std::size_t>();
  p.stride = extension["byteStride"].get<std::size_t>();
  const auto refuse = [&](const std::string& member, const std::string& expected,
                          const std::string& found) {
    throw Error(place + ": " + meshopt_extension + "." + member + ": expected " + expected +
                ", found " + found);
  };
  const std::string stride = std::to_string(p.stride);
  if (p.mode == "ATTRIBUTES") {
    if (p.stride == 0 || p.stride % 4 != 0 || p.stride > 256)
      refuse("byteStride", "a multiple of 4 up to 256", stride);
  } else if (p.mode == "TRIANGLES" || p.mode == "INDICES") {
    if (p.stride != 2 && p.stride != 4) refuse("byteStride", "2 or 4", stride);
    if (p.mode == "TRIANGLES" && p.count % 3 != 0)
      refuse("count", "a multiple of 3", std::to_string(p.count));
    if (p.filter != "NONE") refuse("filter", "NONE for " + p.mode, shown_text(p.filter));
  } else {
    refuse("mode", "ATTRIBUTES, TRIANGLES or INDICES", shown_text(p.mode));
  }
  if (p.filter == "OCTAHEDRAL") {
    if (p.stride != 4 && p.stride != 8) refuse("byteStride", "4 or 8 for OCTAHEDRAL", stride);
  } else if (p.filter == "QUATERNION") {
    if (p.stride != 8) refuse("byteStride", "8 for QUATERNION", stride);
  } else if (p.filter != "EXPONENTIAL" && p.filter != "NONE") {
    refuse("filter", "NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL", shown_text(p.filter));
  }
  return p;
}

}  // namespace

bool has_meshopt() {
  return true;
}

std::uint64_t meshopt_size(const json& extension, const std::string& place) {
  const Packing p = read_packing(extension, place);
  return std::uint64_t{p.count} * p.stride;
}

std::vector<std::uint8_t> meshopt_unpacked(const json& extension,
                                           std::span<const std::uint8_t> packed,
                                           const std::string& place) {
  const Packing p = read_packing(extension, place);
  std::vector<std::uint8_t> bytes(p.count * p.stride);
  if (p.count == 0) return bytes;
  int error = 0;
  if (p.mode == "ATTRIBUTES")
    error = meshopt_decodeVertexBuffer(bytes.data(), p.count, p.stride, packed.data(),
                                       packed.size());
  else if (p.mode == "TRIANGLES")
    error =
        meshopt_decodeIndexBuffer(bytes.data(), p.count, p.stride, packed.data(), packed.size());
  else
    error =
        meshopt_decodeIndexSequence(bytes.data(), p.count, p.stride, packed.data(), packed.size());
  if (error != 0)
    throw Error(place + ": " + meshopt_extension + ": its " + std::to_string(packed.size()) +
                " bytes do not unpack to " + std::to_string(p.count) + " elements of " +
                std::to_string(p.stride) + " bytes");
  if (p.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), p.count, p.stride);
  if (p.filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), p.count, p.stride);
  if (p.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), p.count, p.stride);
  return bytes;
}

#else

bool has_meshopt() {
  return false;
}

std::uint64_t meshopt_size(const json&, const std::string& place) {
  throw Error(place + ": " + meshopt_extension + ": this build has no meshoptimizer");
}

std::vector<std::uint8_t> meshopt_unpacked(const json& extension, std::span<const std::uint8_t>,
                                           const std::string& place) {
  meshopt_size(extension, place);
  return {};
}

#endif

}  // namespace omma
