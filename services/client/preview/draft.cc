#include "services/client/preview/draft.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "services/client/preview/preview_picture.h"
#include "services/client/preview/preview_text.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/job_cloud.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

// A part of the block's diagonal: some thousand points of a surface, in milliseconds.
constexpr double kProbeSpacing = 1.0 / 100;
constexpr double kProbeRatio = 1.6;
// What a picture of this size shows.
constexpr double kDraftPoints = 60'000;
constexpr char kMinSpacing[] = "min_spacing_mm";

bool IsOfMeshes(const JobSpec& job) {
  return std::all_of(job.models().begin(), job.models().end(), [](const Model& model) {
    const auto kind = KindOf(model);
    return kind && *kind == ModelKind::kMesh;
  });
}

bool IsQuicklyRead(const JobSpec& job) {
  std::uintmax_t bytes = 0;
  for (const std::string& file : FilesOf(job)) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (error || size > kMaxDraftBytes - bytes) return false;
    bytes += size;
  }
  return true;
}

bool IsSpacing(const pb::FieldDescriptor& field) {
  return field.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE &&
         !field.is_repeated() &&
         (field.name() == kMinSpacing || RuleOf(field).default_field() == kMinSpacing);
}

void Scale(pb::Message& message, double factor) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const pb::FieldDescriptor* const field : set) {
    if (IsSpacing(*field)) {
      const double scaled = factor * reflection.GetDouble(message, field);
      const auto range = FindRange(*field);
      reflection.SetDouble(&message, field,
                           range ? std::min(scaled, range->max) : scaled);
    } else if (field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
      const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
      for (int i = 0; i < count; ++i) {
        Scale(field->is_repeated()
                  ? *reflection.MutableRepeatedMessage(&message, field, i)
                  : *reflection.MutableMessage(&message, field),
              factor);
      }
    }
  }
}

double DiagonalOf(const JobSpec& job) {
  const Vector3& size = job.block().size_mm();
  return std::hypot(size.x(), size.y(), size.z());
}

std::optional<JobCloud> CloudWith(const JobSpec& job, const PreviewOptions& options,
                                  double factor) {
  auto made =
      MakeJobCloud(WithSpacings(job, factor), options.limits, options.executor, {});
  return made ? std::optional(std::move(*made)) : std::nullopt;
}

/// How many points there are with spacings `factor` times those of the job.
struct Count {
  double points = 0, factor = 1;
};

double ExponentOf(const Count& coarse, const Count& fine) {
  const double exponent =
      std::log(fine.points / coarse.points) / std::log(coarse.factor / fine.factor);
  return std::clamp(exponent, 1.0, 3.0);
}

double ExpectedOf(const Count& count, double exponent) {
  return count.points * std::pow(count.factor, exponent);
}

/// To two digits: more are not known.
std::uint64_t Rounded(double count) {
  const double unit = std::pow(10, std::floor(std::log10(std::max(count, 10.0))) - 1);
  return static_cast<std::uint64_t>(std::llround(count / unit) * std::llround(unit));
}

}  // namespace

JobSpec WithSpacings(JobSpec job, double factor) {
  for (Model& model : *job.mutable_models()) Scale(model, factor);
  Scale(*job.mutable_discretization(), factor);
  return job;
}

std::optional<Preview> MakeDraft(const FrozenJob& job, const PreviewOptions& options) {
  const JobSpec& spec = job.job();
  const double spacing_mm = spec.discretization().min_spacing_mm();
  const double probe = kProbeSpacing * DiagonalOf(spec) / spacing_mm;
  if (!IsOfMeshes(spec) || !IsQuicklyRead(spec) || probe <= kProbeRatio)
    return std::nullopt;
  const auto coarse = CloudWith(spec, options, probe);
  const auto finer = CloudWith(spec, options, probe / kProbeRatio);
  if (!coarse || !finer) return std::nullopt;
  const Count probed = {static_cast<double>(finer->cloud.size()), probe / kProbeRatio};
  double exponent =
      ExponentOf({static_cast<double>(coarse->cloud.size()), probe}, probed);
  const double expected = ExpectedOf(probed, exponent);
  if (expected < kPointsWithoutDraft) return std::nullopt;
  const double factor = std::pow(expected / kDraftPoints, 1 / exponent);
  const auto made = CloudWith(spec, options, factor);
  if (!made) return std::nullopt;
  const Count drafted = {static_cast<double>(made->cloud.size()), factor};
  if (factor < probed.factor) exponent = ExponentOf(probed, drafted);
  Preview draft;
  JobPreview& figures = draft.figures;
  figures.set_name(spec.name());
  figures.set_software_version(job.software_version());
  figures.set_made_utc(options.made_utc);
  figures.set_verdict(kDraft);
  figures.set_draft_count(made->cloud.size());
  figures.set_point_count(Rounded(ExpectedOf(drafted, exponent)));
  figures.set_min_spacing_mm(spacing_mm);
  SetPlace(spec, made->cloud.points_mm, figures);
  figures.set_glass(job.material().name());
  figures.set_machine(job.machine().name());
  figures.set_picture(kPreviewFile);
  draft.pictures.push_back(
      {figures.picture(), DrawPreview(figures, made->cloud.points_mm)});
  draft.points_mm = made->cloud.points_mm;
  return draft;
}

}  // namespace intaglio::client
