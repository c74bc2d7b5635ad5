#include "services/cli/machine/machine_questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <vector>

#include "services/job/checks/job_check.h"
#include "services/job/fields/field_path.h"

namespace intaglio::cli {
namespace {

struct Question {
  const char* field;
  const char* text;
  enum class For {
    kAll,
    kPoints,
    kCartesian,
    kMoves,
    kMarks,
    kField,
    kHead,
    kPointBoard,
    kJumps,
    kJumpLens,
    kBoard,
    kMarkBoard
  } machines = For::kAll;
};

using enum Question::For;
constexpr Question kQuestions[] = {
    {"name", "name of the machine"},
    {"x.travel_min_mm", "x: travel from, mm", kCartesian},
    {"x.travel_max_mm", "x: travel to, mm", kCartesian},
    {"y.travel_min_mm", "y: travel from, mm", kCartesian},
    {"y.travel_max_mm", "y: travel to, mm", kCartesian},
    {"z.travel_min_mm", "z: travel from, mm", kPoints},
    {"z.travel_max_mm", "z: travel to, mm", kPoints},
    {"cartesian.x.moves", "x moves the head or the table", kMoves},
    {"cartesian.y.moves", "y moves the head or the table", kMoves},
    {"block_origin_mm", "corner of the block for the axes (x y z), mm", kPoints},
    {"lenses[0].name", "lens: its name", kJumpLens},
    {"lenses[0].focal_length_mm", "lens: focal length, mm", kJumpLens},
    {"lenses[0].numerical_aperture", "lens: half of the beam's width over focal length",
     kJumpLens},
    {"lenses[0].free_distance_mm", "lens: from its lowest edge to the focus, mm",
     kJumpLens},
    {"mounted_lens", "mounted lens", kPoints},
    {"laser_line.device", "line of the laser controller", kPoints},
    {"motion_line.device", "line of the motion controller", kPoints},
    {"scan_head.field_mm", "width of the field, mm", kField},
    {"scan_head.jump_mm_s", "speed of jumps, mm/s", kHead},
    {"scan_head.correction_file", "correction file", kField},
    {"scan_head.laser_on_delay_s", "laser on: delay, s", kMarkBoard},
    {"scan_head.laser_off_delay_s", "laser off: delay, s", kMarkBoard},
    {"scan_head.jump_delay_s", "rest behind a jump, s", kMarkBoard},
    {"scan_head.mark_delay_s", "rest behind a mark, s", kMarkBoard},
    {"scan_head.polygon_delay_s", "rest at a corner, s", kMarkBoard},
    {"z.steps_per_mm", "z: steps of the board's axis for 1 mm", kPointBoard},
    {"head_over_block.jump_and_dwell.z_step_mm", "z rests at multiples of, mm", kJumps},
    {"head_over_block.jump_and_dwell.jump_mm_s", "speed of jumps, mm/s", kJumps},
    {"head_over_block.jump_and_dwell.jump_delay_s", "rest behind a jump, s", kJumps},
    {"head_over_block.jump_and_dwell.dwell_s", "time of a point, s", kJumps},
    {"head_over_block.jump_and_dwell.z_settle_s", "rest behind a move of z, s", kJumps},
    {"head_over_block.pupil_x_mm", "lens: distance of its pupil along x, mm", kJumps},
    {"head_over_block.pupil_y_mm", "lens: distance of its pupil along y, mm", kJumps},
    {"bjjcz_board.laser", "laser: fibre, co2 or uv", kBoard},
    {"laser.wavelength_nm", "laser: wavelength, nm", kPointBoard},
    {"bjjcz_board.point_frequency_hz", "laser: pulses a second at a point, Hz",
     kPointBoard},
    {"bjjcz_board.door_input", "input of key, door and stop button", kBoard},
    {"bjjcz_board.gate_output", "output that gates the laser", kBoard},
    {"mark_line.device", "line of the controller", kMarks}};

bool IsAskedOf(Question::For machines, const MachineSpec& machine) {
  switch (machines) {
    case kPoints:
      return !machine.has_mark_line();
    case kCartesian:
      return !machine.has_mark_line() && !machine.has_polar();
    case kMoves:
      return !machine.has_mark_line() && !machine.has_polar() &&
             !machine.has_head_over_block();
    case kMarks:
      return machine.has_mark_line();
    case kField:
      return machine.has_scan_head();
    case kHead:
      return machine.has_mark_line() && machine.has_scan_head();
    case kPointBoard:
      return !machine.has_mark_line() && machine.has_bjjcz_board();
    case kJumps:
      return machine.head_over_block().has_jump_and_dwell();
    case kJumpLens:
      return machine.head_over_block().has_jump_and_dwell() && machine.lenses_size() > 0;
    case kBoard:
      return machine.has_bjjcz_board();
    case kMarkBoard:
      return machine.has_mark_line() && machine.has_bjjcz_board();
    default:
      return true;
  }
}

/// The field at the end of a path; a step into a list takes its first element.
const google::protobuf::FieldDescriptor* FieldOf(const google::protobuf::Message*& at,
                                                 std::string_view path) {
  for (;;) {
    const auto dot = path.find('.');
    const std::string_view step = path.substr(0, dot);
    const auto* field =
        at->GetDescriptor()->FindFieldByName(std::string(step.substr(0, step.find('['))));
    if (dot == std::string_view::npos) return field;
    const auto& reflection = *at->GetReflection();
    at = field->is_repeated() ? &reflection.GetRepeatedMessage(*at, field, 0)
                              : &reflection.GetMessage(*at, field);
    path.remove_prefix(dot + 1);
  }
}

/// The present value as a person writes it.
std::string TextOf(const MachineSpec& machine, std::string_view path) {
  const google::protobuf::Message* message = &machine;
  const auto& field = *FieldOf(message, path);
  const auto& reflection = *message->GetReflection();
  using google::protobuf::FieldDescriptor;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection.GetString(*message, &field);
    case FieldDescriptor::CPPTYPE_ENUM: {
      const std::string& name = reflection.GetEnum(*message, &field)->name();
      std::string last = name.substr(name.rfind('_') + 1);
      std::ranges::transform(last, last.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
      });
      return last;
    }
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      const auto& v =
          dynamic_cast<const Vector3&>(reflection.GetMessage(*message, &field));
      return fmt::format("{} {} {}", v.x(), v.y(), v.z());
    }
    case FieldDescriptor::CPPTYPE_UINT32:
      return fmt::format("{}", reflection.GetUInt32(*message, &field));
    default:
      return fmt::format("{}", reflection.GetDouble(*message, &field));
  }
}

/// The first mistake of the profile that begins with the field; empty: none.
std::string MistakeOf(const MachineSpec& machine, const std::string& field) {
  for (const Error& error : CheckMachine(machine)) {
    if (error.message.starts_with(field)) return error.message;
  }
  return {};
}

void Ask(const Question& question, std::istream& in, std::ostream& out,
         MachineSpec& machine) {
  for (;;) {
    out << fmt::format("{} [{}]: ", question.text, TextOf(machine, question.field))
        << std::flush;
    std::string answer;
    if (!std::getline(in, answer) || answer.empty()) return;
    MachineSpec changed = machine;
    const Status set = SetField(changed, question.field, answer);
    const std::string mistake =
        set ? MistakeOf(changed, question.field) : set.error().message;
    if (mistake.empty()) {
      machine = std::move(changed);
      return;
    }
    out << "  " << mistake << "\n";
  }
}

}  // namespace

void AskAboutMachine(std::istream& in, std::ostream& out, MachineSpec& machine) {
  for (const Question& question : kQuestions) {
    if (IsAskedOf(question.machines, machine)) Ask(question, in, out, machine);
  }
}

Status ChangeField(MachineSpec& machine, const std::string& change) {
  const auto equals = change.find('=');
  if (equals == std::string::npos || equals == 0) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("--set {}: is no field=value, e.g. x.travel_max_mm=300", change),
        change);
  }
  const Status set =
      SetField(machine, change.substr(0, equals), change.substr(equals + 1));
  if (set) return {};
  Error error = set.error();
  error.message = "--set " + error.message;
  return tl::unexpected(error);
}

}  // namespace intaglio::cli
