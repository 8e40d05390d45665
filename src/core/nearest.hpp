// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox {

/// Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
inline int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = int(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = int(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// The known word most like `word`, for "did you mean"; "" if nothing is known. A word that is the tail of a
/// known one after a dot ("lr_color" of "optimiser.lr_color") counts as a match of the whole.
inline std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  int best_distance = -1;
  for (const std::string& k : known) {
    const std::string_view tail = std::string_view(k).substr(k.rfind('.') + 1);
    const int d =
        std::min(edit_distance(word, k), edit_distance(word, tail) + (tail.size() < k.size() ? 1 : 0));
    if (best_distance < 0 || d < best_distance) {
      best = k;
      best_distance = d;
    }
  }
  return best;
}

}  // namespace splinevox
