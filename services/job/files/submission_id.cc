#include "services/job/files/submission_id.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "engrave/io/crc32.h"

namespace intaglio {
namespace {

constexpr std::string_view kPrefix = "key:";
constexpr std::size_t kMaxKeyLength = 64;

}  // namespace

Status CheckSubmissionKey(std::string_view key) {
  const bool good = !key.empty() && key.size() <= kMaxKeyLength &&
                    std::all_of(key.begin(), key.end(), [](unsigned char c) {
                      return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
                    });
  if (good) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("submission id '{}': give 1 to {} letters, digits, '.', '_' or "
                          "'-'",
                          key, kMaxKeyLength),
              std::string(key));
}

std::string SubmissionUid(std::string_view key, std::span<const std::uint8_t> job) {
  return fmt::format("{}{}:{:08x}", kPrefix, key, io::Crc32(std::as_bytes(job)));
}

std::string_view SubmissionKeyOf(std::string_view uid) {
  if (!uid.starts_with(kPrefix)) return {};
  uid.remove_prefix(kPrefix.size());
  const auto end = uid.rfind(':');
  return end == std::string_view::npos ? std::string_view() : uid.substr(0, end);
}

}  // namespace intaglio
