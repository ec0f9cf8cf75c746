// Processes of Windows.
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include "system/process.h"

namespace omma::system {

long process_id() {
  return static_cast<long>(GetCurrentProcessId());
}

bool at_fork_in_child(void (*)()) {
  return true;
}

bool end_early_at_exit(bool (*)()) {
  return true;
}

}  // namespace omma::system
