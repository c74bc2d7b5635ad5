#pragma once

// Contours and holes as programs for controllers of other makers.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/warning.h"
#include "engrave/post/cutting.h"
#include "engrave/post/mill_program.h"
#include "proto/machine.pb.h"
#include "services/job/course/course_work.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {

inline constexpr command_line::SuppliedKind kMillTemplates{"post/mill", "mill template"};
inline constexpr command_line::SuppliedKind kDrillTemplates{"post/drill",
                                                            "drill template"};
inline constexpr command_line::SuppliedKind kProbeTemplates{"post/probe",
                                                            "probe template"};

/// Speeds, depths and power of a course; `given` by which of its fields are set in
/// `typed`, the course without its defaults.
post::Cutting MillingOf(const Course& whole, const Course& typed);
post::Cutting DrillingOf(const Course& whole, const Course& typed);

struct ContourProgramOptions {
  std::string mill_template;
  std::string drill_template;  ///< default: the supplied one of the mill template's name
  std::string out;
  post::Parameters parameters;  ///< of the templates, by name
  post::MillOptions mill;
  std::optional<double> probe_step_mm;  ///< also a program that probes
  /// Contours have feeds with which this machine keeps its tolerance (planned_feeds.h),
  /// where the template has speeds; null: one speed.
  const MachineSpec* machine = nullptr;
};

Result<post::Template> ReadMillTemplate(const std::string& name_or_file,
                                        const post::Parameters& given = {});

/// The contours in `out`, the holes in a file beside it, board.ngc and board_drill.ngc,
/// and further parts in board_2.ngc and so on; which files, in their order. A program's
/// NAME is that of its file. What there is none of gets no file; holes alone are `out`.
/// What probes the surface is in board_probe.ngc, by the supplied template of the mill
/// template's name.
/// `warnings`: notes where a template has another depth of holes than the course may
/// have, of what the controller needs for planned feeds, and that a template has no
/// speeds. kInvalidValue: a parameter that none of the templates has.
Result<std::vector<std::filesystem::path>> WriteContourPrograms(
    const ContourWork& work, const Course& whole, const Course& typed,
    const ContourProgramOptions& options, Warnings& warnings);

}  // namespace intaglio::cli
