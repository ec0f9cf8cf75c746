// Whole files in and out. Readers and writers of every format go through these two, so that the
// errors of the file system are worded in one place and no half-written file keeps its final name.
#pragma once

#include <span>
#include <string>

#include "model/long_work.h"

namespace omma {

// All bytes of a regular file. Throws omma::Error that names the path where it is missing, a
// directory, or cannot be read.
std::string read_file(const std::string& path, const WorkPart& work = {});

// Writes to a temporary name beside the target and renames, so that the target is either what it
// was or complete. Throws omma::Error that names the path.
void write_file_atomically(const std::string& path, std::span<const char> bytes);

}  // namespace omma
