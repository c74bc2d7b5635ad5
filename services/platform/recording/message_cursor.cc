#include "services/platform/recording/message_cursor.h"

#include <algorithm>

#include "engrave/core/try.h"
#include "services/platform/recording/chunk_codec.h"

namespace intaglio::recording {

MessageCursor::MessageCursor(const McapReader& reader, MessageQuery query)
    : reader_(reader), query_(std::move(query)) {
  for (const MessageBlock& block : reader.contents().blocks) {
    if (Wants(block)) waiting_.push_back(&block);
  }
  std::stable_sort(waiting_.begin(), waiting_.end(),
                   [](const MessageBlock* a, const MessageBlock* b) {
                     return a->start_ns < b->start_ns;
                   });
  std::reverse(waiting_.begin(), waiting_.end());
}

bool MessageCursor::Wants(const MessageBlock& block) const {
  if (block.end_ns < query_.from_ns || (query_.to_ns && block.start_ns >= *query_.to_ns))
    return false;
  if (!query_.channels || block.channels.empty()) return true;
  return std::any_of(block.channels.begin(), block.channels.end(),
                     [&](std::uint16_t id) { return query_.channels->contains(id); });
}

Status MessageCursor::OpenNextBlock() {
  const MessageBlock& block = *waiting_.back();
  waiting_.pop_back();
  auto records = INTAGLIO_TRY(reader_.ReadBlock(block));
  OpenBlock open;
  open.records = std::move(records);
  open.offset = block.offset;
  const auto& channels = reader_.contents().channels;
  ForEachRecord(open.records, [&](Opcode opcode, ByteView content, std::size_t) {
    MessageView message;
    if (opcode != Opcode::kMessage || !Decode(content, message)) return true;
    if (message.log_time_ns < query_.from_ns ||
        (query_.to_ns && message.log_time_ns >= *query_.to_ns) ||
        !channels.contains(message.channel_id) ||
        (query_.channels && !query_.channels->contains(message.channel_id))) {
      return true;
    }
    open.messages.push_back(message);
    return true;
  });
  std::stable_sort(open.messages.begin(), open.messages.end(),
                   [](const MessageView& a, const MessageView& b) {
                     return a.log_time_ns < b.log_time_ns;
                   });
  if (!open.messages.empty()) open_.push_back(std::move(open));
  return {};
}

Result<std::optional<MessageView>> MessageCursor::Next() {
  // Here and not when the last message was given: its payload lies in the block.
  std::erase_if(
      open_, [](const OpenBlock& block) { return block.next == block.messages.size(); });
  const auto earlier = [](const OpenBlock& a, const OpenBlock& b) {
    const auto time_a = a.messages[a.next].log_time_ns;
    const auto time_b = b.messages[b.next].log_time_ns;
    return time_a != time_b ? time_a < time_b : a.offset < b.offset;
  };
  for (;;) {
    const auto first = std::min_element(open_.begin(), open_.end(), earlier);
    const bool settled =
        first != open_.end() &&
        (waiting_.empty() ||
         waiting_.back()->start_ns > first->messages[first->next].log_time_ns);
    if (settled) return first->messages[first->next++];
    if (waiting_.empty()) return std::nullopt;
    if (auto opened = OpenNextBlock(); !opened) return tl::unexpected(opened.error());
  }
}

}  // namespace intaglio::recording
