// Processes of POSIX systems.
#include <pthread.h>
#include <unistd.h>

#include "system/process.h"

namespace omma::system {

long process_id() {
  return getpid();
}

bool at_fork_in_child(void (*run)()) {
  return pthread_atfork(nullptr, nullptr, run) == 0;
}

}  // namespace omma::system
