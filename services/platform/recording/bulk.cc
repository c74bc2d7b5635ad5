#include "services/platform/recording/bulk.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <utility>

#include "engrave/core/counted.h"
#include "services/platform/recording/conventions.h"

namespace intaglio::recording {
namespace {

constexpr std::array kNames = {"all", "thin", "none"};  // by Bulk
constexpr char kBulk[] = "bulk";
constexpr char kLeftOut[] = "bulk_left_out";
constexpr char kThinned[] = "bulk_thinned";
constexpr char kOneOf[] = "bulk_one_of";

std::string Entry(const TextMap& entries, const char* name) {
  const auto found = entries.find(name);
  return found == entries.end() ? std::string() : found->second;
}

/// Adds the names of a list separated by commas.
void AddNames(std::string_view list, std::vector<std::string>& names) {
  while (!list.empty()) {
    const auto end = std::min(list.find(','), list.size());
    const std::string name(list.substr(0, end));
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
}

}  // namespace

const char* NameOf(Bulk bulk) { return kNames[static_cast<std::size_t>(bulk)]; }

std::optional<Bulk> BulkFromName(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Bulk>(found - kNames.begin());
}

TextMap EntriesOf(const BulkRequest& request) {
  if (request.bulk == Bulk::kAll) return {};
  return {{kBulk, NameOf(request.bulk)},
          {kLeftOut, fmt::format("{}", fmt::join(request.left_out, ","))},
          {kThinned, fmt::format("{}", fmt::join(request.thinned, ","))},
          {kOneOf, std::to_string(request.one_of)}};
}

BulkRequest BulkRequestOf(const McapReader& reader) {
  BulkRequest request;
  const auto records = reader.ReadMetadata(kRecordingRecord);
  if (!records) return request;
  for (const Metadata& record : *records) {
    const auto bulk = BulkFromName(Entry(record.entries, kBulk));
    if (!bulk || *bulk == Bulk::kAll) continue;
    request.bulk = std::max(request.bulk, *bulk);
    AddNames(Entry(record.entries, kLeftOut), request.left_out);
    AddNames(Entry(record.entries, kThinned), request.thinned);
    const std::string one_of = Entry(record.entries, kOneOf);
    (void)std::from_chars(one_of.data(), one_of.data() + one_of.size(), request.one_of);
  }
  return request;
}

std::string SentenceOf(const BulkRequest& request) {
  if (request.bulk == Bulk::kAll) return "";
  std::string sentence;
  if (!request.left_out.empty()) {
    sentence =
        fmt::format("the recording leaves out bulk topics by request (--bulk {}): {}",
                    NameOf(request.bulk), fmt::join(request.left_out, ", "));
  }
  if (!request.thinned.empty()) {
    sentence += fmt::format(
        "{} one message in {} of these bulk topics by request (--bulk thin): {}",
        sentence.empty() ? "the recording has" : "; it has", request.one_of,
        fmt::join(request.thinned, ", "));
  }
  return sentence;
}

std::vector<std::string> MissingSentences(const McapReader& reader) {
  const auto records = reader.ReadMetadata(kMissingRecord);
  if (!records) return {};
  // One a span of time is in the file.
  std::map<std::pair<std::string, std::string>, std::uint64_t> counts;
  for (const Metadata& record : *records) {
    const std::string text = Entry(record.entries, "count");
    std::uint64_t count = 0;
    std::from_chars(text.data(), text.data() + text.size(), count);
    counts[{Entry(record.entries, "topic"), Entry(record.entries, "reason")}] += count;
  }
  std::vector<std::string> sentences;
  for (const auto& [key, count] : counts) {
    const auto& [topic, reason] = key;
    sentences.push_back(count == 0 ? fmt::format("{} is missing: {}", topic, reason)
                                   : fmt::format("{} of {} {} missing: {}",
                                                 Counted(count, "message"), topic,
                                                 IsOrAre(count), reason));
  }
  return sentences;
}

}  // namespace intaglio::recording
