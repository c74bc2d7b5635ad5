#pragma once

// What late readers would have been given at a place of a recording: the newest samples
// of each instance of the retained (transient-local) topics before it, as many as their
// writers keep.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/recording/idl_types.h"
#include "services/recording/message_cursor.h"
#include "services/replayer/selection.h"

namespace intaglio::replayer {

struct RetainedMessage {
  std::uint16_t channel_id = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  recording::Bytes payload;
};

class Retained {
 public:
  Retained(const recording::McapReader& reader, const Selection& selection);
  /// Of the messages before this log time, in their order.
  std::vector<RetainedMessage> Before(std::uint64_t log_time_ns);
  /// What could not be told apart, a sentence each.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  struct Keyed {
    recording::IdlTypes types;
    std::string value_type;              // name of the schema
    std::vector<std::string> key_names;  // as "member" or "member.member"
    std::size_t depth = 1;
    bool readable = false;
  };
  void Learn(std::uint16_t channel_id, const recording::Stream& stream);
  std::string KeyOf(const Keyed& keyed, recording::ByteView payload);
  using Instance = std::pair<std::string, std::string>;  // topic and partition; key
  void Take(std::map<Instance, std::deque<RetainedMessage>>& kept,
            const recording::MessageView& message);

  const recording::McapReader& reader_;
  const Selection& selection_;
  std::map<std::uint16_t, Keyed> keyed_;                       // by channel
  std::map<std::string, std::vector<std::string>> key_names_;  // by type
  std::vector<std::string> complaints_;
};

}  // namespace intaglio::replayer
