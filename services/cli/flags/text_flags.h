#pragma once

// The text of a job, its fonts, and a code on the command line.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct TextFlags {
  std::optional<std::string> text, font, place;
  std::optional<std::string> code, code_kind;  // "data-matrix", "qr"
  std::optional<double> module_mm;
  std::optional<double> height_mm;
  std::vector<std::string> fallback_fonts;
  bool shrink_to_fit = false;
};

void AddTextFlags(command_line::Command command, TextFlags& flags);

/// What was given, in the job. --text replaces the only text that the job has, or is
/// another model; the others apply to every text of the job. "\n" in it divides lines.
/// --code is another model, or replaces the only code that the job has.
/// kInvalidValue names the option: a job of several texts or codes, or none.
Status SetTexts(const TextFlags& flags, JobSpec& job);

}  // namespace intaglio::cli
