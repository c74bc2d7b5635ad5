#include "services/platform/host/times/utc_time.h"

#include <fmt/chrono.h>

#include <cctype>
#include <cstdio>
#include <ctime>

namespace intaglio::host {

std::string UtcText(std::chrono::system_clock::time_point time) {
  using std::chrono::milliseconds;
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(time);
  const auto rest = std::chrono::duration_cast<milliseconds>(time - whole_s);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(whole_s)),
                     rest.count());
}

bool HasShapeOfUtc(std::string_view text) {
  constexpr std::string_view kShape = "dddd-dd-ddTdd:dd:dd.dddZ";
  if (text.size() > kShape.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(text[i])) != 0;
    if (kShape[i] == 'd' ? !is_digit : text[i] != kShape[i]) return false;
  }
  return true;
}

std::optional<std::chrono::system_clock::time_point> TimeOfUtc(const std::string& text) {
  std::tm broken{};
  int ms = 0, length = 0;
  const int count = std::sscanf(
      text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d.%3dZ%n", &broken.tm_year, &broken.tm_mon,
      &broken.tm_mday, &broken.tm_hour, &broken.tm_min, &broken.tm_sec, &ms, &length);
  if (count != 7 || length != static_cast<int>(text.size())) return std::nullopt;
  broken.tm_year -= 1900;
  broken.tm_mon -= 1;
  return std::chrono::system_clock::from_time_t(timegm(&broken)) +
         std::chrono::milliseconds(ms);
}

}  // namespace intaglio::host
