#pragma once

// The method of discretization and its fields on the command line. The options are those
// of the table of methods (services/job/methods/method_table.h): one for each name, which
// sets the fields of that name in all methods that have one.

#include <map>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct MethodFlags {
  std::optional<std::string> method;
  /// By option, "--layer"; the values as services/job/fields/field_path.h reads them.
  std::map<std::string, std::optional<std::string>> values;
};

void AddMethodFlags(command_line::Command command, MethodFlags& flags);

/// What was given, in the job (`method`: one of the table): --method in its
/// `discretization`, or in each model that the method suits when it is none of meshes;
/// the other options in the methods that the job then has. A mesh with a method of its
/// own keeps it as it is. kInvalidValue names the option: a method that suits no model, a
/// value that is none of the field's, an option that no method of the job has.
Status SetMethods(const MethodFlags& flags, JobSpec& job);

}  // namespace intaglio::cli
