#include "services/synchronizer/task_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "engrave/optics/focus.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/checks/job_check.h"
#include "services/job/machine/machine_defaults.h"

namespace intaglio::synchronizer {
namespace {

using google::protobuf::Message;
using google::protobuf::util::FieldContext;
using google::protobuf::util::MessageDifferencer;
using FieldPath = std::vector<MessageDifferencer::SpecificField>;

constexpr double kSameValue = 1e-9;

/// e.g. lenses[1].numerical_aperture
std::string NameOf(const FieldPath& path) {
  std::string name;
  for (const auto& step : path) {
    name += (name.empty() ? "" : ".") + step.field->name();
    if (step.field->is_repeated()) {
      name += fmt::format("[{}]", step.index >= 0 ? step.index : step.new_index);
    }
  }
  return name;
}

std::string ValueOf(const Message& message, const MessageDifferencer::SpecificField& at,
                    int index) {
  std::string text;
  google::protobuf::TextFormat::PrintFieldValueToString(
      message, at.field, at.field->is_repeated() ? index : -1, &text);
  return text;
}

class Differences final : public MessageDifferencer::Reporter {
 public:
  void ReportAdded(const Message& /*of_job*/, const Message& own,
                   const FieldPath& path) override {
    Add(path, "not there", ValueOf(own, path.back(), path.back().new_index));
  }
  void ReportDeleted(const Message& of_job, const Message& /*own*/,
                     const FieldPath& path) override {
    Add(path, ValueOf(of_job, path.back(), path.back().index), "not there");
  }
  void ReportModified(const Message& of_job, const Message& own,
                      const FieldPath& path) override {
    // The fields of a message are reported besides.
    if (path.back().field->message_type() != nullptr) return;
    Add(path, ValueOf(of_job, path.back(), path.back().index),
        ValueOf(own, path.back(), path.back().new_index));
  }
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  void Add(const FieldPath& path, const std::string& of_job, const std::string& own) {
    texts_.push_back(fmt::format("{} is {} in the job's profile and {} in this machine's",
                                 NameOf(path), of_job, own));
  }
  std::vector<std::string> texts_;
};

std::vector<std::string> MachineDifferences(const MachineSpec& of_job,
                                            const MachineSpec& own) {
  MessageDifferencer differencer;
  Differences differences;
  differencer.ReportDifferencesTo(&differences);
  // What was taught since is the machine's own: a job is made with the newest
  // (Synchronizer::CheckZeros).
  for (const char* name : {"laser_line", "motion_line", "taught"}) {
    differencer.IgnoreField(MachineSpec::descriptor()->FindFieldByName(name));
  }
  differencer.Compare(of_job, own);
  return differences.texts();
}

void CompareOptics(const char* field, double of_task, double expected,
                   std::vector<std::string>& differences) {
  if (std::abs(of_task - expected) <= kSameValue) return;
  differences.push_back(fmt::format("optics.{} is {}, but the job's values give {}",
                                    field, of_task, expected));
}

// The stage's depth follows from these, and so does where the cracks come to lie.
std::vector<std::string> OpticsDifferences(const FrozenJob& task) {
  std::vector<std::string> differences;
  const OpticalValuesRecord& optics = task.optics();
  const double aperture = task.job().lens().numerical_aperture();
  const double index = optics.refractive_index();
  CompareOptics("wavelength_nm", optics.wavelength_nm(),
                task.job().laser().wavelength_nm(), differences);
  CompareOptics("numerical_aperture", optics.numerical_aperture(), aperture, differences);
  if (!(index >= 1 && std::isfinite(index)) || !(aperture > 0 && aperture < 1)) {
    differences.push_back(
        fmt::format("optics.refractive_index {} or lens.numerical_aperture {} is not "
                    "possible: they are at least 1 and between 0 and 1",
                    index, aperture));
    return differences;
  }
  CompareOptics("stage_per_glass_ratio", optics.stage_per_glass_ratio(),
                optics::StagePerGlassRatio(index, aperture), differences);
  CompareOptics("cone_tangent", optics.cone_tangent(),
                optics::ConeTangentInGlass(index, aperture), differences);
  return differences;
}

}  // namespace

Status CheckTask(const FrozenJob& task, const MachineSpec& profile,
                 const std::string& own_file) {
  const MachineSpec own = ForWavelengthOf(task.job().laser(), profile);
  std::vector<std::string> wrong =
      MachineDifferences(WithMachineDefaults(task.machine()), own);
  for (std::string& text : OpticsDifferences(task)) wrong.push_back(std::move(text));
  for (const Error& error :
       CheckJobOnMachine(task.job(), own, task.optics().stage_per_glass_ratio())) {
    wrong.push_back(error.message);
  }
  if (wrong.empty()) return {};
  return Fail(ErrorCode::kRefused,
              fmt::format("the profile of the job differs from that of this machine, {}: "
                          "{}; submit it again with the profile of this cell, {}",
                          own.name(), fmt::join(wrong, "; "), own_file),
              own_file);
}

}  // namespace intaglio::synchronizer
