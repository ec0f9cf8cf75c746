// Compiles the kernels for one architecture and prints a row for each: what a thread of it takes.
//   omma_kernel_report CAPABILITY NVRTC     e.g. 90 for sm_90; the library's path, or "" to look
// Under those of a program its size and how long it took, on standard error warnings, with which it
// ends in 1.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "backend/cuda/compile.h"

namespace {

struct Kernel {
  std::string name;
  int registers = 0;
  int stack = 0, spill_stores = 0, spill_loads = 0, shared = 0;  // bytes
};

// The number in front of a text, or 0.
int number_before(const std::string& line, const std::string& text) {
  std::smatch found;
  return std::regex_search(line, found, std::regex("(\\d+) " + text)) ? std::stoi(found[1]) : 0;
}

// What the compiler says of a program's kernels, whether it warns, and how long it took.
struct Report {
  std::vector<Kernel> kernels;
  std::size_t bytes = 0;
  double seconds = 0;
  bool warned = false;
};

Report report_of(const omma::Nvrtc& nvrtc, const char* program,
                 const std::vector<std::string>& options) {
  Report report;
  const std::clock_t start = std::clock();
  const omma::Nvrtc::Compiled compiled = nvrtc.compile(omma::kernel_sources(), program, options);
  report.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  report.bytes = compiled.cubin.size();
  // What is called is told behind the kernel that calls it, and counts with it.
  std::vector<Kernel>& kernels = report.kernels;
  std::istringstream log(compiled.log);
  for (std::string line; std::getline(log, line);) {
    std::smatch found;
    if (std::regex_search(line, found, std::regex("Compiling entry function '(\\w+)'"))) {
      kernels.push_back({.name = found[1]});
    } else if (line.starts_with("ptxas ") && line.find("warning") == std::string::npos) {
      if (kernels.empty()) continue;
      Kernel& kernel = kernels.back();
      kernel.spill_stores += number_before(line, "bytes spill stores");
      kernel.spill_loads += number_before(line, "bytes spill loads");
      if (line.find("Used ") == std::string::npos) continue;
      std::regex_search(line, found, std::regex("Used (\\d+) registers"));
      kernel.registers = std::stoi(found[1]);
      kernel.stack = number_before(line, "bytes cumulative stack size");
      kernel.shared = number_before(line, "bytes smem");
    } else if (!line.empty()) {
      std::fprintf(stderr, "%s\n", line.c_str());
      report.warned = true;
    }
  }
  return report;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3) {
    std::fputs("omma_kernel_report CAPABILITY NVRTC\n", stderr);
    return 2;
  }
  const omma::Nvrtc nvrtc(arguments[2]);
  std::vector<std::string> options = omma::compile_options(nvrtc, std::atoi(arguments[1]));
  options.push_back("--ptxas-options=-v");
  std::printf("NVRTC %s\n", nvrtc.version().c_str());
  bool warned = false;
  for (const char* const program : {omma::render_program, omma::gather_program}) {
    const Report report = report_of(nvrtc, program, options);
    for (const Kernel& kernel : report.kernels)
      std::printf("sm_%s %-13s %9d %7d %12d %11d %7d\n", arguments[1], kernel.name.c_str(),
                  kernel.registers, kernel.stack, kernel.spill_stores, kernel.spill_loads,
                  kernel.shared);
    std::printf("sm_%s %s: %zu bytes %.0f s\n", arguments[1], std::strrchr(program, '/') + 1,
                report.bytes, report.seconds);
    warned = warned || report.warned;
  }
  return warned ? 1 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
