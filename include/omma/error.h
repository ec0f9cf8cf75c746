// What the library throws. Messages name the file or argument, the place in it, what was expected
// and what was found.
#pragma once

#include <stdexcept>
#include <string>

namespace omma {

// Anything wrong with an input: a file, an argument, a device. The message is made valid UTF-8 in
// one line: control characters, and bytes that are no UTF-8, become \n, \t, \xNN.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message);
};

// Thrown out of a render, or out of loading or building a scene, whose progress callback returned
// false, and out of all that is run as part of work that is to end. Outputs are then incomplete.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("the work was cancelled") {}
};

}  // namespace omma
