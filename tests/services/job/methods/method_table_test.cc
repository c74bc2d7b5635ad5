// What every row of the table of methods owes. A new method needs no line here.

#include "services/job/methods/method_table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>
#include <thread>

#include "engrave/discretize/cloud.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/fields/shapes.h"
#include "services/job/methods/point_maker.h"
#include "services/job/models/model_sources.h"
#include "services/platform/fields/field_defaults.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/source_checks.h"
#include "tests/services/job/methods/small_models.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

class EveryMethod : public testing::TestWithParam<const Method*> {
 protected:
  const Method& method_ = *GetParam();

  std::unique_ptr<pb::Message> Empty() const {
    return std::unique_ptr<pb::Message>(
        pb::MessageFactory::generated_factory()->GetPrototype(&method_.message())->New());
  }
};

std::vector<const Method*> Rows() {
  std::vector<const Method*> rows;
  for (const Method& method : Methods()) rows.push_back(&method);
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Rows, EveryMethod, testing::ValuesIn(Rows()),
                         [](const auto& row) { return row.param->name(); });

// ---- the table and the schema --------------------------------------------------------

TEST(MethodTable, HasARowForEachMemberOfTheSchema) {
  const auto& choice = *Model::descriptor()->FindOneofByName("method");
  ASSERT_EQ(Methods().size(), static_cast<std::size_t>(choice.field_count()));
  for (int i = 0; i < choice.field_count(); ++i) {
    EXPECT_EQ(Methods()[static_cast<std::size_t>(i)].number, choice.field(i)->number());
  }
}

TEST(MethodTable, HasOneDefaultForEachKindOfModel) {
  for (const ModelKind kind :
       {ModelKind::kMesh, ModelKind::kDrawing, ModelKind::kText, ModelKind::kImage}) {
    const auto count =
        std::count_if(Methods().begin(), Methods().end(), [kind](const Method& method) {
          return std::count(method.default_of.begin(), method.default_of.end(), kind) > 0;
        });
    EXPECT_EQ(count, 1);
    ASSERT_NE(DefaultMethodOf(kind), nullptr);
    EXPECT_TRUE(DefaultMethodOf(kind)->Suits(kind));
  }
  EXPECT_EQ(DefaultMethodOf(ModelKind::kCloud), nullptr);
}

// The job's `discretization` is the method of meshes that have none.
TEST_P(EveryMethod, OfMeshesIsAMemberOfDiscretization) {
  EXPECT_EQ(FieldInDiscretization(method_) != nullptr, method_.Suits(ModelKind::kMesh));
  if (const auto* field = FieldInDiscretization(method_)) {
    EXPECT_EQ(field->message_type(), &method_.message());
  }
}

TEST_P(EveryMethod, IsMadeOfWhatItsKindsAreReadAs) {
  ASSERT_FALSE(method_.kinds.empty());
  for (const ModelKind kind : method_.kinds) {
    const std::size_t taken = kind == ModelKind::kMesh    ? 0
                              : kind == ModelKind::kImage ? 2
                                                          : 1;
    EXPECT_EQ(MakerOf(method_).make.index(), taken);
    EXPECT_NE(kind, ModelKind::kCloud);
  }
}

TEST_P(EveryMethod, HasAnOptionOfItsOwnForEachField) {
  std::set<std::string_view> options;
  for (const auto* field : FieldsOf(method_.message())) {
    const FieldRule& rule = RuleOf(*field);
    EXPECT_TRUE(rule.option().starts_with("--")) << field->name();
    EXPECT_TRUE(options.insert(rule.option()).second) << rule.option();
    EXPECT_EQ(rule.names_image(),
              field->cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING)
        << field->name();
  }
}

// ---- defaults ------------------------------------------------------------------------

TEST_P(EveryMethod, HasDefaultsWithinItsRanges) {
  const NumberRange spacing =
      RangeOf<Discretization>(Discretization::kMinSpacingMmFieldNumber);
  for (const double spacing_mm : {spacing.min, spacing.max}) {
    const auto message = Empty();
    FillDefaults(*message, {"min_spacing_mm", spacing_mm});
    std::vector<Error> errors;
    CheckRanges(*message, "", errors);
    for (const Error& error : errors) ADD_FAILURE() << error.message;
    for (const auto* field : FieldsOf(method_.message())) {
      const FieldRule& rule = RuleOf(*field);
      if (!rule.has_default_value() && rule.default_field().empty()) continue;
      EXPECT_TRUE(field->is_repeated()
                      ? message->GetReflection()->FieldSize(*message, field) == 1
                      : message->GetReflection()->HasField(*message, field))
          << field->name();
    }
  }
}

// A number of another field is there only when that is filled in before.
TEST_P(EveryMethod, TakesDefaultsFromFieldsAbove) {
  std::set<std::string> above = {"min_spacing_mm"};
  for (const auto* field : FieldsOf(method_.message())) {
    const std::string& base = RuleOf(*field).default_field();
    EXPECT_TRUE(base.empty() || above.contains(base)) << field->name();
    above.insert(field->name());
  }
}

TEST_P(EveryMethod, KeepsWhatIsThere) {
  for (const auto* field : FieldsOf(method_.message())) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_DOUBLE || field->is_repeated())
      continue;
    const auto message = Empty();
    const pb::Reflection& reflection = *message->GetReflection();
    reflection.SetDouble(message.get(), field, 0.0625);  // no default
    FillDefaults(*message, {"min_spacing_mm", 0.3});
    EXPECT_EQ(reflection.GetDouble(*message, field), 0.0625) << field->name();
  }
}

// ---- points --------------------------------------------------------------------------

void ThreeWorkers(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> workers;
  for (int i = 0; i < 3; ++i) {
    workers.emplace_back([&] {
      for (std::size_t at = next++; at < count; at = next++) work(at);
    });
  }
}

class PointsOfEveryMethod : public EveryMethod {
 protected:
  PointsOfEveryMethod() {
    JobSpec job = GoodJob();
    Model& model = *job.mutable_models(0);
    const SmallModel small = SmallModelOf(method_.kinds.front());
    model.set_file(small.file);
    model.mutable_placement()->set_fit_size_mm(12);
    MutableMessageOf(method_, model);
    job_ = WithDefaults(job, GoodMachine());
    sources_ = MakeSources(job_, {small.bytes}, {}, {}).value().sources;
  }

  discretize::Discretized Make(const discretize::Part& part,
                               const Executor& executor) const {
    return discretize::MakeCloud(sources_, CloudOptionsOf(job_), part, executor, {})
        .value();
  }

  JobSpec job_;
  discretize::Sources sources_;
};

INSTANTIATE_TEST_SUITE_P(Rows, PointsOfEveryMethod, testing::ValuesIn(Rows()),
                         [](const auto& row) { return row.param->name(); });

TEST_P(PointsOfEveryMethod, LieInTheBlockAndKeepTheSpacing) {
  const auto made = Make({}, {});
  EXPECT_GT(made.cloud.size(), 100u);
  EXPECT_GE(discretize::MinDistance(made.cloud.points_mm),
            job_.discretization().min_spacing_mm());
  const Box3 permitted = PermittedBoxOf(job_.block());
  for (const Vec3& p : made.cloud.points_mm) {
    EXPECT_TRUE((p.array() >= permitted.min_mm.array()).all() &&
                (p.array() <= permitted.max_mm.array()).all());
  }
}

TEST_P(PointsOfEveryMethod, AreTheSameOfOneAndOfThreeWorkers) {
  const auto alone = Make({}, {});
  const auto by_three = Make({}, ThreeWorkers);
  EXPECT_EQ(by_three.cloud.points_mm, alone.cloud.points_mm);
  PointList together;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto part = Make({i, 3}, {});
    together.insert(together.end(), part.cloud.points_mm.begin(),
                    part.cloud.points_mm.end());
  }
  EXPECT_EQ(together, alone.cloud.points_mm);
}

TEST_P(PointsOfEveryMethod, AreTheSameInEveryCutByHeight) {
  for (const auto& source : sources_) {
    const Box3 bounds = source->Bounds();
    const double low_mm = bounds.min_mm.z(), height_mm = bounds.size_mm().z();
    discretize::ExpectSlabsAreTheWhole(
        *source, {low_mm + 0.31 * height_mm, low_mm + 0.5 * height_mm, low_mm});
  }
}

}  // namespace
}  // namespace intaglio
