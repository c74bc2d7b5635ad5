#pragma once

// Messages with storage of their own, to compare what was written with what is read.

#include <filesystem>
#include <fstream>
#include <vector>

#include "services/platform/recording/message_cursor.h"

namespace intaglio::recording {

struct Recorded {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  Bytes payload;
  bool operator==(const Recorded&) const = default;
  MessageView view() const {
    return {channel_id, sequence, log_time_ns, publish_time_ns, payload};
  }
};

/// What the cursor gives; blocks that cannot be read are left out.
inline std::vector<Recorded> MessagesOf(const McapReader& reader,
                                        const MessageQuery& query = {}) {
  std::vector<Recorded> all;
  MessageCursor cursor(reader, query);
  for (;;) {
    const auto next = cursor.Next();
    if (!next) continue;
    if (!*next) return all;
    const MessageView& m = **next;
    all.push_back({m.channel_id, m.sequence, m.log_time_ns, m.publish_time_ns,
                   Bytes(m.payload.begin(), m.payload.end())});
  }
}

inline Bytes BytesOf(const std::filesystem::path& file) {
  Bytes bytes(std::filesystem::file_size(file));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

}  // namespace intaglio::recording
