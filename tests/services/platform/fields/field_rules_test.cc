// What every rule beside a field of a file that people write owes. A new field needs no
// line here.

#include "services/platform/fields/field_rules.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <regex>

#include "proto/drive.pb.h"
#include "proto/job.pb.h"
#include "proto/laser_board.pb.h"
#include "proto/machine.pb.h"
#include "proto/stage_board.pb.h"
#include "proto/truth.pb.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

/// The files that people write.
std::vector<const pb::FileDescriptor*> WrittenFiles() {
  return {JobSpec::descriptor()->file(),     Course::descriptor()->file(),
          Marks::descriptor()->file(),       Text::descriptor()->file(),
          MachineSpec::descriptor()->file(), MachineTruth::descriptor()->file(),
          LaserBoard::descriptor()->file(),  StageBoard::descriptor()->file(),
          DriveProfile::descriptor()->file()};
}

std::vector<const Field*> WrittenFields() {
  std::vector<const Field*> fields;
  for (const pb::FileDescriptor* file : WrittenFiles()) {
    for (int m = 0; m < file->message_type_count(); ++m) {
      if (file->message_type(m) == Vector3::descriptor()) continue;
      for (const Field* field : FieldsOf(*file->message_type(m))) fields.push_back(field);
    }
  }
  return fields;
}

bool IsVector(const Field& field) {
  return field.message_type() == Vector3::descriptor();
}

bool IsWhole(const Field& field) {
  return field.cpp_type() == Field::CPPTYPE_UINT32 ||
         field.cpp_type() == Field::CPPTYPE_INT32 ||
         field.cpp_type() == Field::CPPTYPE_UINT64;
}

bool IsNumber(const Field& field) {
  return IsVector(field) || IsWhole(field) || field.cpp_type() == Field::CPPTYPE_DOUBLE;
}

TEST(FieldRules, EveryNumberHasARangeOrAReasonForNone) {
  int ranges = 0;
  for (const Field* field : WrittenFields()) {
    const FieldRule& rule = RuleOf(*field);
    EXPECT_EQ(IsNumber(*field), rule.has_min() || !rule.any_value().empty())
        << field->full_name();
    EXPECT_EQ(rule.has_min(), rule.has_max()) << field->full_name();
    EXPECT_FALSE(rule.has_min() && !rule.any_value().empty()) << field->full_name();
    if (!rule.has_min()) continue;
    EXPECT_LT(rule.min(), rule.max()) << field->full_name();
    ++ranges;
  }
  EXPECT_GT(ranges, 350);
}

TEST(FieldRules, DefaultsAreWithinTheirRange) {
  for (const Field* field : WrittenFields()) {
    const FieldRule& rule = RuleOf(*field);
    EXPECT_FALSE(rule.has_default_value() && !rule.default_field().empty())
        << field->full_name();
    EXPECT_TRUE(!rule.has_default_ratio() || !rule.default_field().empty())
        << field->full_name();
    if (!rule.has_default_value()) continue;
    if (field->cpp_type() == Field::CPPTYPE_BOOL) {
      EXPECT_EQ(rule.default_value(), 1) << "false needs no rule, " << field->full_name();
    } else if (rule.has_min()) {
      EXPECT_GE(rule.default_value(), rule.min()) << field->full_name();
      EXPECT_LE(rule.default_value(), rule.max()) << field->full_name();
    }
    // What is 0 when it is absent has no other default.
    if (!field->has_presence() && !field->is_repeated()) {
      EXPECT_EQ(rule.default_value(), 0) << field->full_name();
    }
  }
}

TEST(FieldRules, OptionsHaveAMeaningAndImagesAreTexts) {
  for (const Field* field : WrittenFields()) {
    const FieldRule& rule = RuleOf(*field);
    EXPECT_EQ(rule.option().empty(), rule.meaning().empty()) << field->full_name();
    EXPECT_TRUE(rule.option().empty() || rule.option().starts_with("--"))
        << field->full_name();
    EXPECT_TRUE(!rule.names_image() || field->cpp_type() == Field::CPPTYPE_STRING)
        << field->full_name();
  }
}

// A range or a default that a comment repeats is written twice.
TEST(FieldRules, CommentsRepeatNoRangeAndNoDefault) {
  static const std::regex kField(R"(^\s+(?:optional |repeated )?\w+ (\w+) = \d+[ ;])");
  static const std::regex kRepeated(
      R"(\d\.\.-?\d|[Dd]efault:? (?:-?\d+(?:\.\d+)?|true|false)(?:[,;]|\.?$|\. ))");
  for (const pb::FileDescriptor* file : WrittenFiles()) {
    std::ifstream stream(INTAGLIO_SOURCE_DIR "/" + file->name());
    std::string comment;
    for (std::string line; std::getline(stream, line);) {
      const auto at = line.find("//");
      if (at != std::string::npos) comment += line.substr(at + 2);
      std::smatch field;
      if (std::regex_search(line, field, kField)) {
        const bool ruled = line.find("(rules)") != std::string::npos;
        EXPECT_FALSE(ruled && std::regex_search(comment, kRepeated))
            << file->name() << ": " << field[1] << ":" << comment;
        comment.clear();
      } else if (at == std::string::npos) {
        comment.clear();
      }
    }
  }
}

// A message of the field's type with the field, all of it, set to the value.
std::unique_ptr<pb::Message> MessageWith(const Field& field, double value) {
  std::unique_ptr<pb::Message> message(pb::MessageFactory::generated_factory()
                                           ->GetPrototype(field.containing_type())
                                           ->New());
  const pb::Reflection& reflection = *message->GetReflection();
  const bool repeated = field.is_repeated();
  if (IsVector(field)) {
    auto* vector = dynamic_cast<Vector3*>(
        repeated ? reflection.AddMessage(message.get(), &field)
                 : reflection.MutableMessage(message.get(), &field));
    vector->set_x(value), vector->set_y(value), vector->set_z(value);
  } else if (field.cpp_type() == Field::CPPTYPE_UINT32) {
    const auto whole = static_cast<std::uint32_t>(value);
    repeated ? reflection.AddUInt32(message.get(), &field, whole)
             : reflection.SetUInt32(message.get(), &field, whole);
  } else if (field.cpp_type() == Field::CPPTYPE_INT32) {
    const auto whole = static_cast<std::int32_t>(value);
    repeated ? reflection.AddInt32(message.get(), &field, whole)
             : reflection.SetInt32(message.get(), &field, whole);
  } else {
    repeated ? reflection.AddDouble(message.get(), &field, value)
             : reflection.SetDouble(message.get(), &field, value);
  }
  return message;
}

// Other fields of the same message may be missing; only this one counts.
int FaultsOf(const Field& field, double value) {
  const auto faults = NumbersOutOfRange(*MessageWith(field, value), "");
  return static_cast<int>(
      std::count_if(faults.begin(), faults.end(), [&](const NumberFault& fault) {
        return fault.field == field.name() ||
               fault.field.starts_with(field.name() + ".") ||
               fault.field.starts_with(field.name() + "[");
      }));
}

TEST(FieldRules, RangesAreEnforcedAtBothEnds) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Field* field : WrittenFields()) {
    const auto range = FindRange(*field);
    if (!range) continue;
    SCOPED_TRACE(field->full_name());
    const bool whole = IsWhole(*field);
    const int components = IsVector(*field) ? 3 : 1;
    EXPECT_EQ(FaultsOf(*field, range->min), 0);
    EXPECT_EQ(FaultsOf(*field, range->max), 0);
    const double below = whole ? range->min - 1 : std::nextafter(range->min, -infinity);
    const double above = whole ? range->max + 1 : std::nextafter(range->max, infinity);
    EXPECT_EQ(FaultsOf(*field, below), components);
    EXPECT_EQ(FaultsOf(*field, above), components);
    if (whole) continue;
    for (const double value : {infinity, -infinity, std::nan("")})
      EXPECT_EQ(FaultsOf(*field, value), components) << value;
  }
}

TEST(FieldRules, AFaultNamesTheFieldTheValueAndTheRange) {
  JobSpec job;
  job.add_models();
  job.add_models()->mutable_copies()->mutable_step_mm()->set_y(-1);
  const auto faults = NumbersOutOfRange(job, "job");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].field, "job.models[1].copies.step_mm.y");
  EXPECT_EQ(faults[0].error.message,
            "job.models[1].copies.step_mm.y: -1 is outside 0..1000");
  EXPECT_EQ(faults[0].error.value, "-1");
}

TEST(FieldRules, AbsentMessagesAreZerosOnlyWhereThatIsAsked) {
  const DriveProfile profile;
  const auto skipped = NumbersOutOfRange(profile, "");
  const auto checked = NumbersOutOfRange(profile, "", AbsentMessages::kChecked);
  const auto names = [](const std::vector<NumberFault>& faults, const char* field) {
    return std::any_of(faults.begin(), faults.end(),
                       [&](const NumberFault& fault) { return fault.field == field; });
  };
  EXPECT_FALSE(names(skipped, "controller.period_s"));
  EXPECT_TRUE(names(checked, "controller.period_s"));
  EXPECT_TRUE(names(skipped, "max_speed_m_s"));
}

// ---- defaults ------------------------------------------------------------------------

TEST(FieldDefaults, FillInWhatIsAbsentAndKeepWhatIsThere) {
  MarkPen pen;
  pen.set_power_ratio(0);
  FillDefaults(pen);
  EXPECT_EQ(pen.power_ratio(), 0);
  EXPECT_EQ(pen.speed_mm_s(), 1000);
  EXPECT_EQ(pen.pass_count(), 1u);
  Placement placement;
  FillDefaults(placement);
  EXPECT_EQ(placement.scale_ratio().y(), 1);
  EXPECT_TRUE(placement.centre_in_block());
}

TEST(FieldDefaults, FollowFromOtherNumbers) {
  HalftoneMethod halftone;
  FillDefaults(halftone, {"min_spacing_mm", 0.1});
  EXPECT_EQ(halftone.distance_mm(), 0.1);
  EXPECT_EQ(halftone.layer_distance_mm(), 0.2);
  HalftoneMethod without;
  FillDefaults(without, {"min_spacing_mm", 0});
  EXPECT_FALSE(without.has_distance_mm());
  EXPECT_FALSE(without.has_layer_distance_mm());
}

TEST(FieldDefaults, OfSingleFieldsFillNoOthers) {
  Course course;
  FillDefaults(course, {Course::kSpeedMmSFieldNumber});
  EXPECT_EQ(course.speed_mm_s(), 5);
  EXPECT_FALSE(course.has_travel_mm_s());
}

}  // namespace
}  // namespace intaglio
