#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "services/drivers/grbl/grbl_text.h"

// Whatever a controller sends: no line is longer than the reader allows, and a status has
// places that are numbers of this world.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::drivers;
  using intaglio::Require;
  GrblAnswerReader reader;
  std::vector<std::string> lines;
  reader.Feed(std::as_bytes(std::span(bytes, size)), lines);
  for (const std::string& line : lines) {
    Require(!line.empty() && line.size() <= 512, "a line of {} bytes", line.size());
    const GrblAnswer answer = ParseGrblAnswer(line);
    if (const auto* status = std::get_if<GrblStatus>(&answer)) {
      Require(status->work_mm || status->machine_mm, "a status without a place");
      for (const auto& place : {status->work_mm, status->machine_mm}) {
        if (place) Require(place->allFinite() && place->norm() < 2e6, "a wild place");
      }
    }
    if (const auto* setting = std::get_if<GrblSetting>(&answer)) {
      Require(std::isfinite(setting->value), "a setting that is no number");
    }
  }
  return 0;
}
