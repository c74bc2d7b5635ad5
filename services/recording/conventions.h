#pragma once

// What the channels and metadata records of our recordings mean; docs/formats.md has the
// same in words.
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
//   qos.<policy>       of the first writer: reliability, durability, history,
//                      deadline_ns, liveliness, lease_ns
//
// logTime is when the recorder took the sample, publishTime the writer's source time
// stamp; sequence counts the messages of a channel from 0.
//
// Metadata records:
//   recording   version, host, started_utc, file_number: once a file, at its beginning
//   type        recipe of a type (services/bus/type_recipe.h), before its first message
//   missing     topic, domain, partition, sample, count, from_ns, to_ns (log time) and
//               reason: messages that are not in the file; reason alone for a topic that
//               could not be recorded at all
// Attachments: jobs/<job_uid>/job.textproto, machine.textproto, material.textproto,
// frozen_job.binpb, software_version.txt.

#include <map>
#include <optional>
#include <string>

#include "services/recording/mcap_records.h"

namespace intaglio::recording {

inline constexpr char kRecordingRecord[] = "recording";
inline constexpr char kTypeRecord[] = "type";
inline constexpr char kMissingRecord[] = "missing";
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
  bool operator==(const Stream&) const = default;
};

/// Name and metadata of the stream's channel; ids are left open.
Channel ChannelOf(const Stream& stream);
/// Nothing for a channel of another recorder.
std::optional<Stream> StreamOf(const Channel& channel);

const char* NameOf(SampleKind kind);

}  // namespace intaglio::recording
