// The Open Compound Eye Standard: compound eyes in glTF 2.0 files, as the extension OCES_eyes
// (Blayzeing/open-compound-eye-standard; document 0.4.0 draft, schemas 0.3.0).
//
// Its frame is glTF's: right-handed, +Y up, +Z ahead, so that -X is the animal's right. Ours is
// that turned by half a turn about Y, which changes the signs of x and z and rounds nothing.
#pragma once

#include <string>
#include <vector>

#include "omma/eye.h"

namespace omma {

// The eyes of one head as one eye. `head` is its node's name or its number among the heads; empty:
// the only one. `file` holds the bytes of a .gltf or .glb file, `path` names it in errors.
Eye parse_oces(std::string file, const std::string& path, const std::string& head = "");

// Names of the heads of a file that are enabled, "" where a node has none; no heads where the file
// has no eyes.
std::vector<std::string> parse_oces_heads(std::string file, const std::string& path);

// The bytes of a .glb file, or of a .gltf file with its numbers inside.
std::string oces_bytes(const Eye& eye, bool binary);

}  // namespace omma
