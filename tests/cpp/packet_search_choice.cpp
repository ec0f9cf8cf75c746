// Which of the builds of packet_search.cpp this processor runs.
#include "packet_search.h"

namespace omma {

std::vector<SearchFunctions> portable_searches() {
  std::vector<SearchFunctions> searches{baseline::portable_search()};
#if defined(OMMA_HAS_PLAIN)
  searches.push_back(plain::portable_search());
#endif
#if defined(OMMA_HAS_AVX2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2"))
    searches.push_back(avx2::portable_search());
#endif
#if defined(OMMA_HAS_AVX512)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    searches.push_back(avx512::portable_search());
#endif
  return searches;
}

}  // namespace omma
