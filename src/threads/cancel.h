// Whether work is to end. Apart from parallel.h, so that the hot loop, which is built for several
// instruction sets, takes along none of oneTBB's inline functions.
#pragma once

namespace omma {

// Throws omma::Cancelled where the work that this thread takes part in is to end. Loops that are
// not parallel ask once in a few milliseconds' work.
void check_cancelled();

}  // namespace omma
