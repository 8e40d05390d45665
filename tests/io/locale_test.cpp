// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <clocale>
#include <locale>

#include "io/manifest.hpp"
#include "scratch.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/train/config.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// German habits for streams, and for the C library where that locale is installed.
class GermanNumbers {
 public:
  GermanNumbers() : before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {
    if (!std::setlocale(LC_NUMERIC, "de_DE.UTF-8"))
      MESSAGE("skipped for the C library: the locale de_DE.UTF-8 is not installed");
  }
  ~GermanNumbers() {
    std::locale::global(before_);
    std::setlocale(LC_NUMERIC, "C");
  }

 private:
  std::locale before_;
};

std::string everything(const std::string& folder) {
  Config config = preset("standard");
  config.run.max_time = 1234.5;
  std::string text = write_config(config);
  spit(folder + "/config.toml", text);
  Config back;
  read_config(back, folder + "/config.toml");
  CHECK(write_config(back) == text);
  save_model(folder + "/model.vdb", blob_model(8));
  ModelNotes notes;
  load_model(folder + "/model.vdb", &notes);
  text += slurp(folder + "/model.vdb");
  Manifest m{"export", {{"fps", "24"}}, {manifest_entry(folder, "model.vdb")}};
  m.files[0].figures["time"] = 1234.25;
  write_manifest(folder, m);
  CHECK(read_manifest(folder).files[0].figures.at("time") == 1234.25);
  return text + slurp(folder + "/manifest.json");
}

}  // namespace

TEST_SUITE("io/locale") {
  TEST_CASE(
      "F19: a decimal comma and grouped thousands change no byte that is written and no number that is "
      "read") {
    const Scratch a, b;
    const std::string plain = everything(a.folder());
    const GermanNumbers german;
    CHECK(everything(b.folder()) == plain);
  }
}
