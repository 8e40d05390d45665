// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox {

/// One named group of channels of an OpenEXR picture: the file's channel is "<name>.<letter>". A layer of one
/// channel without letters is the channel "<name>"; a layer without name is the picture itself (R, G, B, A).
struct ExrLayer {
  std::string name;
  Image image;                        ///< any values, as 32-bit floats
  std::vector<std::string> channels;  ///< one per channel of `image`; empty = none for 1, else R, G, B, A
  bool half = false;                  ///< written as 16-bit floats, clamped to their largest
};

/// What an OpenEXR header says of a rendered picture, in OpenEXR's standard attributes. Its matrices are of
/// row vectors: worldToCamera to x right, y up, z into the picture; worldToNDC to (0, 0) at the upper left
/// and (1, 1) at the lower right corner, of a lens without distortion.
struct ExrNotes {
  std::optional<Camera> camera;  ///< worldToCamera, worldToNDC
  double fps = 0;                ///< framesPerSecond; 0: not said
  std::optional<int> frame;      ///< imageCounter
  std::optional<double> time;    ///< modelTime, a float
  /// colorInteropID, the name of the colour space (ASWF Color Interop Forum), with chromaticities of Rec.
  /// 709; empty: not said.
  std::string color_space;
  std::map<std::string, std::string> texts{};  ///< further attributes
};

/// Names of layers and the letters of their channels in the order R G B A, X Y Z, then by name, of a file
/// with such channels.
std::map<std::string, std::vector<std::string>> exr_layers(const std::vector<std::string>& channels);

/// Largest picture read_exr_layers accepts, checked before anything is allocated for it.
inline constexpr int kExrMaxSide = 16384, kExrMaxChannels = 256;
inline constexpr std::size_t kExrMaxBytes = std::size_t(2) << 30;  ///< width * height * channels * 4

/// Reads all channels of a single-part OpenEXR file as floats (half and unsigned channels are converted),
/// grouped by exr_layers.
///
/// @param choose  may leave out layers, which then are not read; their images are empty when it is called
///
/// Throws Error (Fault::input) naming the file: not there, not OpenEXR, multi-part or deep, damaged,
/// truncated, subsampled, or larger than the limits above.
std::vector<ExrLayer> read_exr_layers(const std::string& path,
                                      const std::function<void(std::vector<ExrLayer>&)>& choose = {});

/// Runs `work`; its errors are of `where`, the name that a user knows the file by. @param hint  instead of
/// theirs; null: theirs
template <class Work>
auto called(const std::string& where, const char* hint, const Work& work) {
  try {
    return work();
  } catch (const Error& e) {
    Problem problem = e.problem;
    problem.where = where;
    if (hint) problem.hint = hint;
    fail(problem);
  }
}

/// What the header of an OpenEXR file says.
struct ExrHeader {
  int width = 0, height = 0;  ///< of the pixels that are there
  bool whole = true;          ///< they fill the display window
  std::vector<std::string> channels;
};
/// Reads it without the pixels. Throws as read_exr_layers.
ExrHeader read_exr_header(const std::string& path);

/// Layers of one size as a single-part OpenEXR file, ZIP compressed: lossless. All or
/// nothing (core/atomic_file.hpp); throws Error (Fault::output) naming the path.
void write_exr(const std::string& path, const std::vector<ExrLayer>& layers, const ExrNotes& notes = {});

/// The layer of that name, or Error (Fault::input) listing those that `path` holds.
const ExrLayer& find_exr_layer(const std::vector<ExrLayer>& layers, const std::string& name,
                               const std::string& path);

}  // namespace splinevox
