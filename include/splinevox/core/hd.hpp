// SPDX-License-Identifier: Apache-2.0
#pragma once

/// SPLINEVOX_HD marks a formula or kernel body that compiles for the host and for a CUDA device.
#if defined(__CUDACC__)
#define SPLINEVOX_HD __host__ __device__
#else
#define SPLINEVOX_HD
#endif
