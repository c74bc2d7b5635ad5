// Every field of every method has an option, and what is typed there is in the job.

#include "services/cli/flags/method_flags.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "services/job/fields/field_ranges.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::cli {
namespace {

namespace pb = google::protobuf;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Field = pb::FieldDescriptor;

Result<JobSpec> JobWith(const std::string& file, const std::vector<std::string>& words) {
  command_line::Program program("intaglio", "");
  MethodFlags flags;
  AddMethodFlags(program.root(), flags);
  if (auto parsed = program.Parse(words); !parsed) return tl::unexpected(parsed.error());
  JobSpec job;
  job.add_models()->set_file(file);
  if (auto set = SetMethods(flags, job); !set) return tl::unexpected(set.error());
  return job;
}

std::string RefusedWith(const std::string& file, const std::vector<std::string>& words) {
  const auto job = JobWith(file, words);
  return job ? "" : job.error().message;
}

std::string FileOf(const Method& method) {
  return method.Suits(ModelKind::kMesh)    ? "a.stl"
         : method.Suits(ModelKind::kImage) ? "a.png"
                                           : "a.svg";
}

/// Where the method is in a job of one such model.
const pb::Message& MessageIn(const JobSpec& job, const Method& method) {
  if (FieldInDiscretization(method) != nullptr) {
    return MessageOf(method, job.discretization());
  }
  return MessageOf(method, job.models(0));
}

/// What is typed for a field, and the message with that alone.
struct Sample {
  std::string text;
  std::unique_ptr<pb::Message> message;
};

Sample SampleFor(const Method& method, const Field& field) {
  Sample sample;
  sample.message.reset(
      pb::MessageFactory::generated_factory()->GetPrototype(&method.message())->New());
  pb::Message& message = *sample.message;
  const pb::Reflection& reflection = *message.GetReflection();
  const auto range = FindRange(field);
  const double number = range ? range->min + (range->max - range->min) / 4 : 0;
  switch (field.cpp_type()) {
    case Field::CPPTYPE_DOUBLE:
      sample.text = fmt::format("{}", number);
      if (field.is_repeated()) {
        sample.text = fmt::format("0,{}", number);
        reflection.AddDouble(&message, &field, 0);
        reflection.AddDouble(&message, &field, number);
      } else {
        reflection.SetDouble(&message, &field, number);
      }
      break;
    case Field::CPPTYPE_UINT32:
      sample.text = fmt::format("{}", range->max);
      reflection.SetUInt32(&message, &field, static_cast<std::uint32_t>(range->max));
      break;
    case Field::CPPTYPE_BOOL:
      sample.text = "true";
      reflection.SetBool(&message, &field, true);
      break;
    case Field::CPPTYPE_ENUM: {
      const auto& last = *field.enum_type()->value(field.enum_type()->value_count() - 1);
      sample.text = last.name();
      reflection.SetEnum(&message, &field, &last);
      break;
    }
    case Field::CPPTYPE_STRING:
      sample.text = "shade.png";
      reflection.SetString(&message, &field,
                           (std::filesystem::current_path() / "shade.png").string());
      break;
    default: {
      pb::Message* group = field.is_repeated()
                               ? reflection.AddMessage(&message, &field)
                               : reflection.MutableMessage(&message, &field);
      const pb::Descriptor& type = *group->GetDescriptor();
      for (int i = 0; i < type.field_count(); ++i) {
        sample.text += fmt::format("{}{}", i == 0 ? "" : ",", number + i / 8.0);
        group->GetReflection()->SetDouble(group, type.field(i), number + i / 8.0);
      }
    }
  }
  return sample;
}

TEST(MethodFlags, EveryFieldOfEveryMethodHasOne) {
  for (const Method& method : Methods()) {
    for (const Field* field : FieldsOf(method.message())) {
      SCOPED_TRACE(fmt::format("{} {}", method.name(), field->name()));
      const Sample sample = SampleFor(method, *field);
      // With =, so that a number below 0 is no option.
      const auto job = JobWith(
          FileOf(method), {"--method", method.name(),
                           fmt::format("{}={}", RuleOf(*field).option(), sample.text)});
      ASSERT_TRUE(job.has_value()) << job.error().message;
      EXPECT_TRUE(
          pb::util::MessageDifferencer::Equals(MessageIn(*job, method), *sample.message))
          << MessageIn(*job, method).ShortDebugString();
      std::vector<Error> errors;
      CheckRanges(*sample.message, "", errors);
      EXPECT_TRUE(errors.empty()) << errors[0].message;
    }
  }
}

TEST(MethodFlags, AMethodOfMeshesIsThatOfTheJob) {
  const auto job = JobWith("a.stl", {"--method", "fill", "--vertex", "0.5"});
  EXPECT_EQ(job->discretization().fill().vertex_distance_mm(), 0.5);
  EXPECT_EQ(job->models(0).method_case(), Model::METHOD_NOT_SET);
  EXPECT_TRUE(JobWith("a.stl", {})->discretization().has_even()) << "the default";
}

TEST(MethodFlags, AModelWithoutAMethodTakesThatOfItsKind) {
  EXPECT_EQ(JobWith("a.svg", {"--vertex", "0.5"})->models(0).curves().distance_mm(), 0.5);
  EXPECT_EQ(JobWith("a.png", {"--vertex", "0.5"})->models(0).halftone().distance_mm(),
            0.5);
  EXPECT_EQ(JobWith("a.xyz", {"--vertex", "0.5"})->models(0).method_case(),
            Model::METHOD_NOT_SET);
}

TEST(MethodFlags, AnOptionIsForAllMethodsOfTheJobThatHaveIt) {
  JobSpec job;
  job.add_models()->set_file("a.stl");
  job.add_models()->set_file("a.svg");
  job.add_models()->set_file("own.stl");
  job.mutable_models(2)->mutable_fill()->set_vertex_distance_mm(0.9);
  MethodFlags flags;
  flags.values["--vertex"] = "0.5";
  flags.values["--fill"] = "true";
  ASSERT_TRUE(SetMethods(flags, job));
  EXPECT_EQ(job.discretization().even().distance_mm(), 0.5);
  EXPECT_EQ(job.models(1).curves().distance_mm(), 0.5);
  EXPECT_TRUE(job.models(1).curves().fill());
  EXPECT_EQ(job.models(2).fill().vertex_distance_mm(), 0.9) << "of its own";
}

TEST(MethodFlags, WhatDoesNotFitIsNamedWithWhatDoes) {
  EXPECT_THAT(
      RefusedWith("a.stl", {"--method", "halftones"}),
      AllOf(HasSubstr("--method"), HasSubstr("'halftones' is none of sections, fill"),
            HasSubstr("did you mean halftone?")));
  EXPECT_THAT(RefusedWith("a.stl", {"--method", "relief"}), HasSubstr("an image"));
  EXPECT_THAT(RefusedWith("a.stl", {"--method", "rays", "--shells", "1"}),
              AllOf(HasSubstr("--shells"), HasSubstr("even"), HasSubstr("rays")));
  EXPECT_THAT(RefusedWith("a.stl", {"--vertex", "near"}),
              AllOf(HasSubstr("--vertex"), HasSubstr("'near' is not a number")));
  EXPECT_THAT(RefusedWith("a.png", {"--tone-curve", "0 1 0.5"}),
              AllOf(HasSubstr("--tone-curve"), HasSubstr("from, to")));
}

}  // namespace
}  // namespace intaglio::cli
