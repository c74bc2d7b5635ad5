#pragma once

// Meaning of the channels and metadata records of our recordings; docs/formats.md
// describes the same in prose.
//
// A channel is one topic of one domain in one partition, and one kind of sample. Values
// have the channel named as the topic. The ends of instances have channels of their own,
// "<topic>/disposed" and "<topic>/no_writer": their messages are the key alone, of the
// type <type>_key. Channel metadata, all texts:
//
//   topic, type        as DDS has them
//   domain             "control" or "bulk"
//   partition          absent: none; several are separated by commas
//   sample             "value", "disposed" or "no_writer"
//   keyed              "true" or "false"
//   repeated           "true": received in an earlier file, see below; otherwise absent
//   qos.<policy>       of the first writer: reliability, durability, history,
//                      deadline_ns, liveliness, lease_ns
//
// logTime is when the recorder took the sample, publishTime the writer's source time
// stamp; sequence counts the messages of a channel from 0, on through a series of files.
//
// A file that follows another one of a series begins with what was retained by then: the
// newest values of all instances of its transient-local topics. They are in channels of
// their own, of the same topic, type and name, whose metadata has "repeated". Their
// publishTime and sequence are those that they had in the earlier file, by which a repeat
// is recognized; their logTime is the file's beginning, before all else in it.
//
// Metadata records:
//   recording   version, host, started_utc, file_number: once a file, at its beginning;
//   and, when the recorder was asked to leave bulk out: bulk ("thin" or "none"),
//   bulk_left_out and bulk_thinned (topics, separated by commas), bulk_one_of (of the
//   thinned topics the first of so many messages of a channel is there)
//   type        recipe of a type (services/platform/bus/type_recipe.h), before its first
//   message missing     topic, domain, partition, sample, count, from_ns, to_ns (log
//   time) and
//               reason: messages that are not in the file; reason alone for a topic that
//               could not be recorded at all
//   forgotten   file_number, count, limit_bytes: so often a retained instance was not
//               remembered for the files after, because more is retained than the limit
// Attachments: jobs/<job_uid>/job.textproto, machine.textproto, material.textproto,
// frozen_job.binpb, software_version.txt.

#include <map>
#include <optional>
#include <string>

#include "services/platform/recording/mcap_records.h"

namespace intaglio::recording {

inline constexpr char kRecordingRecord[] = "recording";
inline constexpr char kTypeRecord[] = "type";
inline constexpr char kMissingRecord[] = "missing";
inline constexpr char kForgottenRecord[] = "forgotten";
inline constexpr char kCdr[] = "cdr";
inline constexpr char kOmgIdl[] = "omgidl";

enum class SampleKind { kValue, kDisposed, kNoWriter };

/// What a channel carries.
struct Stream {
  std::string topic;
  std::string type;  ///< e.g. "intaglio::JobStatus"
  bool bulk = false;
  std::string partition;
  SampleKind kind = SampleKind::kValue;
  bool keyed = false;
  std::map<std::string, std::string> qos;  ///< by policy
  bool repeated = false;                   ///< from an earlier file of the series
  bool operator==(const Stream&) const = default;
};

/// Name and metadata of the stream's channel; ids are left open.
Channel ChannelOf(const Stream& stream);
/// Nothing for a channel of another recorder.
std::optional<Stream> StreamOf(const Channel& channel);
/// Its messages are of an earlier file of the series.
bool IsRepeated(const Channel& channel);

const char* NameOf(SampleKind kind);

}  // namespace intaglio::recording
