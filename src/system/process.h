// Processes: their numbers, and forks where a system has them.
#pragma once

namespace omma::system {

long process_id();

// `run` will be run in the child of every fork from now on. Windows has no forks. The result says
// only that it was called, so that it can be when the library is loaded.
bool at_fork_in_child(void (*run)());

}  // namespace omma::system
