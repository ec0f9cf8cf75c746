// What the library throws. Messages name the file or argument, the place in it, what was expected
// and what was found.
#pragma once

#include <stdexcept>
#include <string>

namespace omma {

// Anything wrong with an input: a file, an argument, a device.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Thrown out of a render, or out of loading or building a scene, whose progress callback returned
// false. Outputs are then incomplete.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("the work was cancelled") {}
};

}  // namespace omma
