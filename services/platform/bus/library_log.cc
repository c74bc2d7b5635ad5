#include "services/platform/bus/library_log.h"

#include <dds/ddsrt/log.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>

namespace intaglio::bus {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::minutes kRepeat{1};
constexpr std::size_t kMaxRemembered = 64;

/// Whether a line was not written within the last minute.
bool IsNew(const std::string& text) {
  static std::mutex mutex;
  static std::map<std::string, Clock::time_point> written;
  const std::lock_guard lock(mutex);
  const auto now = Clock::now();
  std::erase_if(written, [now](const auto& w) { return now - w.second >= kRepeat; });
  if (written.size() >= kMaxRemembered) return false;
  return written.emplace(text, now).second;
}

void Write(void*, const dds_log_data_t* line) {
  std::string text(line->message, line->size);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const bool of_start = text.find("Remote secure participant") != std::string::npos &&
                        text.find("not allowed") != std::string::npos;
  if (of_start || !IsNew(text)) return;
  std::fprintf(stderr, "DDS: %s\n", text.c_str());
}

}  // namespace

void KeepLibraryLogShort() { dds_set_log_sink(Write, nullptr); }

}  // namespace intaglio::bus
