#include "services/replayer/option_differences.h"

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

namespace intaglio::replayer {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;
using google::protobuf::util::MessageDifferencer;

class Collector final : public MessageDifferencer::Reporter {
 public:
  using Path = std::vector<MessageDifferencer::SpecificField>;
  void ReportAdded(const Message& then, const Message& now, const Path& path) override {
    Add(then, now, path, false, true);
  }
  void ReportDeleted(const Message& then, const Message& now, const Path& path) override {
    Add(then, now, path, true, false);
  }
  /// Also reported for the groups around the field.
  void ReportModified(const Message& then, const Message& now,
                      const Path& path) override {
    const FieldDescriptor* field = path.back().field;
    if (field == nullptr || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE)
      Add(then, now, path, true, true);
  }
  std::vector<OptionDifference> Take() { return std::move(differences_); }

 private:
  static std::string ValueAt(const Message& message, const FieldDescriptor* field,
                             int index) {
    std::string text;
    TextFormat::Printer printer;
    printer.SetSingleLineMode(true);
    printer.PrintFieldValueToString(message, field, field->is_repeated() ? index : -1,
                                    &text);
    return text;
  }
  void Add(const Message& then, const Message& now, const Path& path, bool was, bool is) {
    OptionDifference difference;
    std::string& name = *difference.mutable_field();
    for (const auto& step : path) {
      if (step.field == nullptr) return;
      if (!name.empty()) name += '.';
      name += step.field->name();
      const int index = step.index >= 0 ? step.index : step.new_index;
      if (step.field->is_repeated()) name += "[" + std::to_string(index) + "]";
    }
    const auto& last = path.back();
    if (was) difference.set_then(ValueAt(then, last.field, last.index));
    if (is) difference.set_now(ValueAt(now, last.field, last.new_index));
    differences_.push_back(std::move(difference));
  }
  std::vector<OptionDifference> differences_;
};

FrozenJob OptionsOf(FrozenJob job) {
  job.clear_job_uid();
  job.clear_epoch();
  job.clear_software_version();
  job.clear_result_directory();
  return job;
}

}  // namespace

std::vector<OptionDifference> OptionDifferences(const FrozenJob& then,
                                                const FrozenJob& now) {
  Collector collector;
  MessageDifferencer differencer;
  differencer.set_message_field_comparison(MessageDifferencer::EQUIVALENT);
  differencer.ReportDifferencesTo(&collector);
  (void)differencer.Compare(OptionsOf(then), OptionsOf(now));
  return collector.Take();
}

}  // namespace intaglio::replayer
