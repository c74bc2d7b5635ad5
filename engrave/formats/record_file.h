#pragma once

// Append-only files of records of one size, readable up to the place where they were cut:
// the glass of a virtual machine, the ticks of a scan head, the way of a tool, the
// journal.
//
//   header                                      record
//    offset  size                                offset  size
//         0     8  8 letters, the kind                0        what the kind says
//         8     4  version                        end-4     4  CRC-32 of all before
//        12     4  size of a record
//        16        what the kind says
//     end-4     4  CRC-32 of all before
//
// All numbers little endian, as they lie in memory.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as they lie in memory");

/// A kind of such files.
struct RecordKind {
  std::string_view letters;  ///< 8 of them
  std::string_view name;     ///< in a sentence, without an article: "glass record"
  std::uint32_t oldest_version, version;
  std::size_t header_size, record_size;
};

template <typename T>
void PutNumber(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

template <typename T>
T NumberAt(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// Writes the CRC-32 of what is before the last four bytes there.
void Seal(std::span<std::byte> bytes);
bool IsSealed(std::span<const std::byte> bytes);

/// A header of zeros but for what all kinds have; it is to be sealed.
std::vector<std::byte> NewRecordHeader(const RecordKind& kind);

/// Appends a record of zeros to `out`: it is to be filled and sealed.
std::span<std::byte> AppendRecord(const RecordKind& kind, std::vector<std::byte>& out);

/// The header is there, sealed, and of a version that is read. kUnreadable, kUnsupported.
Status CheckRecordHeader(const RecordKind& kind, std::span<const std::byte> bytes);

/// Calls read(const std::byte* record), which returns whether it could, for each record
/// until one is damaged or it could not. Returns how many bytes are behind the last one.
template <typename Read>
std::uint64_t ReadRecords(const RecordKind& kind, std::span<const std::byte> bytes,
                          Read&& read) {
  std::span<const std::byte> rest = bytes.subspan(kind.header_size);
  while (rest.size() >= kind.record_size && IsSealed(rest.first(kind.record_size)) &&
         read(rest.data())) {
    rest = rest.subspan(kind.record_size);
  }
  return rest.size();
}

/// How many records the bytes have room for behind the header.
inline std::size_t RecordRoom(const RecordKind& kind, std::span<const std::byte> bytes) {
  return (bytes.size() - kind.header_size) / kind.record_size;
}

/// What `parse` makes of a file's bytes; errors name the file.
/// kNotFound, kIo, kTooLarge; and those of `parse`.
template <typename Parse>
auto ReadRecordFile(const std::filesystem::path& file, std::uint64_t max_bytes,
                    Parse&& parse) {
  return io::ReadWholeFile(file, max_bytes).and_then([&](const std::string& text) {
    return parse(std::as_bytes(std::span(text))).map_error([&](Error error) {
      return io::AboutFile(std::move(error), file);
    });
  });
}

/// The same of the header alone, in a file of any size.
template <typename Parse>
auto ReadRecordHeader(const RecordKind& kind, const std::filesystem::path& file,
                      Parse&& parse) {
  return io::ReadBeginning(file, kind.header_size).and_then([&](const std::string& text) {
    return parse(std::as_bytes(std::span(text))).map_error([&](Error error) {
      return io::AboutFile(std::move(error), file);
    });
  });
}

}  // namespace intaglio::formats
