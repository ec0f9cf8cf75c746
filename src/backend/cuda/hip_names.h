// The names by which kernels ask for what a card has, in terms of HIP: scripts/hip_check puts this
// in front of them. They are compiled for AMD's cards so, and not run by anything of Omma.
#pragma once

#include <cstddef>

// By this the physics knows that it is compiled for a card.
#define __CUDACC__
#define __CUDA_ARCH__
#define __global__ __attribute__((global))
#define __host__ __attribute__((host))
#define __device__ __attribute__((device))
#define __shared__ __attribute__((shared))

struct HipIndex {
  unsigned x;
};
#define threadIdx HipIndex(__builtin_amdgcn_workitem_id_x())
#define blockIdx HipIndex(__builtin_amdgcn_workgroup_id_x())
#define gridDim HipIndex(__builtin_amdgcn_grid_size_x() / __builtin_amdgcn_workgroup_size_x())
inline __device__ void __syncthreads() {
  __builtin_amdgcn_fence(__ATOMIC_RELEASE, "workgroup");
  __builtin_amdgcn_s_barrier();
  __builtin_amdgcn_fence(__ATOMIC_ACQUIRE, "workgroup");
}

#define memcpy __builtin_memcpy
#define __ffs __builtin_ffs
#define __popc __builtin_popcount
#define fabs __builtin_fabs
#define fabsf __builtin_fabsf
#define fmax __builtin_fmax
#define fmaxf __builtin_fmaxf
#define fmin __builtin_fmin
#define fminf __builtin_fminf
#define sqrt __builtin_sqrt
#define sqrtf __builtin_sqrtf

// Of the ROCm device library.
extern "C" {
__device__ double __ocml_asin_f64(double);
__device__ float __ocml_asin_f32(float);
__device__ double __ocml_atan2_f64(double, double);
__device__ float __ocml_atan2_f32(float, float);
__device__ double __ocml_cos_f64(double);
__device__ double __ocml_erfc_f64(double);
__device__ double __ocml_exp_f64(double);
__device__ double __ocml_log_f64(double);
__device__ double __ocml_sin_f64(double);
__device__ double __ocml_tan_f64(double);
}
#define asin __ocml_asin_f64
#define asinf __ocml_asin_f32
#define atan2 __ocml_atan2_f64
#define atan2f __ocml_atan2_f32
#define cos __ocml_cos_f64
#define erfc __ocml_erfc_f64
#define exp __ocml_exp_f64
#define log __ocml_log_f64
#define sin __ocml_sin_f64
#define tan __ocml_tan_f64

namespace std {

// The compiler knows it by its members: of lists in braces, the first and how many there are.
template <typename T>
class initializer_list {
 public:
  __device__ const T* begin() const { return first_; }
  __device__ const T* end() const { return first_ + size_; }

 private:
  const T* first_;
  size_t size_;
};

}  // namespace std
