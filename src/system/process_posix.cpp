// Processes of POSIX systems.
#include <pthread.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "system/process.h"

namespace omma::system {

long process_id() {
  return getpid();
}

bool at_fork_in_child(void (*run)()) {
  return pthread_atfork(nullptr, nullptr, run) == 0;
}

bool end_early_at_exit([[maybe_unused]] bool (*must)()) {
#ifdef __GLIBC__
  static bool (*asked)() = nullptr;
  asked = must;
  on_exit(
      [](int status, void*) {
        if (!asked()) return;
        std::fflush(nullptr);
        _exit(status);
      },
      nullptr);
#endif
  return true;
}

}  // namespace omma::system
