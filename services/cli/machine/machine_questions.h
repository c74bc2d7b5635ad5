#pragma once

// The questions by which a person makes a profile from that of a family.

#include <iosfwd>
#include <string>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio::cli {

/// Asks for what differs from machine to machine, each with the value of `machine`, which
/// an empty line keeps; a value that cannot be is asked again, with the reason. The end
/// of `in` keeps the rest.
void AskAboutMachine(std::istream& in, std::ostream& out, MachineSpec& machine);

/// "field=value", e.g. "x.travel_max_mm=300" (services/job/fields/field_path.h). The
/// error names field and value.
Status ChangeField(MachineSpec& machine, const std::string& change);

}  // namespace intaglio::cli
