#include "services/job/field_ranges.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <regex>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;
using Ranges = std::map<std::string, std::pair<double, double>>;

// The ranges that the comments of a .proto file promise: "a..b" in the comment above a
// field or behind it.
Ranges DocumentedRanges(const std::string& file) {
  static const std::regex kMessage(R"(^message (\w+) \{)");
  static const std::regex kField(R"(^\s+(?:optional |repeated )?\w+ (\w+) = \d+;(.*))");
  static const std::regex kRange(
      R"((-?\d+(?:\.\d+)?(?:e\d+)?)\.\.(-?\d+(?:\.\d+)?(?:e\d+)?))");
  Ranges ranges;
  std::ifstream stream(file);
  std::string line, message, comment;
  while (std::getline(stream, line)) {
    std::smatch match;
    if (std::regex_search(line, match, kMessage)) message = match[1];
    if (std::regex_search(line, match, kField)) {
      const std::string name = match[1];
      comment += match[2];
      std::smatch range;
      if (std::regex_search(comment, range, kRange)) {
        ranges[fmt::format("{}.{}", message, name)] = {std::stod(range[1]),
                                                       std::stod(range[2])};
      }
      comment.clear();
    } else if (line.find("//") != std::string::npos) {
      comment += line.substr(line.find("//"));
    } else {
      comment.clear();
    }
  }
  return ranges;
}

TEST(FieldRanges, CommentsAndTableAgree) {
  Ranges documented = DocumentedRanges(INTAGLIO_SOURCE_DIR "/proto/job.proto");
  documented.merge(DocumentedRanges(INTAGLIO_SOURCE_DIR "/proto/machine.proto"));
  documented.merge(DocumentedRanges(INTAGLIO_SOURCE_DIR "/proto/course.proto"));
  documented.merge(DocumentedRanges(INTAGLIO_SOURCE_DIR "/proto/mark.proto"));
  documented.merge(DocumentedRanges(INTAGLIO_SOURCE_DIR "/proto/text.proto"));
  Ranges table;
  for (const FieldRange& range : FieldRanges()) {
    table[fmt::format("{}.{}", range.message, range.field)] = {range.min, range.max};
  }
  EXPECT_THAT(table, testing::ContainerEq(documented));
}

// Every number that a person can write has a range (but the seed, where all are right).
TEST(FieldRanges, EveryNumberHasOne) {
  for (const pb::FileDescriptor* file :
       {JobSpec::descriptor()->file(), MachineSpec::descriptor()->file(),
        Course::descriptor()->file(), Marks::descriptor()->file(),
        Text::descriptor()->file()}) {
    for (int m = 0; m < file->message_type_count(); ++m) {
      const pb::Descriptor& type = *file->message_type(m);
      if (type.name() == "Vector3") continue;
      for (int f = 0; f < type.field_count(); ++f) {
        const pb::FieldDescriptor& field = *type.field(f);
        const bool number =
            field.type() == pb::FieldDescriptor::TYPE_DOUBLE ||
            field.type() == pb::FieldDescriptor::TYPE_UINT32 ||
            field.type() == pb::FieldDescriptor::TYPE_INT32 ||
            (field.message_type() && field.message_type()->name() == "Vector3");
        if (number) {
          EXPECT_NE(FindRange(type.name(), field.name()), nullptr) << field.full_name();
        }
      }
    }
  }
}

// A message of the type with the field, all of it, set to the value.
std::unique_ptr<pb::Message> MessageWith(const FieldRange& range, double value) {
  const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(
      "intaglio." + std::string(range.message));
  std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(type)->New());
  const auto* field = type->FindFieldByName(std::string(range.field));
  const pb::Reflection& reflection = *message->GetReflection();
  if (field->message_type() != nullptr) {
    auto* vector = dynamic_cast<Vector3*>(
        field->is_repeated() ? reflection.AddMessage(message.get(), field)
                             : reflection.MutableMessage(message.get(), field));
    vector->set_x(value), vector->set_y(value), vector->set_z(value);
  } else if (field->type() == pb::FieldDescriptor::TYPE_UINT32) {
    const auto whole = static_cast<std::uint32_t>(value);
    if (field->is_repeated()) {
      reflection.AddUInt32(message.get(), field, whole);
    } else {
      reflection.SetUInt32(message.get(), field, whole);
    }
  } else if (field->type() == pb::FieldDescriptor::TYPE_INT32) {
    reflection.SetInt32(message.get(), field, static_cast<std::int32_t>(value));
  } else if (field->is_repeated()) {
    reflection.AddDouble(message.get(), field, value);
  } else {
    reflection.SetDouble(message.get(), field, value);
  }
  return message;
}

int ErrorsOf(const FieldRange& range, double value) {
  std::vector<Error> errors;
  CheckRanges(*MessageWith(range, value), "", errors);
  // Other fields of the same message may be missing; only this one counts.
  return static_cast<int>(
      std::count_if(errors.begin(), errors.end(),
                    [&](const Error& e) { return e.message.starts_with(range.field); }));
}

TEST(FieldRanges, AreEnforcedAtBothEnds) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const FieldRange& range : FieldRanges()) {
    SCOPED_TRACE(fmt::format("{}.{}", range.message, range.field));
    const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(
        "intaglio." + std::string(range.message));
    const auto* field = type->FindFieldByName(std::string(range.field));
    const bool whole = field->type() == pb::FieldDescriptor::TYPE_UINT32 ||
                       field->type() == pb::FieldDescriptor::TYPE_INT32;
    const int components = field->message_type() != nullptr ? 3 : 1;
    EXPECT_EQ(ErrorsOf(range, range.min), 0);
    EXPECT_EQ(ErrorsOf(range, range.max), 0);
    const double below = whole ? range.min - 1 : std::nextafter(range.min, -infinity);
    const double above = whole ? range.max + 1 : std::nextafter(range.max, infinity);
    EXPECT_EQ(ErrorsOf(range, below), components);
    EXPECT_EQ(ErrorsOf(range, above), components);
    if (whole) continue;
    for (const double value : {infinity, -infinity, std::nan("")}) {
      EXPECT_EQ(ErrorsOf(range, value), components) << value;
    }
  }
}

}  // namespace
}  // namespace intaglio
