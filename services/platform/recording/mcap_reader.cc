#include "services/platform/recording/mcap_reader.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/platform/recording/file_records.h"

namespace intaglio::recording {

McapReader::McapReader(std::unique_ptr<ByteSource> source, const ReaderLimits& limits)
    : source_(std::move(source)), limits_(limits) {}

Result<McapReader> McapReader::Open(const std::filesystem::path& file,
                                    const ReaderLimits& limits) {
  auto source = INTAGLIO_TRY(OpenFileSource(file));
  return Open(std::move(source), limits);
}

Result<McapReader> McapReader::Open(std::unique_ptr<ByteSource> source,
                                    const ReaderLimits& limits) {
  McapReader reader(std::move(source), limits);
  const FileRecords file(*reader.source_, limits);
  const auto magic =
      INTAGLIO_TRY(file.Raw(0, std::min<std::uint64_t>(kMagicSize, file.size())));
  if (magic.size() < kMagicSize || std::memcmp(magic.data(), kMagic, kMagicSize) != 0) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{} is not a recording: it does not begin with the MCAP "
                            "magic at byte 0; give a .mcap file",
                            reader.name()),
                reader.name());
  }
  if (auto summary = ReadSummary(file)) {
    reader.contents_ = std::move(*summary);
    return reader;
  }
  auto scanned = INTAGLIO_TRY(ScanFile(file));
  reader.contents_ = std::move(scanned);
  return reader;
}

const Schema* McapReader::SchemaOf(const Channel& channel) const {
  const auto found = contents_.schemas.find(channel.schema_id);
  return found == contents_.schemas.end() ? nullptr : &found->second;
}

Result<Bytes> McapReader::ReadBlock(const MessageBlock& block) const {
  const FileRecords file(*source_, limits_);
  return block.compression == "-" ? file.Raw(block.offset, block.length)
                                  : file.UnpackedChunk(block.offset);
}

Result<Attachment> McapReader::Read(const AttachmentIndex& index) const {
  return FileRecords(*source_, limits_)
      .Get<Attachment>(index.offset, Opcode::kAttachment);
}

Result<Metadata> McapReader::Read(const MetadataIndex& index) const {
  return FileRecords(*source_, limits_).Get<Metadata>(index.offset, Opcode::kMetadata);
}

Result<std::vector<Metadata>> McapReader::ReadMetadata(
    const std::string& metadata_name) const {
  std::vector<Metadata> found;
  for (const MetadataIndex& index : contents_.metadata) {
    if (index.name != metadata_name) continue;
    auto metadata = INTAGLIO_TRY(Read(index));
    found.push_back(std::move(metadata));
  }
  return found;
}

}  // namespace intaglio::recording
