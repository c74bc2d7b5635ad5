#pragma once

// Job and machine files: protobuf text format (.textproto, .txtpb) or JSON (.json) of
// proto/job.proto and proto/machine.proto.
//
// Errors: kNotFound, kIo (also what is no regular file), kTooLarge (more than
// kMaxJobFileBytes), kUnsupported (another ending), kUnreadable with "file:line:column:
// what". An unknown field is an error.

#include <filesystem>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// A job of a thousand models is below 200 kB.
inline constexpr std::size_t kMaxJobFileBytes = 1 << 20;

enum class JobFileFormat { kText, kJson };

/// Parses only; CheckJob (services/job/checks/job_check.h) checks the values. Paths of
/// models and machine file are made absolute: they are relative to the job file's folder.
Result<JobSpec> ReadJobFile(const std::filesystem::path& path);

/// "els-03": neither a path nor a file of that name in the folder. Also nothing, which is
/// the name of the default one.
bool IsNameOfAProfile(const std::string& machine_file,
                      const std::filesystem::path& folder);

/// Paths relative to `folder`, which is absolute, become absolute; families of fonts the
/// files that this machine has for them. A machine file without folder and extension that
/// is no file there stays as it is: the name of a supplied profile.
void ResolveFiles(JobSpec& job, const std::filesystem::path& folder);

/// Also checks (CheckMachine, all errors in one message, one a line) and fills in the
/// defaults: no machine should be driven from an unchecked profile.
Result<MachineSpec> ReadMachineFile(const std::filesystem::path& path);

/// Parses only, for a caller that reports each mistake.
Result<MachineSpec> ReadUncheckedMachine(const std::filesystem::path& path);

/// The same from memory, paths untouched, unchecked; errors show `name` in place of the
/// file. For tests/fuzz/job_fuzz.cc, which parses millions of texts without a file.
Result<JobSpec> ParseJob(std::string_view text, JobFileFormat format,
                         const std::string& name);
Result<MachineSpec> ParseMachine(std::string_view text, JobFileFormat format,
                                 const std::string& name);

/// The format follows from the ending. The file is there whole or not at all.
Status WriteMachineFile(const std::filesystem::path& path, const MachineSpec& machine);
/// The same of a job.
Status WriteJobFile(const std::filesystem::path& path, const JobSpec& job);

}  // namespace intaglio
