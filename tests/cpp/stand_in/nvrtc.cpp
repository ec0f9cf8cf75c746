// Stands in for NVRTC where tests need its errors, or no compiling. A cubin of its is the options
// and how often it has compiled. By the environment variable STAND_IN_NVRTC compiling "fails", or
// takes so many seconds.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

namespace {

struct Program {
  int (*is_cancelled)(void*, void*) = nullptr;
  void* payload = nullptr;
  std::string cubin, log;
};

int compiled = 0;

}  // namespace

extern "C" {

const char* nvrtcGetErrorString(int result) {
  return result == 6 ? "NVRTC_ERROR_COMPILATION" : "NVRTC_ERROR_CANCELLED";
}

int nvrtcVersion(int* major, int* minor) {
  *major = 13;
  *minor = 0;
  return 0;
}

int nvrtcGetNumSupportedArchs(int* count) {
  *count = 3;
  return 0;
}

int nvrtcGetSupportedArchs(int* architectures) {
  architectures[0] = 75;
  architectures[1] = 80;
  architectures[2] = 86;
  return 0;
}

int nvrtcCreateProgram(Program** program, const char*, const char*, int, const char* const*,
                       const char* const*) {
  *program = new Program;
  return 0;
}

int nvrtcDestroyProgram(Program** program) {
  delete *program;
  return 0;
}

int nvrtcSetFlowCallback(Program* program, int (*is_cancelled)(void*, void*), void* payload) {
  program->is_cancelled = is_cancelled;
  program->payload = payload;
  return 0;
}

int nvrtcCompileProgram(Program* program, int count, const char* const* options) {
  const char* const asked = std::getenv("STAND_IN_NVRTC");
  if (asked != nullptr && std::string(asked) == "fails") {
    program->log = "grid.h(1): error: the stand-in fails";
    return 6;
  }
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> takes(asked != nullptr ? std::atof(asked) : 0);
  for (const auto begun = Clock::now();;) {
    if (program->is_cancelled != nullptr && program->is_cancelled(program->payload, nullptr) != 0)
      return 16;
    if (Clock::now() - begun >= takes) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  for (int i = 0; i < count; ++i) program->cubin += std::string(options[i]) + " ";
  program->cubin += std::to_string(++compiled);
  return 0;
}

int nvrtcGetCUBINSize(Program* program, std::size_t* size) {
  *size = program->cubin.size();
  return 0;
}

int nvrtcGetCUBIN(Program* program, char* cubin) {
  std::memcpy(cubin, program->cubin.data(), program->cubin.size());
  return 0;
}

int nvrtcGetProgramLogSize(Program* program, std::size_t* size) {
  *size = program->log.size() + 1;
  return 0;
}

int nvrtcGetProgramLog(Program* program, char* log) {
  std::memcpy(log, program->log.c_str(), program->log.size() + 1);
  return 0;
}

}  // extern "C"
