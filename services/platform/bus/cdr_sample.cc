#include "services/platform/bus/cdr_sample.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/q_protocol.h>
#include <fmt/format.h>

#include <cstring>
#include <vector>

namespace intaglio::bus::internal {
namespace {

constexpr std::size_t kHeader = 4;
constexpr unsigned kLastOfXcdr1 = 3;  // identifiers of the encapsulation header

}  // namespace

Status ReadCdr(const dds_topic_descriptor& type, std::span<const std::byte> cdr,
               void* sample) {
  const auto wrong = [&type] {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("the bytes are not a sample of {}", type.m_typename));
  };
  if (cdr.size() < kHeader) return wrong();
  const auto identifier = std::to_integer<unsigned>(cdr[1]);
  const bool little_endian = (identifier & 1) != 0;
  const std::uint32_t version =
      identifier > kLastOfXcdr1 ? CDR_ENC_VERSION_2 : CDR_ENC_VERSION_1;
  // The sample is normalized in place, and a normalized sample is known to be valid.
  std::vector<std::uint64_t> storage(cdr.size() / sizeof(std::uint64_t) + 1);
  const auto size = static_cast<std::uint32_t>(cdr.size() - kHeader);
  std::memcpy(storage.data(), cdr.data() + kHeader, size);
  std::uint32_t end = 0;
  if (dds_stream_normalize_data(reinterpret_cast<char*>(storage.data()), &end, size,
                                !little_endian, version, type.m_ops) == nullptr)
    return wrong();
  dds_istream_t in;
  dds_istream_init(&in, size, storage.data(), version);
  dds_stream_read(&in, static_cast<char*>(sample), type.m_ops);
  return {};
}

void FreeCdr(const dds_topic_descriptor& type, void* sample) {
  dds_stream_free_sample(sample, type.m_ops);
}

}  // namespace intaglio::bus::internal
