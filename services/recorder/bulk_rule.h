#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "services/platform/recording/bulk.h"

namespace intaglio::recorder {

/// What --bulk keeps: of topics that grow with a job's points all, one message in ten of
/// a channel, or none. State, commands, safety, outcomes of pulses are always recorded.
/// From one thread.
class BulkRule {
 public:
  explicit BulkRule(recording::Bulk bulk);

  const recording::BulkRequest& request() const { return request_; }
  /// Whether the topic is recorded at all.
  bool Takes(const std::string& topic) const;
  /// Whether the next message of a channel of that topic is recorded.
  bool Keeps(const std::string& topic, std::uint32_t channel);

 private:
  recording::BulkRequest request_;
  std::map<std::uint32_t, std::uint64_t> received_;  // by channel of a thinned topic
};

}  // namespace intaglio::recorder
