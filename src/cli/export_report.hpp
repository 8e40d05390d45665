// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/command.hpp"
#include "core/stopwatch.hpp"
#include "run/teller.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox::cli {

/// A figure of a file; 0 where it has no such figure.
double figure_of(const ManifestFile& file, const char* name);

/// What is said of a file of a frame: its name, size and figures.
Json file_json(const ManifestFile& file);

/// What is said of the files, one or more, that an earlier call left beside those of a sequence.
/// @param of  "export", "render"
std::string left_over(const std::string& of, const std::vector<std::string>& files);

/// What the user is told of an export: a count or events while it runs, a summary at its end.
class ExportReport {
 public:
  /// @param options  must outlive the report
  ExportReport(Talk talk, const ExportOptions& options);
  /// One more of `total` frames is there.
  void add(const ExportedFrame& frame, int done, int total);
  /// After the last one. @param processes  that made the frames @param model  that they show
  void summarise(const ExportResult& result, const std::string& folder, int processes,
                 const VoxelModel& model) const;

 private:
  /// Of a whole sequence: what is in the folder, and what its making took.
  void explain(const ExportResult& result, const std::string& folder, const VoxelModel& model) const;
  /// What is not in the frames, and how to open them.
  void advise(const std::string& folder, const VoxelModel& model) const;
  void print_line(const ExportedFrame& frame) const;

  Teller teller_;
  const ExportOptions& options_;
  double bytes_ = 0, speed_ = 0, writing_ = 0;
  double short_ = 0;          ///< voxels of velocity that the fastest matter asks for and does not get
  bool wide_ = false;         ///< some grid did not fit 16-bit floats
  int kept_ = 0, empty_ = 0;  ///< frames that were there before; without a voxel of matter
  Timer timer_;
  double cpu_;
};

}  // namespace splinevox::cli
