// Processes: their numbers, and forks where a system has them.
#pragma once

namespace omma::system {

long process_id();

// `run` will be run in the child of every fork from now on. Windows has no forks. The result says
// only that it was called, so that it can be when the library is loaded.
bool at_fork_in_child(void (*run)());

// From now on exit() ends the process before it runs the destructors of libraries that were loaded
// before this call, where `must` then says so: with its exit status, and what streams hold written.
// Of what POSIX has, exit() tells nobody its status; where the C library is not GNU's nothing is
// done. The result says only that it was called.
bool end_early_at_exit(bool (*must)());

}  // namespace omma::system
