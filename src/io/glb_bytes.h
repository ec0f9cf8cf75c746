// The container of .glb files, for whoever writes one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace omma {

// A .glb file of a document and its one buffer, which is padded and entered into the document.
// Throws omma::Error that starts with `what` where there is too much of it, or a text is not UTF-8.
std::string glb_bytes(nlohmann::json document, std::string binary, const std::string& what);

}  // namespace omma
