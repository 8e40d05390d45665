// SPDX-License-Identifier: Apache-2.0
#include "data/mask_notes.hpp"

#include <fmt/format.h>

#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

using What = MaskUse::What;

std::string share(double part) { return fmt::format("{:.{}f}%", 100 * part, part > 0 && part < 0.1 ? 1 : 0); }

/// "white on average 4.1%, of 32 looked at".
std::string look_text(const MaskLook& look, const MaskSearch& found) {
  std::string text = "on average " + share(look.mean) + " white";
  if (look.looked_at < found.found) text += fmt::format(" in {} looked at", look.looked_at);
  if (look.black > 0) text += fmt::format(", {} of them wholly black", look.black);
  if (look.white > 0) text += fmt::format(", {} of them wholly white", look.white);
  return text;
}

/// Whether all masks that were looked at leave nothing.
bool leave_nothing(const MaskLook& look, bool keeps_black) {
  return (keeps_black ? look.white : look.black) == look.looked_at;
}

/// What masks that are used say, by the colour of what is kept.
std::string meaning(What what, bool keeps_black) {
  const char *kept = keeps_black ? "black" : "white", *other = keeps_black ? "white" : "black";
  if (what == What::subject)
    return fmt::format("masks show the subject: what is {} is the scene, all else is empty", kept);
  if (what == What::moving)
    return fmt::format("masks say what moves: what is {} may, all else stands still", other);
  return fmt::format("masks say what to ignore: what is {} is neither drawn nor scored", other);
}

/// Throws Error for masks that number the parts of a picture.
void refuse_numbers(const MaskLook& look, const std::string& where) {
  if (look.black == look.looked_at && look.brightest > 0 && look.brightest < kLabels)
    fail({where, "the masks are all but black: they seem to be numbers of parts", "black and white",
          fmt::format("no value above {} of 255", look.brightest / 257),
          "make them white where the parts that are meant are"});
}

/// Throws Error where some masks have 0 and 1, which is white, and others higher numbers, which are not.
void refuse_ones(const MaskLook& look, const std::string& where) {
  if (look.ones > 0 && look.numbers > 0)
    fail({where, "the masks seem to be numbers of parts", "black and white",
          fmt::format("{} of {} with 0 and 1, {} with higher numbers below 32 of 255", look.ones,
                      look.looked_at, look.numbers),
          "make them white where the parts that are meant are"});
}

/// Masks that leave nothing are meant otherwise, or are no masks.
[[noreturn]] void fail_nothing(const MaskLook& look, const MaskUse& use, bool keeps_black,
                               const std::string& where) {
  refuse_numbers(look, where);
  if (use.what == What::moving)
    fail({where, fmt::format("every mask is wholly {}: all would move", keeps_black ? "white" : "black"),
          "masks that show what moves", fmt::format("{} masks, --masks {}", look.looked_at, use.text),
          opposite_masks(use, keeps_black)});
  fail({where, fmt::format("every mask is wholly {}: nothing would be left", keeps_black ? "white" : "black"),
        use.what == What::subject ? "masks that show where the scene is"
                                  : "masks that leave something of the pictures",
        fmt::format("{} masks, --masks {}", look.looked_at, use.text), opposite_masks(use, keeps_black)});
}

}  // namespace

std::string opposite_masks(const MaskUse& use, bool keeps_black) {
  if (use.what == What::subject) return keeps_black ? "--masks subject" : "--masks subject-black";
  if (use.what == What::moving) return keeps_black ? "--masks moving-black" : "--masks moving";
  return keeps_black ? "--masks ignore-black" : "--masks ignore-white";
}

std::optional<DatasetMasks> note_masks(const OpenScene& open, const std::vector<PicturePlan>& plans,
                                       std::vector<std::string>& notes) {
  const MaskSearch& found = open.masks;
  const MaskUse& use = open.mask_use;
  if (found.absent > 0 && use.what != What::none)
    notes.push_back(fmt::format("{} masks that the data names are not there, first {}", found.absent,
                                in_quotes(found.first_absent)));
  if (found.found == 0) return {};
  DatasetMasks out{use.text, found.found, found.frames, found.first, 0, 0};
  if (use.what == What::none) return out;
  std::vector<const MaskPlan*> masks;
  std::size_t misfits = 0;
  std::string misfit, where;
  for (const PicturePlan& plan : plans) {
    masks.push_back(&plan.masks);
    misfits += plan.masks.misfits;
    if (misfit.empty()) misfit = plan.masks.misfit;
    for (std::size_t i = 0; where.empty() && i < plan.masks.files.size(); ++i)
      if (!plan.masks.files[i].empty()) where = plan.masks.where[i];
  }
  MaskLook look;
  std::string looks;
  try {
    look = look_at_masks(masks);
    out.looked_at = look.looked_at;
    out.white = look.mean;
    if (look.looked_at > 0) looks = ", " + look_text(look, found);
  } catch (const Error& error) {
    if (use.used()) throw;
    looks = ". They cannot be used: " + error.problem.where + ": " + error.problem.what;
  }
  if (misfits > 0) looks += fmt::format(". {} cannot be used: {}", misfits, misfit);
  if (found.several > 0)
    looks += fmt::format(". For {} pictures there are several, such as {}: the first is taken", found.several,
                         found.first_several);
  const std::string there = fmt::format("{} of {} pictures have one, such as {}{}", found.found, found.frames,
                                        in_quotes(found.first), looks);
  if (use.what == What::unsaid) {
    notes.push_back("masks are not used: " + there +
                    ". --masks subject takes white as the scene and all else as empty; --masks ignore passes "
                    "over what is black (ignore-white: white); --masks moving takes white as what moves; "
                    "--masks none says that this is right");
    return out;
  }
  refuse_ones(look, where);
  const bool black = use.keeps_black(found.first);
  if (look.looked_at > 0 && leave_nothing(look, black)) {
    look = look_at_masks(masks, found.found);  // some of those not looked at may leave something
    if (leave_nothing(look, black)) fail_nothing(look, use, black, where);
  }
  if (use.what == What::moving && look.looked_at > 0) refuse_numbers(look, where);
  notes.push_back(meaning(use.what, black) + "; " + there);
  return out;
}

}  // namespace splinevox::data
