#include "services/replayer/recorded_stops.h"

#include <algorithm>
#include <iterator>

#include "services/replayer/recorded_members.h"

namespace intaglio::replayer {
namespace {

constexpr char kEveryCell[] = "*";

bool ReadReleased(const recording::Value& list, std::vector<RecordedPress>& released) {
  const auto* values = list.As<recording::ValueList>();
  if (values == nullptr) return false;
  for (const recording::Value& value : *values) {
    RecordedPress press;
    Members members(value);
    members.Get("source", press.source);
    members.Get("number", press.number);
    if (!members.good()) return false;
    released.push_back(std::move(press));
  }
  return true;
}

}  // namespace

std::optional<RecordedStops::Sample> RecordedStops::Read(const recording::Value& value) {
  Sample sample;
  std::string cell;
  Members members(value);
  members.Get("cell", cell);
  members.Get("pressed", sample.stop.pressed);
  members.Get("source", sample.stop.source);
  members.Get("number", sample.stop.number);
  if (!members.good()) return std::nullopt;
  sample.ours = cell == cell_ || cell == kEveryCell;
  if (const recording::Value* released = value.Find("released")) {
    if (!ReadReleased(*released, sample.stop.released)) return std::nullopt;
    return sample;
  }
  if (!sample.ours) return sample;
  StopMessage& stop = sample.stop;
  if (stop.pressed) {
    stop.source += "-" + std::to_string(unnamed_presses_.size() + 1);
    unnamed_presses_.push_back({stop.source, stop.number});
  } else {
    std::copy_if(unnamed_presses_.begin(), unnamed_presses_.end(),
                 std::back_inserter(stop.released),
                 [&](const RecordedPress& press) { return press.number < stop.number; });
  }
  return sample;
}

}  // namespace intaglio::replayer
