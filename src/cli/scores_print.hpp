// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "run/support.hpp"
#include "splinevox/run/evaluate.hpp"

/// The figures of `eval` as a table: a line for each view once it is compared, then the means.
namespace splinevox::cli {

/// @param split  whose views. @param notes  on them, that are said before
void print_scores_head(const std::string& split, const std::vector<std::string>& notes);
void print_view(const Frame& frame, const run::View& view);
/// @param figures  with the `metrics` of other programs, if there are any
void print_means(const run::Scores& scores, const run::Json& figures);

/// The same as one event (--json). The notes are in it, so that all that is printed is one object.
void tell_scores(run::Json figures, const std::vector<std::string>& notes);

}  // namespace splinevox::cli
