// SPDX-License-Identifier: Apache-2.0
// The TOML library's code, compiled once (TOML_HEADER_ONLY=0).
#define TOML_IMPLEMENTATION
#include <toml++/toml.h>
