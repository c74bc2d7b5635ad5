#include "services/cli/recordings/recording_export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/csv.h"
#include "services/platform/recording/bulk.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/message_decoder.h"
#include "services/platform/recording/recording_copy.h"

namespace intaglio::cli {
namespace {

using recording::Value;
constexpr std::uint64_t kMade = 0;  // idl PulseOutcome

/// Calls visit(channel, message, value) while it returns a value.
template <typename Visit>
Status ForEachValue(const recording::McapReader& reader,
                    const recording::MessageQuery& query, Visit&& visit) {
  recording::MessageDecoder decoder(reader);
  recording::MessageCursor cursor(reader, query);
  for (;;) {
    const auto message = INTAGLIO_TRY(cursor.Next());
    if (!message) return {};
    const auto value = INTAGLIO_TRY(decoder.Decode(*message));
    visit(reader.contents().channels.at(message->channel_id), *message, value);
  }
}

std::string Entry(const recording::Channel& channel, const char* name) {
  const auto found = channel.metadata.find(name);
  return found == channel.metadata.end() ? std::string() : found->second;
}

/// Names or values of the leaves of a message, each behind a comma.
void PutLeaves(std::string& out, const recording::ValueObject& object,
               const std::string& prefix, bool names) {
  for (const auto& [name, value] : object) {
    if (const auto* inner = value.As<recording::ValueObject>()) {
      PutLeaves(out, *inner, prefix + name + ".", names);
      continue;
    }
    out += ',';
    if (names) {
      out += io::CsvField(prefix + name);
    } else if (const auto* text = value.As<std::string>()) {
      out += io::CsvField(*text);
    } else {
      out += io::CsvField(recording::JsonOf(value));
    }
  }
}

/// `job` is the uid, or the number with which a uid begins ("2-6b0c03e6afff").
bool IsNamed(const std::string& job, const std::string& uid) {
  return uid == job || uid.starts_with(job + "-");
}

using Numbers = std::vector<std::uint64_t>;
using Reals = std::vector<double>;

/// Pulses and places of one job. A point may be reported twice: again by the next life of
/// a synchronizer, or when it is fired after it was uncertain, by a person's consent. The
/// newest report that it was made counts; no later one undoes a crack.
class Cracks {
 public:
  /// `asked`: uid or number of the job; empty: the only one that there is.
  explicit Cracks(std::string asked) : asked_(std::move(asked)) {}

  Status Collect(const recording::McapReader& reader) {
    left_out_ = SentenceOf(recording::BulkRequestOf(reader));
    for (const auto& [id, channel] : reader.contents().channels) {
      if (channel.topic == "PulseEventBatch" || channel.topic == "PathBatch") {
        channels_.insert(id);
      }
    }
    INTAGLIO_TRY(ForEachValue(
        reader, {.channels = channels_},
        [this](const recording::Channel& channel, const auto&, const Value& value) {
          const auto& job = recording::MemberOf<std::string>(value, "job_uid");
          jobs_.insert(job);
          if (!asked_.empty() && !IsNamed(asked_, job)) return;
          named_.insert(job);
          if (job_uid_.empty()) job_uid_ = job;
          if (job != job_uid_) return;
          if (channel.topic == "PathBatch") {
            AddPlaces(value);
          } else {
            AddPulses(value);
          }
        }));
    return CheckJob();
  }

  Status Write(const std::filesystem::path& path, const std::filesystem::path& target) {
    INTAGLIO_TRY(Find(path));
    std::vector<std::pair<std::uint64_t, std::uint64_t>> cracks;  // tick, point
    for (const auto& [point, tick] : made_at_) cracks.emplace_back(tick, point);
    std::sort(cracks.begin(), cracks.end());
    formats::PointTable table;
    table.comments = {"cracks of job " + job_uid_};
    Reals ticks;
    std::vector<std::uint32_t> points;
    for (const auto& [tick, point] : cracks) {
      const auto place = places_.find(point);
      if (place == places_.end()) {
        return Fail(
            ErrorCode::kMissing,
            fmt::format("the position of point {} is not in the recording{}; give "
                        "the job's path.ply with --path",
                        point, left_out_.empty() ? "" : ", for " + left_out_),
            std::to_string(point));
      }
      table.points_mm.push_back(place->second);
      ticks.push_back(static_cast<double>(tick));
      points.push_back(static_cast<std::uint32_t>(point));
    }
    table.columns = {{"tick", std::move(ticks)}, {"point", std::move(points)}};
    return formats::WritePly(target, table);
  }

 private:
  Status CheckJob() const {
    if (named_.size() > 1) {
      return Fail(ErrorCode::kMissing,
                  fmt::format("the recording has the points of {}, {}: name one with "
                              "--job",
                              Counted(named_.size(), "job"), fmt::join(named_, ", ")),
                  asked_);
    }
    if (asked_.empty() || !named_.empty()) return {};
    const std::string names = fmt::format("{}", fmt::join(jobs_, ", "));
    return Fail(ErrorCode::kNotFound,
                fmt::format("--job {}: the recording has no points of it; it has {}",
                            asked_, names.empty() ? "none of any job" : names),
                asked_);
  }
  void AddPlaces(const Value& value) {
    const auto first = recording::MemberOf<std::uint64_t>(value, "first_index");
    const auto& x = recording::MemberOf<Reals>(value, "x_mm");
    const auto& y = recording::MemberOf<Reals>(value, "y_mm");
    const auto& z = recording::MemberOf<Reals>(value, "z_mm");
    for (std::size_t i = 0; i < std::min({x.size(), y.size(), z.size()}); ++i) {
      places_[first + i] = Vec3(x[i], y[i], z[i]);
    }
  }
  void AddPulses(const Value& value) {
    const auto& tick = recording::MemberOf<Numbers>(value, "tick");
    const auto& point = recording::MemberOf<Numbers>(value, "point");
    const auto& outcome = recording::MemberOf<Numbers>(value, "outcome");
    for (std::size_t i = 0; i < std::min({tick.size(), point.size(), outcome.size()});
         ++i) {
      if (outcome[i] == kMade) made_at_[point[i]] = tick[i];
    }
  }
  Status Find(const std::filesystem::path& path) {
    if (path.empty()) return {};
    const auto table = INTAGLIO_TRY(formats::ReadPly(path));
    for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
      places_.try_emplace(i, table.points_mm[i]);
    }
    return {};
  }

  std::string asked_, job_uid_;
  std::set<std::string> jobs_;   // of which there are points
  std::set<std::string> named_;  // of these the ones that are asked for
  std::string left_out_;         // by request
  std::set<std::uint16_t> channels_;
  std::map<std::uint64_t, Vec3> places_;
  std::map<std::uint64_t, std::uint64_t> made_at_;  // tick, by point
};

}  // namespace

Status ExportJsonLines(const recording::McapReader& reader,
                       const recording::MessageQuery& query, std::ostream& out) {
  return ForEachValue(
      reader, query,
      [&out](const recording::Channel& channel, const recording::MessageView& message,
             const Value& value) {
        Value head{
            recording::ValueObject{{"topic", {channel.topic}},
                                   {"partition", {Entry(channel, "partition")}},
                                   {"sample", {Entry(channel, "sample")}},
                                   {"sequence", {std::uint64_t{message.sequence}}},
                                   {"log_time_ns", {message.log_time_ns}},
                                   {"publish_time_ns", {message.publish_time_ns}}}};
        if (recording::IsRepeated(channel)) {
          std::get<recording::ValueObject>(head.held).push_back({"repeated", {true}});
        }
        std::string line = recording::JsonOf(head);
        line.back() = ',';
        out << line << "\"value\":" << recording::JsonOf(value) << "}\n";
      });
}

Status ExportCsv(const recording::McapReader& reader, const std::string& topic,
                 const recording::MessageQuery& query, std::ostream& out) {
  recording::MessageQuery of_topic = query;
  of_topic.channels.emplace();
  for (const auto& [id, channel] : reader.contents().channels) {
    if (channel.topic == topic && !recording::IsRepeated(channel))
      of_topic.channels->insert(id);
  }
  bool headed = false;
  return ForEachValue(reader, of_topic,
                      [&](const recording::Channel& channel,
                          const recording::MessageView& message, const Value& value) {
                        const auto* object = value.As<recording::ValueObject>();
                        std::string line;
                        if (!std::exchange(headed, true)) {
                          line = "log_time_ns,publish_time_ns,sequence,partition";
                          PutLeaves(line, *object, "", true);
                          line += "\r\n";
                        }
                        line += fmt::format("{},{},{},{}", message.log_time_ns,
                                            message.publish_time_ns, message.sequence,
                                            io::CsvField(Entry(channel, "partition")));
                        PutLeaves(line, *object, "", false);
                        out << line << "\r\n";
                      });
}

Status ExportCracks(const recording::McapReader& reader, const std::string& job,
                    const std::filesystem::path& path,
                    const std::filesystem::path& target) {
  Cracks cracks(job);
  INTAGLIO_TRY(cracks.Collect(reader));
  return cracks.Write(path, target);
}

}  // namespace intaglio::cli
