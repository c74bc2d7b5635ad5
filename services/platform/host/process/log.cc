#include "services/platform/host/process/log.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <vector>

namespace intaglio::host {
namespace {

spdlog::level::level_enum LevelOf(LogLevel level) {
  switch (level) {
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      break;
  }
  return spdlog::level::err;
}

}  // namespace

void OpenLog(const std::string& service, const std::string& min_level,
             const std::string& file) {
  std::vector<spdlog::sink_ptr> sinks = {
      std::make_shared<spdlog::sinks::stderr_sink_mt>()};
  if (!file.empty()) {
    sinks.push_back(std::make_shared<spdlog::sinks::basic_file_sink_mt>(file));
  }
  auto log = std::make_shared<spdlog::logger>(service, sinks.begin(), sinks.end());
  log->set_level(spdlog::level::from_str(min_level));
  log->set_pattern("%Y-%m-%dT%H:%M:%S.%e %n %l: %v");
  log->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(log));
}

void Log(LogLevel level, std::string_view line) { spdlog::log(LevelOf(level), line); }

}  // namespace intaglio::host
