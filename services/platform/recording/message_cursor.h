#pragma once

// The messages of a recording in the order of their log time (reception); of one time, in
// the order of the file. Holds the chunks that overlap in time and no others: one or two
// of a recorder's file.

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::recording {

struct MessageQuery {
  std::uint64_t from_ns = 0;  ///< log time, included
  /// Not included; absent: to the end.
  std::optional<std::uint64_t> to_ns = std::nullopt;
  std::optional<std::set<std::uint16_t>> channels = std::nullopt;  ///< absent: all
};

class MessageCursor {
 public:
  /// The reader has to outlive the cursor.
  explicit MessageCursor(const McapReader& reader, MessageQuery query = {});

  /// The next message, valid until the next call; nothing at the end. An error reports a
  /// chunk that cannot be read: its messages are missing, and the next call goes on.
  Result<std::optional<MessageView>> Next();

 private:
  struct OpenBlock {
    Bytes records;
    std::vector<MessageView> messages;  // into `records`, by log time
    std::size_t next = 0;
    std::uint64_t offset = 0;
  };
  bool Wants(const MessageBlock& block) const;
  Status OpenNextBlock();

  const McapReader& reader_;
  MessageQuery query_;
  std::vector<const MessageBlock*> waiting_;  // by start, the next at the back
  std::vector<OpenBlock> open_;
};

}  // namespace intaglio::recording
