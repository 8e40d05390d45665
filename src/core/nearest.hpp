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

/// The known word that one may have meant; "" if none is like it. One that has it as its first or last words
/// counts before all others ("--steps" of "--max-steps").
inline std::string likely(std::string_view word, const std::vector<std::string>& known) {
  const std::string_view bare = word.substr(std::min(word.find_first_not_of('-'), word.size()));
  const std::string first = std::string(bare) + '-', last = '-' + std::string(bare);
  for (const std::string& k : known) {
    const std::string_view name = std::string_view(k).substr(std::min(k.find_first_not_of('-'), k.size()));
    if (!bare.empty() && (name.starts_with(first) || name.ends_with(last))) return k;
  }
  const std::string best = nearest(word, known);
  return edit_distance(word, best) <= std::max(2, int(bare.size()) / 3) ? best : "";
}

}  // namespace splinevox
