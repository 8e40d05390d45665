// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "run/support.hpp"
#include "splinevox/run/evaluate.hpp"

/// The figures of `eval` as a table: a line for each view once it is compared, then the means.
namespace splinevox::cli {

/// @param split  whose views
void print_scores_head(const std::string& split);
void print_view(const Frame& frame, const run::View& view);
/// @param figures  with the `metrics` of other programs, if there are any
void print_means(const run::Scores& scores, const run::Json& figures);

}  // namespace splinevox::cli
