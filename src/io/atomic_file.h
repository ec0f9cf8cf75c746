// Whole files in and out. Readers and writers of every format go through `read_file` and
// `write_file_atomically`, so that the errors of the file system are worded in one place and no
// half-written file keeps its final name.
#pragma once

#include <string>

#include "model/long_work.h"
#include "omma/io.h"  // write_file_atomically

namespace omma {

// All bytes of a regular file. Throws omma::Error that names the path where it is missing, a
// directory, or cannot be read.
std::string read_file(const std::string& path, const WorkPart& work = {});

}  // namespace omma
