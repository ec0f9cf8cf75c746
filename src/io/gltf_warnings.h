// What a loader passes over, gathered so that a thousand like cases make one sentence.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

namespace omma {

struct GltfWarnings {
  struct Entry {
    std::string sentence, first_place;
    int count = 0;
  };
  std::vector<Entry> entries;
  std::unordered_map<std::string, std::size_t> entry_of;  // by sentence

  // `place` is where the sentence holds, "" for the whole file; the first of `count`.
  void add(const std::string& sentence, const std::string& place = "", int count = 1) {
    const auto [found, is_new] = entry_of.try_emplace(sentence, entries.size());
    if (is_new) entries.push_back({sentence, place, 0});
    entries[found->second].count += count;
  }

  std::vector<std::string> sentences() const {
    std::vector<std::string> result;
    for (const Entry& entry : entries) {
      std::string text = entry.sentence;
      if (!entry.first_place.empty()) text += " (" + entry.first_place;
      if (!entry.first_place.empty() && entry.count > 1)
        text += " and " + std::to_string(entry.count - 1) + " more";
      if (!entry.first_place.empty()) text += ")";
      result.push_back(text);
    }
    return result;
  }
};

}  // namespace omma
