// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"  // SPLINEVOX_HD

/// SPLINEVOX_INLINE: a formula that must dissolve into the loop around it, or the loop cannot become vector
/// code.
#if defined(__CUDACC__)
#define SPLINEVOX_INLINE SPLINEVOX_HD __forceinline__
#else
#define SPLINEVOX_INLINE __attribute__((always_inline)) inline
#endif

/// SPLINEVOX_UNROLL: a loop whose arrays must end up in a device's registers, which have no index. Host
/// compilers know by themselves.
#if defined(__CUDA_ARCH__)
#define SPLINEVOX_UNROLL _Pragma("unroll")
#else
#define SPLINEVOX_UNROLL
#endif
