// The JavaScript module: what it has of its own, and the other files' functions.
#include <emscripten/bind.h>
#include <emscripten/heap.h>

#include "handles.h"
#include "values.h"

namespace omma::web {
namespace {

std::string version() {
  return OMMA_VERSION;
}

// How this module was built: what a page says where it is slower than it could be.
val build() {
  val about = val::object();
#if defined(__wasm_simd128__)
  about.set("simd", true);
#else
  about.set("simd", false);
#endif
#if defined(__EMSCRIPTEN_PTHREADS__)
  about.set("threads", true);
#else
  about.set("threads", false);
#endif
  return about;
}

// Of the module's memory, which grows and is never given back; at most 4 GiB.
double memory_bytes() {
  return static_cast<double>(emscripten_get_heap_size());
}

}  // namespace

EMSCRIPTEN_BINDINGS(omma) {
  emscripten::function("version", &version);
  emscripten::function("build", &build);
  emscripten::function("memory_bytes", &memory_bytes);
  bind_scene();
  bind_eye();
  bind_renderer();
  bind_projection();
}

}  // namespace omma::web
