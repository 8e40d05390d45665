// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// How a built-in scene is lit, what it is made of and how often it goes through its motion.
struct SynthLook {
  double gloss = 0;     ///< strength of a highlight that follows the eye, 0..1
  double fade = 0;      ///< share of the light that is gone at time 1, 0..1, falling evenly
  double light = 1;     ///< of everything, 0..1
  int repeats = 1;      ///< the motion runs there, back, there, .. so often between time 0 and 1; at least 1
  bool opaque = false;  ///< pictures without alpha: a plain grey wall behind the scene
  bool room = false;    ///< the scene stands in a room with things in it, in which the cameras are, wide and
                        ///< near; pictures without alpha. The bodies before the room's are the subject.
};

/// Cameras that stand still around the scene, as in a studio. Test cameras are two others and see the scene
/// neutrally and in time.
struct SynthRig {
  int cameras = 0;       ///< of the training pictures, each at every moment; 0: no rig; 2..100
  double arc = 1;        ///< how much of the whole ring they stand along, (0, 1]
  bool turns = false;    ///< they take turns: one camera a moment
  double exposures = 0;  ///< training cameras multiply every channel by a gain of its own, at most this share
                         ///< away from 1 before their geometric mean is made 1; [0, 0.5]
  double late = 0;       ///< one training camera in eight, the second first, shows what happens so many
                         ///< intervals between moments after the time it says; -2..2
  bool masks = false;    ///< write_synth: a mask beside every picture, white where the subject is
  bool movers = false;   ///< those masks are white where something moves at any time of [0, 1] instead
};

/// What to make of a built-in scene.
struct SynthOptions {
  int frames = 100;  ///< training pictures, 2..10000, picture i at time i / (frames - 1); a fifth as many
                     ///< test pictures and a tenth as many validation pictures, at least 2 each
  int size = 200;    ///< width and height of every picture, 8..4096 pixels
  std::uint64_t seed = 1;  ///< of the training cameras; the scene itself is always the same
  double orbit = 0;  ///< 0: a training camera anywhere for every picture; else one that goes around the scene
                     ///< so often between time 0 and 1, as in a video, -100..100
  bool film = false;  ///< with orbit: val pictures lie on the camera's way, between training pictures; test
                      ///< pictures are from half the way further, a little higher, at training times
  /// Training pictures have depth of this kind, exact but for s and b, which are drawn for each of them; 0
  /// where nothing solid is hit. A scene of gas has none.
  std::optional<DepthKind> depth{};
  bool tracks = false;  ///< points of surfaces are followed through the training pictures, exactly
  double shake = 0;     ///< with film: the camera is held by hand. Each axis of its position wanders by this
                        ///< share of its distance, its direction by so many radians about each axis; 0..0.2
  double drift = 0;  ///< with film or a rig: exposures of training cameras drift; every channel is at most so
                     ///< much brighter than the mean over time, and 1 over that darker; 0..0.5
  SynthLook look{};
  SynthRig rig{};  ///< frames are then its moments; excludes orbit
};

/// Names of the built-in scenes, the default first.
///
///   dancer  a jointed figure with a swinging plait (forward kinematics), a squashing ball, a plant that
///           bends in the wind, and a static plinth
///   ball    one ball on a straight line at constant speed, turning not at all
///   snake   one body that bends, and nothing rigid
///   toy     the dancer's scene in which only the ball moves
///   garden  the dancer's scene in which only the plant and the ball move
///   static  the dancer's scene as it is at time 0
///   smoke   a plume that is born at a source, rises, turns, thins out and is gone; thin everywhere
///   fire    flames from a source: bright, short-lived, dark red where they end
///   enters  the dancer's scene as it is at time 0, into which a ball falls from above all pictures, to stay
///   leaves  the same, out of which it rises
std::vector<std::string> synth_scenes();

/// One point of a surface as a ray meets it.
struct SynthHit {
  int body = 0;      ///< which body of the scene
  Vec3d position{};  ///< world, scene units, at the time of the moment
  Vec3d rest{};      ///< where the same point of the material is at time 0; never changes with time
  Vec3d normal{};    ///< unit, outwards
  double along = 0;  ///< distance from the ray's origin
  Vec3d colour{};    ///< shaded, display-referred, [0, 1]
};

/// Gas of a scene at one time, on a lattice: the very numbers that its pictures are made of. Voxel ijk is at
/// origin + spacing * ijk; between voxels density, and density times colour, are trilinear; outside is
/// nothing.
struct SynthVolume {
  Vec3d origin{};              ///< of voxel 0, scene units
  double spacing = 1;          ///< between voxels, scene units
  Int3 size{};                 ///< voxels per axis
  std::vector<float> density;  ///< [x][y][z] extinction, 1 / scene unit
  std::vector<Vec3> colour;    ///< [x][y][z] display values; 0 where there is no density

  std::size_t index(const Int3& v) const { return (std::size_t(v.x) * size.y + v.y) * size.z + v.z; }
  Vec3d position(const Int3& v) const { return origin + spacing * cast<double>(v); }
  struct Sample {
    double density = 0;
    Vec3d colour{};
  };
  Sample at(const Vec3d& place) const;
};

class SynthMoment;

/// A built-in scene: bodies whose motion is known in closed form. Rest is the pose at time 0, so position
/// minus rest is the exact displacement that carries the canonical frame to time t.
class SynthScene {
 public:
  /// Throws Error (Fault::input) listing the scenes when there is none of that name.
  static SynthScene open(const std::string& name, const SynthLook& look = {});
  /// The scene at a time in [0, 1]; its motion goes on a little beyond.
  SynthMoment at(double time) const;
  /// A box that holds all of it at all times of [0, 1], the room too; scene units.
  Box box() const;
  bool has_gas() const;

  struct Content;

 private:
  explicit SynthScene(std::shared_ptr<const Content> content) : content_(std::move(content)) {}
  std::shared_ptr<const Content> content_;
};

/// The scene at one time, ready to be looked at. Const use from several threads is safe.
class SynthMoment {
 public:
  /// The first surface along the ray, none if the ray meets nothing.
  std::optional<SynthHit> trace(const Ray& ray) const;
  /// Where a point of a body's material is now. Exact for points on or near the body at rest.
  Vec3d world_from_rest(int body, const Vec3d& rest) const;
  /// Signed distance of a world point to the surface of a body, a lower bound; negative inside.
  double distance(int body, const Vec3d& world) const;
  /// Null: the scene has no gas. Lives as long as the moment.
  const SynthVolume* gas() const;
  int bodies() const;
  int subjects() const;  ///< how many of them, the first ones, are the subject: all but the room

  struct Posed;
  explicit SynthMoment(std::shared_ptr<const Posed> posed) : posed_(std::move(posed)) {}

 private:
  friend class SynthScene;
  std::shared_ptr<const Posed> posed_;
};

/// Called after every finished picture, from one thread at a time.
using SynthProgress = std::function<void(int done, int total)>;

/// The whole data set in memory: train, val and test as load_dataset would return them for write_synth's
/// folder, with the same pixels (8 bit). Train cameras are drawn by the seed from the upper hemisphere of
/// radius 4; val and test cameras go round on a smooth path. A rig's cameras stand in a ring of two heights.
/// The fingerprint is its own, not that of the folder.
Dataset make_synth(const std::string& scene, const SynthOptions& options = {},
                   const SynthProgress& progress = {});

/// Writes the data set as a D-NeRF folder (transforms_*.json, straight-alpha PNG) and, for each test picture
/// r_NNN, truth/r_NNN_0000.exr with layers `position` (X, Y, Z) and `rest` (R, G, B) and the channel `depth`
/// (along the viewing axis), 32-bit, point samples at pixel centres, 0 where nothing is hit. A scene of gas
/// alone has no such files; its volumes are SynthMoment::gas.
///
/// Frames of a rig have `camera_id` and, with masks, `mask_path` (masks/SPLIT/NAME.png). Beside them is
/// truth.json: each camera's gains and time offset, in time and in intervals, the interval and the box of all
/// there is.
///
/// Depth is in depth/train/NAME.exr, channel Z (depth_file_path); depth_unit_scale_factor is 1 where it is
/// metric.
///
/// Tracks are in tracks.npy (tracks_file_path): places of shape (points, training pictures, 2), not a number
/// where a point is not visible.
///
/// Throws Error: Fault::input for the scene's name or an option out of range, Fault::output for anything that
/// cannot be written. The transforms files are written last.
void write_synth(const std::string& scene, const std::string& folder, const SynthOptions& options = {},
                 const SynthProgress& progress = {});

}  // namespace splinevox
