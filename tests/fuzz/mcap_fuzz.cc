// Any bytes as a recording: everything in it is read, within bounds. The same bytes as
// the records of a chunk whose checksums hold, because random bytes would never have
// valid ones.

#include <cstdint>
#include <cstdlib>

#include "engrave/io/crc32.h"
#include "services/platform/recording/mcap_reader.h"
#include "services/platform/recording/message_cursor.h"
#include "tests/services/platform/recording/memory_source.h"

namespace {

using namespace intaglio::recording;

constexpr ReaderLimits kLimits{.max_record_bytes = 1u << 20};

void Check(bool holds) {
  if (!holds) std::abort();
}

void ReadAll(Bytes bytes) {
  const auto reader =
      McapReader::Open(MakeMemorySource("fuzz", std::move(bytes)), kLimits);
  if (!reader) {
    Check(!reader.error().message.empty());
    return;
  }
  const RecordingContents& contents = reader->contents();
  Check(contents.torn_bytes <= contents.file_bytes);
  for (const auto& index : contents.attachments) (void)reader->Read(index);
  for (const auto& index : contents.metadata) (void)reader->Read(index);
  MessageCursor cursor(*reader);
  std::size_t errors = 0;
  for (;;) {
    const auto message = cursor.Next();
    if (!message) {
      // One a block at most: the cursor goes on.
      Check(!message.error().message.empty() && ++errors <= contents.blocks.size());
    } else if (!*message) {
      return;
    } else {
      Check(contents.channels.contains((*message)->channel_id));
      unsigned sum = 0;
      for (const std::byte byte : (*message)->payload) sum += unsigned(byte);
      Check(sum <= 255u * (*message)->payload.size());
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto input = std::as_bytes(std::span(bytes, size));
  ReadAll(Bytes(input.begin(), input.end()));
  Bytes sealed;
  PutRaw(sealed, std::as_bytes(std::span(kMagic, kMagicSize)));
  Encode(sealed, Header{"", "fuzz"});
  Encode(sealed, Channel{0, 0, "T", "cdr", {}});
  EncodeChunkHead(sealed, {0, 1, size, intaglio::io::Crc32(input), "", size});
  PutRaw(sealed, input);
  ReadAll(std::move(sealed));
  return 0;
}
