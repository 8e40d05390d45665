// SPDX-License-Identifier: Apache-2.0
#include "io/export/usd_stage.hpp"

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

}  // namespace

std::string usd_stage(const UsdSequence& s) {
  const std::string fps = exact_text<double>({s.fps}), last = std::to_string(s.frames.back());
  std::string text = "#usda 1.0\n(\n    defaultPrim = \"" + std::string(kRoot) + "\"\n";
  text +=
      "    doc = \"Density is extinction per scene unit, colour is emitted per density, velocity is in scene "
      "units ";
  text += "per second.\"\n";
  text += "    endTimeCode = " + last + "\n    framesPerSecond = " + fps + "\n    metersPerUnit = 1\n";
  text +=
      "    startTimeCode = " + std::to_string(s.frames.front()) + "\n    timeCodesPerSecond = " + fps + "\n";
  text += "    upAxis = \"Z\"\n)\n\n";
  if (s.volumes.size() == 1) return text + volume_prim(s, s.volumes[0], kRoot, "");
  text += "def Xform \"" + std::string(kRoot) + "\"\n{\n";
  for (std::size_t v = 0; v < s.volumes.size(); ++v) {
    if (v > 0) text += "\n";
    text += indented(volume_prim(s, s.volumes[v], s.volumes[v].name, std::string("/") + kRoot));
  }
  return text + "}\n";
}

}  // namespace splinevox
