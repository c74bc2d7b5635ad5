#pragma once

// Which topics are recorded or played: all, or those whose names match patterns. A
// pattern may have * (any characters) and ? (one).

#include <string>
#include <vector>

namespace intaglio::bus {

/// Names that match a pattern of `only` (any name when that is empty), and none of
/// `not_`.
struct NameFilter {
  std::vector<std::string> only, not_;
  bool Accepts(const std::string& name) const;
};

struct TopicFilter {
  NameFilter topic, partition, type;
  /// `partitions`: separated by commas; one that is accepted suffices. Without a
  /// partition, in that of a role, or in "*", which is every machine's, only the other
  /// two are asked.
  bool Accepts(const std::string& topic_name, const std::string& partitions,
               const std::string& type_name) const;
};

}  // namespace intaglio::bus
