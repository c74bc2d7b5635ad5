#include "services/cli/flags/method_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "engrave/core/check.h"
#include "services/cli/flags/field_options.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/field_path.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

/// "a mesh: sections (default), fill, rays; a drawing: curves (default)".
std::string MethodsByKind() {
  std::string text;
  for (const ModelKind kind :
       {ModelKind::kMesh, ModelKind::kDrawing, ModelKind::kText, ModelKind::kImage}) {
    std::vector<std::string> names;
    for (const Method& method : Methods()) {
      if (!method.Suits(kind)) continue;
      names.push_back(method.name() +
                      (DefaultMethodOf(kind) == &method ? " (default)" : ""));
    }
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", NameOf(kind),
                        fmt::join(names, ", "));
  }
  return text;
}

using Field = google::protobuf::FieldDescriptor;

/// The methods with a field of that option, each with the field.
std::vector<std::pair<const Method*, const Field*>> FieldsWith(
    const std::string& option) {
  std::vector<std::pair<const Method*, const Field*>> found;
  for (const Method& method : Methods()) {
    for (const Field* field : FieldsOf(method.message())) {
      if (RuleOf(*field).option() == option) found.emplace_back(&method, field);
    }
  }
  return found;
}

/// "sections: ...; curves, relief: ...": methods for which it means the same share the
/// text.
std::string HelpOf(const std::string& option) {
  std::vector<std::pair<std::string, std::string>> by_meaning;  // meaning, methods
  for (const auto& [method, field] : FieldsWith(option)) {
    const std::string unit = UnitText(field->name());
    const std::string meaning =
        RuleOf(*field).meaning() + (unit.empty() ? "" : ", " + unit);
    const auto same = std::find_if(by_meaning.begin(), by_meaning.end(),
                                   [&](const auto& m) { return m.first == meaning; });
    if (same == by_meaning.end()) {
      by_meaning.emplace_back(meaning, method->name());
    } else {
      same->second += ", " + method->name();
    }
  }
  std::string text;
  for (const auto& [meaning, methods] : by_meaning) {
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", methods, meaning);
  }
  return text;
}

Status ChooseMethod(const std::string& name, JobSpec& job) {
  const Method* method = FindMethod(name);
  Require(method != nullptr, "--method '{}' has passed its check", name);
  if (FieldInDiscretization(*method) != nullptr) {
    MutableMessageOf(*method, *job.mutable_discretization());
    return {};
  }
  bool suits_one = false;
  for (Model& model : *job.mutable_models()) {
    const auto kind = KindOf(model);
    if (!kind || !method->Suits(*kind)) continue;
    MutableMessageOf(*method, model);
    suits_one = true;
  }
  if (suits_one) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("--method '{}' makes points of {}, and the job has none", name,
                          NameOf(method->kinds.front())),
              name);
}

struct Target {
  const Method* method;
  google::protobuf::Message* message;
};

/// The methods that options are for.
std::vector<Target> TargetsIn(JobSpec& job) {
  Discretization& of_meshes = *job.mutable_discretization();
  const Method* method = MethodOf(of_meshes);
  std::vector<Target> targets = {{method, &MutableMessageOf(*method, of_meshes)}};
  for (Model& model : *job.mutable_models()) {
    method = MethodOf(model);
    const auto kind = KindOf(model);
    if (method == nullptr && kind) method = DefaultMethodOf(*kind);
    if (method == nullptr || FieldInDiscretization(*method) != nullptr) continue;
    targets.push_back({method, &MutableMessageOf(*method, model)});
  }
  return targets;
}

std::string NamesOf(const std::vector<const Method*>& methods) {
  std::vector<std::string> names;
  for (const Method* method : methods) {
    if (std::find(names.begin(), names.end(), method->name()) == names.end()) {
      names.push_back(method->name());
    }
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

tl::unexpected<Error> NoTarget(const std::string& option, const std::string& value,
                               const std::vector<Target>& targets) {
  std::vector<const Method*> with_it, of_job;
  for (const auto& [method, field] : FieldsWith(option)) with_it.push_back(method);
  for (const Target& target : targets) of_job.push_back(target.method);
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} is an option of {}, the job has {}: leave it out, or "
                          "choose another --method",
                          option, NamesOf(with_it), NamesOf(of_job)),
              value);
}

Status SetValue(const std::string& option, const std::string& value,
                const std::vector<Target>& targets) {
  bool is_set = false;
  for (const Target& target : targets) {
    for (const Field* field : FieldsOf(target.method->message())) {
      const FieldRule& rule = RuleOf(*field);
      if (rule.option() != option) continue;
      const std::string text =
          rule.names_image() ? fs::absolute(value).lexically_normal().string() : value;
      if (auto set = SetField(*target.message, field->name(), text); !set) {
        return Fail(set.error().code, fmt::format("{}: {}", option, set.error().message),
                    value);
      }
      is_set = true;
    }
  }
  if (!is_set) return NoTarget(option, value, targets);
  return {};
}

}  // namespace

void AddMethodFlags(command_line::Command command, MethodFlags& flags) {
  std::vector<std::string> names;
  for (const Method& method : Methods()) names.push_back(method.name());
  command.AddOption("--method", flags.method, "how points are made of " + MethodsByKind())
      .OneOf(names);
  for (const Method& method : Methods()) {
    for (const Field* field : FieldsOf(method.message())) {
      const std::string& option = RuleOf(*field).option();
      const auto [at, is_new] = flags.values.try_emplace(option);
      if (!is_new) continue;
      command.AddOption(option, at->second, HelpOf(option)).Group("Of the methods");
    }
  }
}

Status SetMethods(const MethodFlags& flags, JobSpec& job) {
  if (flags.method) {
    if (auto chosen = ChooseMethod(*flags.method, job); !chosen) return chosen;
  }
  Discretization& of_meshes = *job.mutable_discretization();
  if (MethodOf(of_meshes) == nullptr) {
    MutableMessageOf(*DefaultMethodOf(ModelKind::kMesh), of_meshes);
  }
  for (const auto& [option, value] : flags.values) {
    if (!value) continue;
    if (auto set = SetValue(option, *value, TargetsIn(job)); !set) return set;
  }
  return {};
}

}  // namespace intaglio::cli
