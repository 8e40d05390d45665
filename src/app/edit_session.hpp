// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/evaluate.hpp"

namespace splinevox::app {

/// A model that is being edited: operations change it one after the other.
class EditSession {
 public:
  /// @param quiet  say nothing about what the operations did
  EditSession(Run run, bool quiet) : run_(std::move(run)), quiet_(quiet) {}

  /// Does one operation of edit_operations(). Throws Error (input) if it makes no sense here.
  void apply(const std::string& operation, const std::string& value);

  const VoxelModel& model() const { return run_.model; }
  /// [{"operation", "value" and what is known about the result}], in order.
  const Json& done() const { return done_; }

 private:
  friend struct EditOperations;
  Run run_;
  bool quiet_;
  Json done_ = Json::array();
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

}  // namespace splinevox::app
