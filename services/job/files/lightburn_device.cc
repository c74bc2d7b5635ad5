#include "services/job/files/lightburn_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/whole_file.h"
#include "engrave/io/zip_archive.h"
#include "services/job/files/json_position.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;
using drawing::Shown;

constexpr char kDriver[] = "JCZFiber";
constexpr std::size_t kMaxNamesShown = 10;

struct Range {
  double min = 0, max = 0;
  const char* unit = "";
};
constexpr Range kSize{1, 2000, "mm"}, kSpeed{10, 100000, "mm/s"};
constexpr Range kScale{0.5, 2, "as a ratio, 1 for the 100 % that LightBurn shows"};
constexpr Range kFrequency{0.001, 10000, "kHz"};
constexpr double kHzPerKhz = 1000;

std::string TextOf(const pb::Value& value) {
  switch (value.kind_case()) {
    case pb::Value::kNumberValue:
      return fmt::format("{}", value.number_value());
    case pb::Value::kStringValue:
      return fmt::format("\"{}\"", Shown(value.string_value()));
    case pb::Value::kBoolValue:
      return value.bool_value() ? "true" : "false";
    case pb::Value::kListValue: {
      const int count = value.list_value().values_size();
      return "a list of " + Counted(static_cast<std::uint64_t>(count), "value");
    }
    case pb::Value::kStructValue: {
      const std::uint64_t count = value.struct_value().fields().size();
      return "a group of " + Counted(count, "key");
    }
    default:
      return "null";
  }
}

/// The keys of a group of the file. Those that are asked for count as read.
class Keys {
 public:
  Keys(const pb::Struct& group, std::string path)
      : group_(group), path_(std::move(path)) {}

  const pb::Value* Find(const std::string& key) {
    const auto found = group_.fields().find(key);
    if (found == group_.fields().end()) return nullptr;
    read_.insert(key);
    return &found->second;
  }

  Result<std::optional<double>> Number(const std::string& key, const Range& range) {
    const pb::Value* value = Find(key);
    if (value == nullptr) return std::nullopt;
    if (value->kind_case() != pb::Value::kNumberValue) return Wrong(key, "a number");
    const double number = value->number_value();
    if (number >= range.min && number <= range.max) return number;
    return Wrong(key, fmt::format("in {:g}..{:g} {}", range.min, range.max, range.unit));
  }

  Result<double> RequiredNumber(const std::string& key, const Range& range) {
    const auto number = Number(key, range);
    if (!number) return tl::unexpected(number.error());
    if (*number) return **number;
    return Missing(key);
  }

  Result<bool> Flag(const std::string& key) {
    const pb::Value* value = Find(key);
    if (value == nullptr) return false;
    if (value->kind_case() == pb::Value::kBoolValue) return value->bool_value();
    return Wrong(key, "true or false");
  }

  tl::unexpected<Error> Missing(const std::string& key) const {
    return Fail(ErrorCode::kMissing,
                fmt::format("{}.{}: is missing; export the device with LightBurn again",
                            path_, key));
  }

  tl::unexpected<Error> Wrong(const std::string& key, const std::string& expected) const {
    const std::string text = TextOf(group_.fields().at(key));
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("{}.{}: {} is not {}; correct it in LightBurn, and export the "
                    "device again",
                    path_, key, text, expected),
        text);
  }

  /// Those that nobody has asked for.
  std::vector<DeviceSetting> NotRead() const {
    std::vector<DeviceSetting> rest;
    for (const auto& [key, value] : group_.fields()) {
      if (!read_.contains(key)) rest.push_back({Shown(key, 80), TextOf(value)});
    }
    return rest;
  }

 private:
  const pb::Struct& group_;
  std::string path_;
  std::set<std::string> read_;
};

/// Whether a key that is not read moves the beam's place. Of a lens' numbers 1 is no
/// correction, of angle and offset 0.
bool MovesTheBeam(const DeviceSetting& setting) {
  static const std::set<std::string> kNeutralOne = {
      "Galvo_1_Bulge", "Galvo_1_Skew", "Galvo_1_Trapezoid",
      "Galvo_2_Bulge", "Galvo_2_Skew", "Galvo_2_Trapezoid"};
  static const std::set<std::string> kNeutralZero = {"FieldAngle", "FieldOffsetX",
                                                     "FieldOffsetY"};
  static const std::set<std::string> kDirections = {"Galvo_1_Sign", "Galvo_2_Sign",
                                                    "MirrorX", "MirrorY"};
  return (kNeutralOne.contains(setting.key) && setting.value != "1") ||
         (kNeutralZero.contains(setting.key) && setting.value != "0") ||
         kDirections.contains(setting.key);
}

struct Candidate {
  const pb::Struct* group = nullptr;
  std::string path;
};

Result<LightBurnDevice> DeviceOf(const Candidate& candidate) {
  Keys keys(*candidate.group, candidate.path);
  LightBurnDevice device;
  keys.Find("Name");
  if (const pb::Value* name = keys.Find("DisplayName"))
    device.name = Shown(name->string_value(), 80);
  device.width_mm = INTAGLIO_TRY(keys.RequiredNumber("Width", kSize));
  device.height_mm = INTAGLIO_TRY(keys.RequiredNumber("Height", kSize));
  const pb::Value* group = keys.Find("Settings");
  if (group == nullptr) return keys.Missing("Settings");
  if (group->kind_case() != pb::Value::kStructValue)
    return keys.Wrong("Settings", "a group of keys");

  Keys settings(group->struct_value(), candidate.path + ".Settings");
  const auto first = INTAGLIO_TRY(settings.Number("Galvo_1_Scale", kScale));
  const auto second = INTAGLIO_TRY(settings.Number("Galvo_2_Scale", kScale));
  const bool first_is_x = INTAGLIO_TRY(settings.Flag("Galvo_1_is_X"));
  device.x_scale_ratio = (first_is_x ? first : second).value_or(1);
  device.y_scale_ratio = (first_is_x ? second : first).value_or(1);
  device.jump_mm_s = INTAGLIO_TRY(settings.Number("Default_JumpSpeed", kSpeed));
  const auto min_khz = INTAGLIO_TRY(settings.Number("Laser_MinFreq", kFrequency));
  const auto max_khz = INTAGLIO_TRY(settings.Number("Laser_MaxFreq", kFrequency));
  if (min_khz && max_khz && *min_khz > *max_khz)
    return settings.Wrong("Laser_MinFreq",
                          fmt::format("below Laser_MaxFreq, {}", *max_khz));
  if (min_khz) device.min_pulse_hz = *min_khz * kHzPerKhz;
  if (max_khz) device.max_pulse_hz = *max_khz * kHzPerKhz;

  std::vector<DeviceSetting> rest = keys.NotRead();
  std::ranges::move(settings.NotRead(), std::back_inserter(rest));
  std::ranges::sort(rest, {}, &DeviceSetting::key);
  for (DeviceSetting& setting : rest) {
    auto& list = MovesTheBeam(setting) ? device.field_not_read : device.not_read;
    list.push_back(std::move(setting));
  }
  return device;
}

const std::string& TextUnder(const pb::Struct& group, const std::string& key) {
  static const std::string kNone;
  const auto found = group.fields().find(key);
  return found == group.fields().end() ? kNone : found->second.string_value();
}

std::string NamesOf(const std::vector<Candidate>& devices) {
  std::vector<std::string> names;
  for (const Candidate& device : devices) {
    if (names.size() == kMaxNamesShown) {
      names.emplace_back("...");
      break;
    }
    names.push_back(fmt::format("\"{}\" ({})",
                                Shown(TextUnder(*device.group, "DisplayName"), 80),
                                Shown(TextUnder(*device.group, "Name"))));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

Result<Candidate> Choose(const std::vector<Candidate>& all, const std::string& name) {
  std::vector<Candidate> chosen;
  for (const Candidate& device : all) {
    if (name.empty() || TextUnder(*device.group, "DisplayName") == name)
      chosen.push_back(device);
  }
  if (chosen.empty()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("has no device \"{}\"; it has {}", name, NamesOf(all)), name);
  }
  const std::string names = NamesOf(chosen);
  std::erase_if(chosen, [](const Candidate& device) {
    return TextUnder(*device.group, "Name") != kDriver;
  });
  if (chosen.empty()) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("has no device of a BJJCZ board ({}) but {}; make the profile "
                    "of another controller from its family: intaglio machine new "
                    "lists them",
                    kDriver, names));
  }
  if (chosen.size() > 1) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("has {} of BJJCZ boards: {}; name one of them by --device, or "
                    "export it alone",
                    Counted(chosen.size(), "device"), NamesOf(chosen)));
  }
  return chosen.front();
}

// protobuf's parser bounds the depth of groups, but not that of lists: a MiB of "[" takes
// it 6 s and 1 GB. Devices nest six deep.
bool NestsTooDeep(std::string_view text) {
  constexpr int kMaxJsonDepth = 32;
  int depth = 0;
  char quote = 0;  // that of the string which is open; the parser takes ' as well
  for (std::size_t i = 0; i < text.size() && depth <= kMaxJsonDepth; ++i) {
    const char c = text[i];
    if (quote != 0) {
      if (c == '\\') ++i;
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return depth > kMaxJsonDepth;
}

Result<pb::Struct> ParseText(std::string_view text) {
  if (NestsTooDeep(text)) {
    return Fail(
        ErrorCode::kTooLarge,
        "nests lists and groups more than 32 deep, as no device of LightBurn does; "
        "export the device again");
  }
  pb::Struct whole;
  const auto status = pb::util::JsonStringToMessage({text.data(), text.size()}, &whole);
  if (status.ok()) return whole;
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("{}; LightBurn's devices are JSON texts (.lbdev) or zip archives "
                  "of them (.lbzip): export the device again",
                  LocateJsonError(text, std::string(status.message()))));
}

Result<std::vector<Candidate>> DevicesOf(const pb::Struct& whole) {
  Keys keys(whole, "");
  const pb::Value* list = keys.Find("DeviceList");
  if (list == nullptr || list->list_value().values_size() == 0) {
    return Fail(ErrorCode::kMissing,
                "DeviceList: has no device; export one with LightBurn (Devices, Export)");
  }
  std::vector<Candidate> devices;
  for (int i = 0; i < list->list_value().values_size(); ++i) {
    const pb::Value& device = list->list_value().values(i);
    const std::string path = fmt::format("DeviceList[{}]", i);
    if (device.kind_case() != pb::Value::kStructValue) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: {} is not a group of keys; export the device again",
                              path, TextOf(device)));
    }
    devices.push_back({&device.struct_value(), path});
  }
  return devices;
}

tl::unexpected<Error> TooLarge(std::uint64_t size, std::size_t max_size) {
  return Fail(
      ErrorCode::kTooLarge,
      fmt::format("{} bytes are more than {}; is it a device of LightBurn? Export "
                  "the device alone",
                  size, max_size));
}

/// The text of the only device file of a bundle.
Result<std::string> TextInArchive(std::string_view bytes) {
  const auto archive = io::ZipArchive::Open(bytes);
  if (!archive) {
    return Fail(ErrorCode::kUnreadable,
                "is a damaged zip archive; export the device again");
  }
  std::vector<io::ZipArchive::File> files = archive->Files();
  std::erase_if(files, [](const auto& file) { return !file.name.ends_with(".lbdev"); });
  if (files.size() != 1) {
    return Fail(files.empty() ? ErrorCode::kMissing : ErrorCode::kUnsupported,
                fmt::format("has {} of a device (.lbdev) and has to have one; export the "
                            "device alone",
                            Counted(files.size(), "file")));
  }
  if (files[0].size > kMaxLightBurnTextBytes)
    return TooLarge(files[0].size, kMaxLightBurnTextBytes);
  return archive->Read(files[0].name);
}

Result<LightBurnDevice> DeviceIn(std::string_view bytes, const std::string& name) {
  if (bytes.size() > kMaxLightBurnFileBytes)
    return TooLarge(bytes.size(), kMaxLightBurnFileBytes);
  std::string unpacked;
  if (bytes.starts_with("PK")) {
    unpacked = INTAGLIO_TRY(TextInArchive(bytes));
    bytes = unpacked;
  }
  bytes = io::WithoutByteOrderMark(bytes);
  if (bytes.size() > kMaxLightBurnTextBytes)
    return TooLarge(bytes.size(), kMaxLightBurnTextBytes);
  const pb::Struct whole = INTAGLIO_TRY(ParseText(bytes));
  const auto devices = INTAGLIO_TRY(DevicesOf(whole));
  const Candidate chosen = INTAGLIO_TRY(Choose(devices, name));
  return DeviceOf(chosen);
}

}  // namespace

Result<LightBurnDevice> ReadLightBurnDevice(std::string_view bytes,
                                            const std::string& file,
                                            const std::string& name) {
  auto device = DeviceIn(bytes, name);
  if (device) return device;
  return tl::unexpected(io::AboutFile(device.error(), file));
}

}  // namespace intaglio
