// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "run/support.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::run {

/// A model that is being edited: operations change it one after the other.
class EditSession {
 public:
  /// @param say  hears lines about what the operations did
  EditSession(Run run, std::function<void(const std::string&)> say)
      : run_(std::move(run)), say_(std::move(say)) {}

  /// Does one operation of edit_operations(). Throws Error (input) if it makes no sense here.
  void apply(const std::string& operation, const std::string& value);

  const VoxelModel& model() const { return run_.model; }
  /// [{"operation", "value" and what is known about the result}], in order.
  const Json& done() const { return done_; }

 private:
  friend struct EditOperations;
  friend struct ClusterOperations;
  Run run_;
  std::function<void(const std::string&)> say_;
  Json done_ = Json::array();
  std::optional<MotionClusters> clusters_;  ///< of the model as it is
  ChosenClusters chosen_;                   ///< empty: none yet
};

/// One operation as the command line has it.
struct EditOperation {
  const char* name;   ///< of the option, without dashes
  const char* value;  ///< what its value is; nullptr: it has none
  const char* help;
  const char* group;  ///< heading in the help text
  /// Changes the session; what it returns joins the history and is printed.
  Json (*apply)(EditSession&, const std::string& value);
};
const std::vector<EditOperation>& edit_operations();
/// Those on parts of the model; edit_operations() has them too.
std::vector<EditOperation> cluster_operations();

/// Every chosen cluster in a colour of its own; the static one is grey.
void paint_parts(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen);
/// A copy of the model with all of them painted: the layer "cluster".
VoxelModel painted(const VoxelModel& model, const MotionClusters& clusters);
/// The colour that painted matter of a cluster has, from every side, where no light changes it.
Vec3 part_colour(const VoxelModel& model, std::size_t cluster);

/// One number of an operation's value. Throws Error (input) unless it lies in [lo, hi].
double edit_number(const char* operation, const std::string& text, double lo, double hi,
                   const std::string& expected);
int edit_whole(const char* operation, const std::string& text, int lo, int hi);
[[noreturn]] void wrong_edit(const char* operation, const std::string& what, const std::string& expected,
                             const std::string& got, const std::string& hint = "");

}  // namespace splinevox::run
