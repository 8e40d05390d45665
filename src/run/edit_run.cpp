// SPDX-License-Identifier: Apache-2.0
#include "run/edit_run.hpp"

#include <filesystem>
#include <utility>

#include "core/atomic_file.hpp"
#include "io/manifest.hpp"
#include "run/edit_session.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/model_vdb.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {

EditedRun edit_run(const std::string& path, const std::string& out, const std::vector<AskedEdit>& asked,
                   const std::function<void(const std::string&)>& say) {
  if (asked.empty())
    fail({"edit", "there is nothing to do", "one operation or more", "", "splinevox edit --help lists them"});
  if (fs::exists(fs::path(out) / "config.toml"))
    fail({out, "this folder already holds a run", "a name that is free: a run is never changed", "",
          "another folder for --out"});
  Run run = open_run(path);
  const std::string from = run.path;
  const ModelNotes notes = run.notes;
  RunFolder folder(out, false);
  Json steps = read_history_if_there(from + "/" + kEditHistory);
  EditSession session(std::move(run), say);
  for (const AskedEdit& a : asked) session.apply(a.operation, a.value);
  steps.push_back(
      {{"from", whole_path(from).string()}, {"splinevox", kVersion}, {"operations", session.done()}});
  Manifest manifest{"run", {{"splinevox", kVersion}, {"edited", "yes"}}, {}};
  const std::string config = read_text(from + "/config.toml");
  // The model first: one that cannot be written leaves no run behind.
  const FileDigest model = save_model(folder.file("model.vdb"), session.model(), notes);
  if (const std::string pictures = read_text_if_there(from + "/" + kTrainingPictures); !pictures.empty())
    manifest.files.push_back({kTrainingPictures, write_file(folder.file(kTrainingPictures), {pictures}), {}});
  manifest.files.push_back({"config.toml", write_file(folder.file("config.toml"), {config}), {}});
  manifest.files.push_back({"model.vdb", model, {}});
  manifest.files.push_back(
      {kEditHistory, write_file(folder.file(kEditHistory), {json_text({{"history", steps}}, 2) + "\n"}), {}});
  write_manifest(folder.path(), manifest);
  return {folder.path(), session.done()};
}

}  // namespace splinevox::run
