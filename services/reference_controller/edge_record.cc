#include "services/reference_controller/edge_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::reference_controller {
namespace {

double Microseconds(std::chrono::nanoseconds time) {
  return 1e-3 * static_cast<double>(time.count());
}

std::string Line(const char* name, const Spread& spread) {
  return fmt::format("{:<12} {:>8} {:>11.1f} {:>9.2f} {:>11.1f} {:>11.1f} {:>11.1f}\n",
                     name, spread.count, spread.mean_us, spread.deviation_us,
                     spread.min_us, spread.p999_us, spread.max_us);
}

}  // namespace

std::string NameOf(Output output) {
  static constexpr std::array kNames = {
      "q_switch",     "shutters[0]", "shutters[1]", "shutters[2]", "shutters[3]",
      "lamp_trigger", "lamp",        "door_lock",   "outputs[0]",  "outputs[1]",
      "outputs[2]",   "outputs[3]",  "outputs[4]",  "outputs[5]",  "outputs[6]",
      "outputs[7]",   "alive",       "x.step",      "y.step",      "z.step",
      "x.direction",  "y.direction", "z.direction", "enable",      "in_position_output"};
  static_assert(kNames.size() == kOutputCount);
  return kNames[static_cast<std::size_t>(output)];
}

Result<EdgeRecord> EdgeRecord::Create(const std::filesystem::path& file) {
  EdgeRecord record;
  record.stream_.open(file, std::ios::trunc);
  record.stream_ << "ns,output,on\n" << std::flush;
  if (record.stream_) return record;
  return Fail(ErrorCode::kIo, fmt::format("cannot write {}", file.string()),
              file.string());
}

void EdgeRecord::Add(const Edge& edge) {
  stream_ << fmt::format("{},{},{}\n", edge.at.count(), NameOf(edge.output),
                         edge.on ? 1 : 0)
          << std::flush;
}

Spread SpreadOf(std::vector<double> times_us) {
  Require(!times_us.empty(), "there are no times to compare");
  std::ranges::sort(times_us);
  Spread spread;
  spread.count = times_us.size();
  const auto count = static_cast<double>(times_us.size());
  spread.mean_us = std::accumulate(times_us.begin(), times_us.end(), 0.0) / count;
  double squares = 0;
  for (const double time : times_us)
    squares += (time - spread.mean_us) * (time - spread.mean_us);
  spread.deviation_us = std::sqrt(squares / count);
  spread.min_us = times_us.front();
  spread.p999_us = times_us[static_cast<std::size_t>(0.999 * (count - 1))];
  spread.max_us = times_us.back();
  return spread;
}

Jitter JitterOf(const std::vector<Edge>& edges) {
  std::vector<double> periods, delays, widths;
  std::optional<std::chrono::nanoseconds> lamp, trigger;
  std::size_t lamps = 0;
  for (const Edge& edge : edges) {
    if (edge.output == Output::kLampTrigger && edge.on) {
      if (lamp) periods.push_back(Microseconds(edge.at - *lamp));
      lamp = edge.at;
      ++lamps;
    }
    if (edge.output != Output::kQSwitch) continue;
    if (edge.on && lamp) delays.push_back(Microseconds(edge.at - *lamp));
    if (!edge.on && trigger) widths.push_back(Microseconds(edge.at - *trigger));
    trigger = edge.on ? std::optional(edge.at) : std::nullopt;
  }
  return {SpreadOf(std::move(periods)), SpreadOf(delays), SpreadOf(std::move(widths)),
          lamps - delays.size()};
}

std::string TextOfSpreads(const std::vector<std::pair<const char*, Spread>>& spreads) {
  std::string text = fmt::format("{:<12} {:>8} {:>11} {:>9} {:>11} {:>11} {:>11}\n", "us",
                                 "count", "mean", "rms", "min", "99.9 %", "max");
  for (const auto& [name, spread] : spreads) text += Line(name, spread);
  return text;
}

std::string ToText(const Jitter& jitter) {
  return TextOfSpreads({{"lamp period", jitter.period},
                        {"trigger at", jitter.delay},
                        {"its width", jitter.width}}) +
         fmt::format("{} of {} lamp triggers without a trigger of the Q-switch\n",
                     jitter.withheld, jitter.delay.count + jitter.withheld);
}

}  // namespace intaglio::reference_controller
