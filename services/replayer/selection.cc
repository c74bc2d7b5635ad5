#include "services/replayer/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "engrave/core/try.h"

namespace intaglio::replayer {
namespace {

constexpr std::array<std::string_view, 10> kCommands = {
    "JobSubmission",      "JobCommand", "DiscretizeTask", "SortTask",      "EngraveTask",
    "MotionSegmentBatch", "Permission", "EmergencyStop",  "ManualCommand", "CellMove"};
constexpr std::array<std::string_view, 21> kBelieved = {
    "JobCount",         "JobStatus",   "JobCommandAnswer", "TaskStatus",  "ServiceHealth",
    "Credit",           "ModelChunk",  "PointBatch",       "PathBatch",   "MarkBatch",
    "OrderedMarkBatch", "MotionState", "PositionReport",   "LampSync",    "Interlock",
    "DiskSpace",        "ManualState", "Mounted",          "ServiceList", "MachineReport",
    "KnownService"};

bool Contains(const auto& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Empty: it is played.
std::string WhyNot(const std::string& recorded, const std::string& played,
                   const SelectionOptions& options) {
  if (!options.topics.Accepts(recorded)) return "not selected";
  const Weight weight = WeightOf(played);
  if (options.credit_is_given && played == "Credit")
    return "the credit of the consumers is used instead";
  if (options.with_commands) return {};
  if (weight == Weight::kCommand) return "a command; play it with --with-commands";
  if (weight == Weight::kBelieved && options.services_live)
    return "live services would use it; play it with --with-commands";
  return {};
}

/// A bus knows one type by a name.
Status CheckTypes(const Selection& selection) {
  std::map<std::pair<bool, std::string>, const PlayedChannel*> by_name;
  for (const auto& [id, channel] : selection.channels) {
    const PlayedChannel& first =
        *by_name.try_emplace({channel.stream.bulk, channel.name}, &channel).first->second;
    if (first.stream.type == channel.stream.type) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} would have two types, {} and {}; use another name, or "
                            "leave one out with --without-topic",
                            channel.name, first.stream.type, channel.stream.type),
                channel.name);
  }
  return {};
}

}  // namespace

Weight WeightOf(const std::string& topic) {
  if (Contains(kCommands, topic)) return Weight::kCommand;
  return Contains(kBelieved, topic) ? Weight::kBelieved : Weight::kShown;
}

Result<Selection> Select(const recording::RecordingContents& contents,
                         const SelectionOptions& options) {
  Selection selection;
  auto unused = options.renames;
  for (const auto& [id, channel] : contents.channels) {
    const auto stream = recording::StreamOf(channel);
    if (!stream || channel.message_encoding != recording::kCdr) {
      selection.left_out[channel.topic] = "it was not recorded by intaglio record";
      continue;
    }
    unused.erase(stream->topic);
    const auto renamed = options.renames.find(stream->topic);
    const std::string name =
        renamed == options.renames.end() ? stream->topic : renamed->second;
    const std::string why_not = WhyNot(stream->topic, name, options);
    if (!why_not.empty()) {
      selection.left_out[stream->topic] = why_not;
      continue;
    }
    selection.believed = selection.believed || WeightOf(name) == Weight::kBelieved;
    selection.channels.emplace(id, PlayedChannel{*stream, name});
  }
  if (!unused.empty()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("the recording has no topic {} to rename; `intaglio "
                            "recording list` lists its topics",
                            unused.begin()->first),
                unused.begin()->first);
  }
  INTAGLIO_TRY(CheckTypes(selection));
  return selection;
}

}  // namespace intaglio::replayer
