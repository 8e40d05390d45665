// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/depth_map.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/core/pixel_mask.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A point that is followed through pictures, where one of them shows it.
struct VisiblePoint {
  int point = 0;       ///< of the data set, from 0
  float u = 0, v = 0;  ///< pixels of the frame's camera: the centre of the first is at (0.5, 0.5)
};

/// One posed picture. `time` is mapped by the train split's TimeMap: in [0, 1] on the train split,
/// possibly outside on others.
struct Frame {
  std::string name;  ///< file name without folder and extension, as reports show it
  Camera camera;
  double time = 0;
  Picture image;
  int camera_id = -1;      ///< which of Dataset::cameras took it; -1: nobody knows
  PixelMask ignored = {};  ///< pixels that say nothing: not drawn, not scored, no evidence; never all of them
  CoarseMask moving = {};  ///< what shows something that moves, where that is known; else no size
  PixelMask inside = {};   ///< the white of a mask that is used for nothing else, if LoadOptions::inside
  DepthMap depth = {};     ///< how far away its pixels are, where that is known and LoadOptions::depth
  std::vector<VisiblePoint> tracks = {};  ///< points that it shows, in order, if LoadOptions::tracks
  /// Which picture it is, wherever the data set lies: a printable line with the file's path in the data set's
  /// folder, its bytes and which picture of a film it is. Empty: not from a file.
  std::string source = {};
};

/// Masks that lie beside the pictures of the splits that were read.
struct DatasetMasks {
  std::string use;           ///< as DatasetRules::masks has it
  std::size_t pictures = 0;  ///< that have one
  std::size_t frames = 0;    ///< of all splits
  std::string example;       ///< path of the first, in the data set
  std::size_t looked_at = 0;
  double white = 0;  ///< mean share of white in those that were looked at, 0 to 1
};

/// Depth maps that the data names for pictures of the splits that were read.
struct DatasetDepth {
  std::string kind;          ///< "metric", "relative" or "inverse"; "none": they are not used
  std::size_t pictures = 0;  ///< that have one
  std::size_t frames = 0;    ///< of all splits
  std::string example;       ///< path of the first, as the data has it
  std::size_t looked_at = 0;
  double known = 0;  ///< mean share of the pixels of those looked at whose depth is known, 0 to 1
};

/// Points that are followed through pictures.
struct DatasetTracks {
  std::string file;          ///< or the folder of flow, as messages name it
  std::size_t points = 0;    ///< in it, or followed by it
  std::size_t pictures = 0;  ///< the same, held-out ones among them
  double visible = 0;        ///< share of the places in training pictures where a point is seen, 0 to 1
};

/// A real camera that took two frames or more.
struct RigCamera {
  std::string name;    ///< as the data calls it: an id, a film, a folder; else "camera 3"
  bool still = false;  ///< all its frames have one pose and one lens
};

struct Split {
  std::string name;  ///< "train", "val" or "test"
  std::vector<Frame> frames;
};

/// A data set, read and validated once; const from there on.
struct Dataset {
  std::string path;
  std::vector<Split> splits;  ///< those that exist on disk, train first
  TimeMap time_map;
  /// Any training pixel with alpha < 1 (any pixel read, if train was not); where pixels were not read, of the
  /// first, the middle and the last picture.
  bool has_alpha = false;
  int downscale = 1;
  std::uint64_t fingerprint = 0;  ///< hash of lenses, poses, times and pixels of train; 0 if not read
  std::vector<std::string>
      notes;  ///< what is odd about it or was guessed, one line each, for `info` and the log
  double pictures_in_memory = 0, pictures_in_files = 0;  ///< bytes that the pixels of all splits take
  std::string format;  ///< the layout it was recognised as: a name of dataset_formats()
  std::optional<Box> box =
      {};  ///< where the scene lies, from its points or depth bounds, if the data says; scene units

  std::vector<RigCamera> cameras = {};  ///< empty: every frame may be of another one

  std::optional<DatasetMasks> masks = {};    ///< absent: no picture has one
  std::optional<DatasetDepth> depth = {};    ///< absent: no picture has any, or nobody asked for it
  std::optional<DatasetTracks> tracks = {};  ///< absent: there are none, or nobody asked for them

  /// Colour of the plain ground that prepare (train/prepare.hpp) cut out of the train split's opaque
  /// pictures: their pixels of it have alpha 0.
  std::optional<Vec3> ground = {};

  Split* find(const std::string& split) {
    return const_cast<Split*>(static_cast<const Dataset*>(this)->find(split));
  }
  const Split* find(const std::string& split) const {
    for (const Split& s : splits)
      if (s.name == split) return &s;
    return nullptr;
  }
};

/// How a folder is understood where it leaves room for it.
struct DatasetRules {
  /// Where times come from: empty = the data's own, else times.txt, else the names; "none" = all pictures are
  /// of one moment; "order" = evenly in the order of names; "name:GROUP" = a group of digits, from 1 at the
  /// left or -1 at the right; else a file with a picture's name and a number per line.
  std::string times = {};
  /// What becomes of frames whose picture is missing or whose camera is no camera: "skip" = they are left
  /// out; "refuse" = an error; empty = left out if they are a tenth of all or fewer, else an error.
  std::string missing = {};
  /// What masks beside the pictures are for. "subject": white is the scene, all else is empty; it multiplies
  /// the alpha. "ignore-black": black pixels say nothing (Frame::ignored). "ignore": the same, but white in
  /// files named dynamic_mask_.... "moving": white moves (Frame::moving), all else stands still.
  /// "subject-black", "ignore-white", "moving-black": the opposite. "none": nothing. Empty: that, and a note.
  std::string masks = {};
  /// What the numbers in pictures stand for: "srgb" = values as a screen shows them, "linear" = light; empty
  /// = light in OpenEXR and in other floats, else as a screen shows them.
  std::string transfer = {};
  std::string layer = {};  ///< of OpenEXR pictures; empty: the one that holds colours
  /// What depth maps (depth_file_path) say: the name of a DepthKind. "none": they are not read. Empty:
  /// metric where the data says their unit (depth_unit_scale_factor), else relative.
  std::string depth = {};
  /// File of points that are followed through the pictures of one camera (.npy or .npz), or folder of optical
  /// flow between them (docs/data.md). Empty: the data's own (tracks_file_path); "none": nothing is read.
  std::string tracks = {};
  /// "FROM:TO": only pictures taken then, both ends included, in the data's own times, which become 0 to 1.
  /// Empty: all.
  std::string between = {};
  /// What is held out of data that names no test split: "none" = nothing, all pictures train; else names of
  /// cameras, divided by commas. Empty: as load_dataset says.
  std::string hold_out = {};
};

struct LoadOptions {
  int downscale = 1;                       ///< KxK blocks of the stored straight RGBA are averaged, >= 1
  std::vector<std::string> splits = {};    ///< which to read; empty = all that exist
  std::vector<std::string> if_there = {};  ///< which to read beside them where they exist
  std::optional<TimeMap> time_map = {};    ///< the run's map; absent = take it from the train split
  DatasetRules rules = {};
  bool pixels = true;   ///< false: pictures are measured by their headers, not decoded; frames have none
  bool inside = false;  ///< masks that the rules do not speak of become Frame::inside
  bool depth = false;   ///< depth maps are read, as Frame::depth; without pixels only some are looked at
  bool tracks = false;  ///< points that are followed are read, as Frame::tracks
  bool keep = true;     ///< false: pictures are decoded and looked at, and frames have none
  /// Bytes of memory that pictures may take. Asked once everything but them is known; more of them than that
  /// live in a file (docs/data.md). Empty: what the process may have.
  std::function<double(const Dataset&)> room = {};
  std::string cache = {};  ///< folder for that file; empty: splinevox in $XDG_CACHE_HOME or ~/.cache
};

/// The layouts that are recognised, in the order in which a folder is tried.
std::vector<std::string> dataset_formats();

/// Reads a data set folder of any layout of docs/data.md, recognised by what lies in it, checked once and
/// completely; nothing is returned of a set with a fault. Where the data names no test split, every eighth
/// picture is one, or of a rig of five or more cameras that stand still one camera of eight.
///
/// Times: a train split that fills a quarter of [0, 1] or more is taken as it is, any other has its range
/// mapped to [0, 1], and the same map serves every split. If train is not asked for and options give no map,
/// its times are read for the map, its pictures are not. Throws Error (Fault::input) naming file, frame and
/// field; of several bad pictures always the first.
Dataset load_dataset(const std::string& path, const LoadOptions& options = {});

struct ConvertOptions {
  /// Added to every position, scene units: models hold positions as floats, so a scene in coordinates of a
  /// map must come nearer to the origin first (numerics H14). Stands in the files as `shift`.
  Vec3d shift{};
  double scale = 1;  ///< of every position, after the shift: for units that are too large or too small; > 0
  DatasetRules rules{};
  /// Called with what was guessed or left out, a line each, before pictures are written.
  std::function<void(const std::string&)> on_note = {};
};

/// Called after every finished picture, from one thread.
using ConvertProgress = std::function<void(int done, int total)>;

/// Writes a data set of any layout as a D-NeRF folder: transforms_{train,val,test}.json and pictures. Files
/// are copied byte for byte, but for those that their EXIF turns: they become PNG, upright as their cameras
/// are. Masks are copied too (`mask_path`); a subject's become the alpha of PNG, and those of pixels to be
/// ignored are written black where they ignore. What D-NeRF's own files cannot say stands in further fields
/// that load_dataset reads: lenses per frame, distortion, the box. Times and cameras are those of the source
/// to the last bit of a double.
///
/// The transforms files are written last. Throws Error: Fault::input as load_dataset, or if `folder` exists
/// and is not empty; Fault::output.
void convert_dataset(const std::string& path, const std::string& folder, const ConvertProgress& progress = {},
                     const ConvertOptions& options = {});

}  // namespace splinevox
