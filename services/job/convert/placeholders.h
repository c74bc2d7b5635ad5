#pragma once

// Names in braces in the texts of a job: "{name}" is filled in from a column of a table,
// "{n}" with the number of a copy. "{{" and "}}" are braces themselves.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/job.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// What `value` has for its name in the place of each placeholder; those for which it has
/// nothing stay, and so do doubled braces.
std::string FillPlaceholders(
    std::string_view text,
    const std::function<std::optional<std::string>(const std::string&)>& value);

/// Their names in the order of the text.
std::vector<std::string> PlaceholdersOf(std::string_view text);

/// A value that a text is to have as it is: its braces doubled.
std::string WithDoubledBraces(std::string_view value);

/// A value in a job's name, in which a brace begins what is to be filled in: without its
/// braces.
std::string WithoutBraces(std::string value);

/// The text that is engraved: "{n}" with the number, doubled braces single.
std::string NumberedText(std::string_view text, std::size_t number);

/// What is left to be filled in: the names of a text but "n", those of the job's name and
/// of its glass. Those of files are found with the files.
void CheckPlaceholders(const JobSpec& job, Findings& findings);

/// "is not filled in ...", for a field that has this placeholder.
std::string UnfilledText(const std::string& name);

}  // namespace intaglio
