#include "services/client/folder_name.h"

#include <algorithm>
#include <cstddef>

namespace intaglio::client {
namespace {

constexpr std::size_t kMaxBytes = 100;

bool IsKept(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x80 || (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
         (byte >= 'a' && byte <= 'z') || c == '.' || c == '-' || c == '_';
}

/// A byte in the middle of a character of UTF-8.
bool Continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

}  // namespace

std::string FolderNameOf(const std::string& job_name) {
  std::string name;
  for (const char c : job_name) {
    if (IsKept(c)) {
      if (name.empty() && (c == '-' || c == '.')) continue;
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  if (name.size() > kMaxBytes) {
    std::size_t end = kMaxBytes;
    while (end > 0 && Continues(name[end])) --end;
    name.resize(end);
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name.empty() ? "job" : name;
}

std::string FolderTimeOf(const std::string& utc) {
  std::string time = utc;
  std::erase(time, ':');
  return time;
}

}  // namespace intaglio::client
