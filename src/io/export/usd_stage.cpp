// SPDX-License-Identifier: Apache-2.0
#include "io/export/usd_stage.hpp"

#include "io/export/usd_text.hpp"
#include "io/model/exact_text.hpp"

namespace splinevox {
namespace {

constexpr const char* kRoot = "splinevox";

std::string point(Vec3 v) {
  std::string text;
  for (int a = 0; a < 3; ++a) text += (a ? ", " : "(") + exact_text<float>({v[a]});
  return text + ")";
}

/// Every line further in.
std::string indented(const std::string& text) {
  std::string out;
  bool fresh = true;
  for (const char c : text) {
    if (fresh && c != '\n') out += "    ";
    out += c;
    fresh = c == '\n';
  }
  return out;
}

std::string field_prim(const UsdSequence& s, const UsdVolume& volume, const UsdField& field) {
  std::string text = "\n    def OpenVDBAsset \"" + field.name + "\"\n    {\n";
  text += "        token fieldName = \"" + field.name + "\"\n";
  text += "        token fieldDataType = \"" + field.data_type + "\"\n";
  text += "        token fieldClass = \"fogVolume\"\n";
  text += "        token vectorDataRoleHint = \"" + field.role + "\"\n";
  text += "        asset filePath.timeSamples = {\n";
  for (std::size_t i = 0; i < volume.files.size(); ++i)
    text += "            " + std::to_string(s.frames[i]) + ": @./" + volume.files[i] + "@,\n";
  return text + "        }\n    }\n";
}

/// @param path  of the prim around it
std::string volume_prim(const UsdSequence& s, const UsdVolume& volume, const std::string& name,
                        const std::string& path) {
  std::string text = "def Volume \"" + name + "\"\n{\n";
  text += "    float3[] extent = [" + point(s.lo) + ", " + point(s.hi) + "]\n";
  for (const UsdField& field : s.fields)
    text += "    rel field:" + field.name + " = <" + path + "/" + name + "/" + field.name + ">\n";
  for (const UsdField& field : s.fields) text += field_prim(s, volume, field);
  return text + "}\n";
}

std::string reference(const UsdLayer& layer) {
  return "def " + layer.type + " \"" + layer.name + "\" (\n    prepend references = @./" + layer.file +
         "@\n)\n{\n}\n";
}

}  // namespace

std::string usd_stage(const UsdSequence& s) {
  std::string text = usd_head(
      kRoot, {s.frames.front(), s.frames.back(), s.fps},
      "Density is extinction per scene unit, colour is emitted per density, velocity is in scene units "
      "per second.");
  if (s.volumes.size() == 1 && s.layers.empty()) return text + volume_prim(s, s.volumes[0], kRoot, "");
  text += "def Xform \"" + std::string(kRoot) + "\"\n{\n";
  for (std::size_t v = 0; v < s.volumes.size(); ++v) {
    if (v > 0) text += "\n";
    const std::string& name = s.volumes[v].name;
    text += indented(volume_prim(s, s.volumes[v], name.empty() ? "volume" : name, std::string("/") + kRoot));
  }
  for (const UsdLayer& layer : s.layers) text += "\n" + indented(reference(layer));
  return text + "}\n";
}

std::string with_cameras(std::string stage, bool shown) {
  const std::string line = std::string("    subLayers = [@./") + kCamerasUsd + "@]\n";
  const std::size_t before = stage.find("    timeCodesPerSecond"), there = stage.find(line);
  if (there < before && !shown) stage.erase(there, line.size());
  if (there >= before && shown) stage.insert(before, line);
  return stage;
}

}  // namespace splinevox
