#pragma once

// What a recording has not: what was missing when it was made, and what it leaves out by
// request: the topics that grow with the points of a job
// (models, points, motion, positions) are most of its size. Which topics these are is in
// the file (conventions.h), not here.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::recording {

enum class Bulk {
  kAll,   ///< everything is recorded
  kThin,  ///< of bulk topics one message in `one_of`, models not at all
  kNone,  ///< no bulk topic
};

/// "all", "thin", "none".
const char* NameOf(Bulk bulk);
/// None for another name.
std::optional<Bulk> BulkFromName(std::string_view name);

struct BulkRequest {
  Bulk bulk = Bulk::kAll;
  std::vector<std::string> left_out;  ///< topics
  std::vector<std::string> thinned;   ///< topics
  unsigned one_of = 1;                ///< of the thinned: the first of so many is kept
};

/// As entries of the metadata record `recording`; none for Bulk::kAll.
TextMap EntriesOf(const BulkRequest& request);

/// What the recording says of itself; of a merged one, all of its sources together. A
/// recording of others, or one whose metadata cannot be read, has Bulk::kAll.
BulkRequest BulkRequestOf(const McapReader& reader);

/// "the recording leaves out bulk topics by request (--bulk none): ModelChunk, ..."; ""
/// for Bulk::kAll.
std::string SentenceOf(const BulkRequest& request);

/// What the recorder counted as missing, one a topic and reason: "1200 messages of
/// PulseEventBatch are missing: the disk is too slow". Empty where it cannot be read.
std::vector<std::string> MissingSentences(const McapReader& reader);

}  // namespace intaglio::recording
