// Memory that a thread keeps from one piece of work to the next, so that none is asked for in loops.
#pragma once

#include <cstddef>

namespace omma {

// So many bytes of this thread, aligned to 64; what is in them is not kept from call to call. What
// much larger work has left is given back. Not from oneTBB's allocator, whose locks a forked process
// may find held by threads that it lacks.
std::byte* thread_memory(std::size_t bytes);

}  // namespace omma
