// The process in which the emulated card's threads run. It has nothing of the host but the card's
// memory, so that a pointer into the host's ends it.
//
//   omma_emulated_device ORDINAL MEMORY SOCKET    descriptors: of its memory, and to the host
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "emulated/device.h"

using namespace omma::test;

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const int memory = std::atoi(argv[2]), host = std::atoi(argv[3]);
  void* const wanted = reinterpret_cast<void*>(device_address(std::atoi(argv[1])));
  if (mmap(wanted, device_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED_NOREPLACE, memory,
           0) != wanted) {
    std::perror("emulated device: memory");
    return 1;
  }
  DeviceCall call;
  while (read(host, &call, sizeof call) == sizeof call) {
    const DeviceUse use = run_on_device(call);
    if (write(host, &use, sizeof use) != sizeof use) return 1;
  }
  return 0;
}
