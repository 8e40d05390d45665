// SPDX-License-Identifier: Apache-2.0
#include "run/effects_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "run/html.hpp"
#include "splinevox/math/basis.hpp"
#include "train/effects/effect_table.hpp"

namespace splinevox::run {
namespace {

const char* name_of(EffectDecision d) {
  switch (d) {
    case EffectDecision::on:
      return "on";
    case EffectDecision::off:
      return "off";
    case EffectDecision::undecided:
      return "undecided";
    case EffectDecision::confounded:
      return "confounded";
    case EffectDecision::proved:
      return "proved";
  }
  return "";
}

const char* name_of(StillVerdict v) {
  switch (v) {
    case StillVerdict::changed:
      return "changed";
    case StillVerdict::unchanged:
      return "unchanged";
    case StillVerdict::unsure:
      return "unsure";
  }
  return "";
}

Json finite(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

std::string decibels(const Json& effect, const char* key) {
  const Json v = effect.value(key, Json());
  return v.is_number() ? fmt::format("{:+.2f} dB", v.get<double>()) : "?";
}

/// Of a clock that was tried the offset that is furthest from none; empty: it was not.
std::string latest(const Json& effect) {
  double most = 0;
  if (!effect.contains("offsets")) return {};
  for (const Json& o : effect["offsets"])
    if (const double frames = o.value("frames", 0.0); std::abs(frames) > std::abs(most)) most = frames;
  return fmt::format("{:+.2f} frames at most", most);
}

/// Of exposure how far cameras are apart by their pictures; empty: they were not asked.
std::string brightness_apart(const Json& effect) {
  if (!effect.contains("apart")) return {};
  return fmt::format("cameras {:.0f}% apart in brightness", 100 * effect["apart"].get<double>());
}

/// Of each effect whether it is on, or its order.
Json set_json(const EffectSet& effects) {
  Json j;
  for (const Effect e : kAllEffects)
    j[to_string(e)] = facts_of(e).ordered ? Json(effects.order(e)) : Json(effects.has(e));
  return j;
}

/// The verdict on an effect: of a long sequence and a stretch of it the first that says on, or else the last;
/// null: it was not judged.
const EffectVerdict* verdict_on(const EffectChoice& choice, Effect effect) {
  const EffectVerdict* found = nullptr;
  for (const EffectVerdict& v : choice.verdicts)
    if (v.effect == effect && !(found && found->decision == EffectDecision::on)) found = &v;
  return found;
}

/// Notes beside the effects: the choice's own, and the confounded effects of a film that are not used.
std::vector<std::string> notes_on(const Json& effects) {
  std::vector<std::string> notes;
  if (const Json still = effects.value("still_cameras", Json()); still.is_object())
    notes.push_back(fmt::format(
        "{} cameras stand still: {:.2f}% of their pixels change, in {} of them more than {:.2f}%{}",
        still.value("cameras", 0), 100 * still.value("share", 0.0), still.value("changing", 0),
        100 * still.value("threshold", 0.0),
        still.value("verdict", "") == "changed" ? ", which proves change" : ""));
  if (const Json film = effects.value("film", Json()); film.is_object() && film.value("given", false))
    notes.push_back(fmt::format("masks say what moves: {:.2f}% of the pixels, in {} pictures{}",
                                100 * film.value("share", 0.0), film.value("pictures", 0),
                                film.value("moves", false) ? "" : ", too little to be anything"));
  else if (film.is_object())
    notes.push_back(fmt::format(
        "a film of one camera on its way: a still world shows it at {:.1f} dB, but for {:.2f}% of its "
        "pixels",
        film.value("psnr", 0.0), 100 * film.value("share", 0.0)));
  if (const std::string note = effects.value("note", ""); !note.empty()) notes.push_back(note);
  std::string named;
  bool any = false, moves = false;
  for (const Json& e : effects.at("effects")) {
    const std::string name = e.value("effect", "");
    const bool used = e.value("used", false), told = !used && e.value("decision", "") == "confounded",
               confounded = told && (name == to_string(Effect::motion) || name == to_string(Effect::light));
    any |= confounded;
    moves |= used && name == to_string(Effect::motion);
    if (told && name == to_string(Effect::presence))
      notes.push_back("presence gains, but no more than what only moves may gain by it: it is left out");
    if (told && name == to_string(Effect::drift))
      notes.push_back(
          "gains that drift help, but in parts of the pictures, as highlights do: they are left out");
    if (!used && !confounded) continue;
    named += (named.empty() ? "" : ",") + name;
    const std::optional<Effect> effect = effect_named(name);
    for (const Effect other : kAllEffects)
      if (confounded && effect && facts_of(other).needs == effect)
        named += std::string(",") + to_string(other);
  }
  if (any && !moves)
    notes.push_back(
        "a film: changes may come from the camera as well as from time, and the scene is taken to be "
        "static; if it is not, say so: --effects " +
        named);
  return notes;
}

}  // namespace

Json effects_json(const Prepared& prepared) {
  const EffectChoice& choice = prepared.effects;
  const EffectSet& used = prepared.used;
  Json j{{"used", set_json(used)},
         {"chosen", set_json(choice.chosen)},
         {"forced", prepared.policy != EffectPolicy::choose}};
  j["view_told_by_time"] = choice.view_told_by_time.value_or(0);
  if (choice.still)
    j["still_cameras"] = {{"verdict", name_of(choice.still->verdict)},
                          {"cameras", choice.still->cameras},
                          {"changing", choice.still->changing},
                          {"share", choice.still->share},
                          {"threshold", choice.still->threshold}};
  if (choice.film && choice.film->given)
    j["film"] = {{"given", true},
                 {"moves", choice.film->moves()},
                 {"share", choice.film->share},
                 {"threshold", choice.film->threshold},
                 {"pictures", choice.film->pictures}};
  else if (choice.film)
    j["film"] = {{"moves", choice.film->moves()},     {"share", choice.film->share},
                 {"coloured", choice.film->coloured}, {"threshold", choice.film->threshold},
                 {"pictures", choice.film->pictures}, {"psnr", choice.film->psnr},
                 {"seconds", choice.film->seconds}};
  j["held_pictures"] = choice.held_out;
  j["seconds"] = choice.seconds;
  j["note"] = choice.note;
  j["effects"] = Json::array();
  for (const Effect effect : kAllEffects) {
    Json e{{"effect", to_string(effect)}, {"used", used.has(effect)}};
    if (const EffectVerdict* v = verdict_on(choice, effect)) {
      e["decision"] = name_of(v->decision);
      if (effect != Effect::clock) {
        e["gain_db"] = v->gain.mean;
        e["gain_lo"] = finite(v->gain.lo);
        e["gain_hi"] = finite(v->gain.hi);
        e["p"] = v->gain.p;
        e["time_ratio"] = v->time_ratio;
        e["bytes_ratio"] = v->bytes_ratio;
      }
      for (const ClockDoubt& d : v->clocks)
        e["offsets"].push_back({{"camera", d.camera},
                                {"pictures", d.offset.count},
                                {"frames", d.offset.mean},
                                {"frames_lo", finite(d.offset.lo)},
                                {"frames_hi", finite(d.offset.hi)}});
      if (v->spread) e["spread"] = *v->spread;
      if (v->apart) e["apart"] = *v->apart;
      if (v->whole) e["whole"] = *v->whole;
      if (v->where < 1) e["where"] = v->where;
      if (v->far) e["far"] = *v->far;
      if (v->least_matter) e["least_matter"] = *v->least_matter;
      e["beside"] = to_string(v->with.without(effect));
    } else if (effect == Effect::motion && choice.film && !choice.film->unexplained()) {
      e["decision"] = name_of(EffectDecision::off);
    }
    const bool neither = !used.has(effect) && !e.contains("decision");  // neither used nor tried
    if (!((facts_of(effect).opaque_only || facts_of(effect).taken_by != TakenBy::any) && neither))
      j["effects"].push_back(e);
  }
  j["fits"] = Json::array();
  for (const EffectTrial& t : choice.trials)
    j["fits"].push_back({{"effects", to_string(t.effects)},
                         {"points", t.points},
                         {"psnr", t.mean()},
                         {"steps", t.steps},
                         {"seconds", t.seconds},
                         {"bytes", t.bytes}});
  j["control_points"] = {{"chosen", choice.points},
                         {"at_end", points_at_end(prepared.config.motion)},
                         {"compared", Json::array()}};
  for (const PointsVerdict& v : choice.points_verdicts)
    j["control_points"]["compared"].push_back({{"more", v.more},
                                               {"fewer", v.fewer},
                                               {"gain_db", v.gain.mean},
                                               {"gain_lo", finite(v.gain.lo)},
                                               {"gain_hi", finite(v.gain.hi)}});
  return j;
}

std::vector<std::string> effects_lines(const Json& effects) {
  std::string used, not_used;
  bool undecided = false;
  for (const Json& e : effects.at("effects")) {
    std::string& list = e.at("used").get<bool>() ? used : not_used;
    list += (list.empty() ? "" : ", ") + e.at("effect").get<std::string>();
    if (const std::string offset = latest(e); !offset.empty()) list += fmt::format(" ({})", offset);
    if (const std::string apart = brightness_apart(e);
        !apart.empty() && e.at("decision") == name_of(EffectDecision::on))
      list += fmt::format(" ({})", apart);
    else if (e.contains("gain_db")) {
      const std::string decision = e.at("decision");
      const bool plain = decision == (e.at("used").get<bool>() ? "on" : "off");
      undecided |= decision == name_of(EffectDecision::undecided);
      const std::string where =
          e.contains("where") ? fmt::format(" in {:.1f}% of the pictures", 100 * e.at("where").get<double>())
                              : "";
      list += fmt::format(" ({}{}{})", decibels(e, "gain_db"), where, plain ? "" : ", " + decision);
    }
  }
  std::string line = "effects: " + (used.empty() ? "none" : used);
  if (!not_used.empty()) line += "; without " + not_used;
  if (const Json& points = effects.at("control_points"); !points.at("compared").empty())
    line += fmt::format("; {} control points in the end", points.at("at_end").get<int>());
  std::vector<std::string> lines{line};
  if (undecided)
    lines.push_back("  undecided: the fits are too short to tell; effects.json has the range of the gain");
  for (const std::string& note : notes_on(effects)) lines.push_back("  " + note);
  return lines;
}

std::string effects_table(const Json& effects) {
  if (!effects.is_object() || !effects.contains("effects")) return {};
  std::string html =
      "<h3>Effects</h3><table><tr><th>effect</th><th>used</th><th>decision</th><th>gain on held-out "
      "pictures</th><th>between</th><th>time a step</th><th>memory</th></tr>";
  for (const Json& e : effects["effects"]) {
    html += fmt::format("<tr><td>{}</td><td>{}</td>", escape(e.value("effect", "")),
                        e.value("used", false) ? "yes" : "no");
    if (e.contains("gain_db"))
      html += fmt::format(
          "<td>{}</td><td>{}{}{}{}</td><td>{} and {}</td><td>{:.2f}x</td><td>{:.2f}x</td></tr>",
          escape(e.value("decision", "")), decibels(e, "gain_db"),
          e.contains("where") ? fmt::format(" where only it explains the pictures, {:.1f}% of them",
                                            100 * e["where"].get<double>())
                              : "",
          e.contains("far")
              ? fmt::format("; {:.2f}% of what they show goes far", 100 * e["far"].get<double>())
              : "",
          e.contains("apart") ? "; " + brightness_apart(e) : "", decibels(e, "gain_lo"),
          decibels(e, "gain_hi"), e.value("time_ratio", 1.0), e.value("bytes_ratio", 1.0));
    else if (e.contains("offsets"))
      html += fmt::format("<td>{}</td><td>{}</td><td></td><td></td><td></td></tr>",
                          escape(e.value("decision", "")), latest(e));
    else if (e.contains("decision"))
      html += fmt::format("<td>{}</td><td></td><td></td><td></td><td></td></tr>",
                          escape(e.value("decision", "")));
    else
      html += "<td>not tried</td><td></td><td></td><td></td><td></td></tr>";
  }
  html += "</table>";
  for (const std::string& note : notes_on(effects))
    html += fmt::format("<p class=\"note\">{}</p>", escape(note));
  if (effects.value("forced", false)) html += "<p class=\"note\">What is used was asked for, not chosen.</p>";
  return html;
}

}  // namespace splinevox::run
