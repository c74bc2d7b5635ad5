#include "services/job/teach/profile_history.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cctype>
#include <tuple>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/whole_file.h"
#include "services/job/files/job_file.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

constexpr std::string_view kField = "taught";

/// Walks over a text of fields, past strings and comments.
class FieldScan {
 public:
  explicit FieldScan(std::string_view text) : text_(text) {}

  /// The next field `taught` of the outermost message, with its value; npos: none.
  std::pair<std::size_t, std::size_t> Next() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (IsNamePart(c)) {
        const std::size_t begin = at_;
        while (at_ < text_.size() && IsNamePart(text_[at_])) ++at_;
        if (depth_ == 0 && text_.substr(begin, at_ - begin) == kField && OpensMessage())
          return {begin, EndOfMessage()};
      } else {
        Step();
      }
    }
    return {std::string_view::npos, std::string_view::npos};
  }

 private:
  static bool IsNamePart(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  }
  void SkipTo(char end) {
    while (at_ < text_.size() && text_[at_] != end) {
      at_ += text_[at_] == '\\' && end != '\n' ? 2 : 1;
    }
    at_ = std::min(at_ + 1, text_.size());
  }
  void Step() {
    const char c = text_[at_++];
    if (c == '#') SkipTo('\n');
    if (c == '"' || c == '\'') SkipTo(c);
    if (c == '{' || c == '<') ++depth_;
    if (c == '}' || c == '>') --depth_;
  }
  bool OpensMessage() {
    std::size_t at = at_;
    while (at < text_.size() &&
           (std::isspace(static_cast<unsigned char>(text_[at])) != 0 || text_[at] == ':'))
      ++at;
    return at < text_.size() && (text_[at] == '{' || text_[at] == '<');
  }
  std::size_t EndOfMessage() {
    do {
      Step();
    } while (at_ < text_.size() && (depth_ > 0 || !Closed()));
    if (at_ < text_.size() && text_[at_] == '\n') ++at_;
    return at_;
  }
  bool Closed() const { return text_[at_ - 1] == '}' || text_[at_ - 1] == '>'; }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

fs::path VersionFile(const fs::path& profile, std::uint32_t number) {
  return HistoryFolderOf(profile) / fmt::format("{:06}.textproto", number);
}

Result<TaughtVersion> ReadVersion(const fs::path& file) {
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxJobFileBytes));
  TaughtVersion version;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(nullptr);
  if (!parser.ParseFromString(text, &version)) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: is no version of taught positions; move it away", file.string()),
        file.string());
  }
  return version;
}

Status WriteVersion(const fs::path& profile, const TaughtVersion& version) {
  std::error_code error;
  fs::create_directories(HistoryFolderOf(profile), error);
  if (error) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot make the folder {}: {}; nothing was taught",
                            HistoryFolderOf(profile).string(), error.message()));
  }
  std::string text;
  pb::TextFormat::PrintToString(version, &text);
  return io::WriteFileAtomically(VersionFile(profile, version.taught().number()),
                                 std::string_view(text));
}

Status WriteTaught(const fs::path& profile, const MachineSpec& wanted) {
  if (profile.extension() == ".json") return WriteMachineFile(profile, wanted);
  const std::string old = INTAGLIO_TRY(io::ReadWholeFile(profile, kMaxJobFileBytes));
  const std::string text =
      WithTaught(std::string(io::WithoutByteOrderMark(old)), wanted.taught());
  // What the reader would make of it decides, not the scan.
  MachineSpec read;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(nullptr);
  const bool same = parser.ParseFromString(text, &read) &&
                    pb::util::MessageDifferencer::Equals(read.taught(), wanted.taught());
  if (!same) return WriteMachineFile(profile, wanted);
  return io::WriteFileAtomically(profile, std::string_view(text));
}

/// Who may read the profile may read it afterwards, whatever the mask of this process:
/// jobs are made with it.
Status WriteProfile(const fs::path& profile, const MachineSpec& wanted) {
  std::error_code error;
  const fs::perms before = fs::status(profile, error).permissions();
  INTAGLIO_TRY(WriteTaught(profile, wanted));
  // It is written; a system without such permissions does not matter.
  if (!error) fs::permissions(profile, before, error);
  return {};
}

/// The current version is in the history, also of a profile that was written by hand.
Status KeepCurrent(const fs::path& profile, const MachineSpec& machine,
                   const TaughtNote& note) {
  const std::uint32_t number = machine.taught().number();
  if (fs::exists(VersionFile(profile, number))) {
    const auto known = ReadVersion(VersionFile(profile, number));
    if (known && pb::util::MessageDifferencer::Equals(known->taught(), machine.taught()))
      return {};
  }
  TaughtVersion found;
  *found.mutable_taught() = machine.taught();
  found.set_time_utc(note.time_utc);
  found.set_change("as found in the profile");
  return WriteVersion(profile, found);
}

Result<std::uint32_t> Save(const fs::path& profile, MachineSpec machine,
                           TaughtVersion version) {
  const std::uint32_t number = machine.taught().number() + 1;
  version.mutable_taught()->set_number(number);
  INTAGLIO_TRY(WriteVersion(profile, version));
  *machine.mutable_taught() = version.taught();
  INTAGLIO_TRY(WriteProfile(profile, machine));
  return number;
}

TaughtVersion VersionOf(TaughtPositions taught, const TaughtNote& note) {
  TaughtVersion version;
  *version.mutable_taught() = std::move(taught);
  version.set_time_utc(note.time_utc);
  version.set_taught_by(note.taught_by);
  version.set_change(note.change);
  return version;
}

}  // namespace

fs::path HistoryFolderOf(const fs::path& profile) {
  return profile.string() + ".history";
}

std::string WithTaught(const std::string& text, const TaughtPositions& taught) {
  std::string kept;
  std::size_t from = 0;
  FieldScan scan(text);
  for (auto [begin, end] = scan.Next(); begin != std::string_view::npos;
       std::tie(begin, end) = scan.Next()) {
    kept += text.substr(from, begin - from);
    from = end;
  }
  kept += text.substr(from);
  if (!kept.empty() && kept.back() != '\n') kept += '\n';
  MachineSpec field;
  *field.mutable_taught() = taught;
  std::string printed;
  pb::TextFormat::PrintToString(field, &printed);
  return kept + printed;
}

Result<std::uint32_t> SaveTaught(const fs::path& profile, TaughtPositions taught,
                                 const TaughtNote& note) {
  auto machine = INTAGLIO_TRY(ReadMachineFile(profile));
  INTAGLIO_TRY(KeepCurrent(profile, machine, note));
  TaughtVersion version = VersionOf(std::move(taught), note);
  version.set_before(machine.taught().number());
  return Save(profile, std::move(machine), std::move(version));
}

Result<std::vector<TaughtVersion>> TaughtHistory(const fs::path& profile) {
  const auto machine = INTAGLIO_TRY(ReadMachineFile(profile));
  std::vector<TaughtVersion> versions;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(HistoryFolderOf(profile), error)) {
    if (entry.path().extension() != ".textproto") continue;
    auto version = INTAGLIO_TRY(ReadVersion(entry.path()));
    if (version.taught().number() <= machine.taught().number())
      versions.push_back(std::move(version));
  }
  std::sort(versions.begin(), versions.end(), [](const auto& a, const auto& b) {
    return a.taught().number() < b.taught().number();
  });
  return versions;
}

Result<TaughtVersion> UndoTaught(const fs::path& profile, TaughtNote note) {
  auto machine = INTAGLIO_TRY(ReadMachineFile(profile));
  const std::uint32_t number = machine.taught().number();
  const auto current = ReadVersion(VersionFile(profile, number));
  if (!current || !current->has_before()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("nothing to undo: {} knows no version before {}",
                            HistoryFolderOf(profile).string(), number));
  }
  const auto before = INTAGLIO_TRY(ReadVersion(VersionFile(profile, current->before())));
  if (note.change.empty()) {
    // An undo goes back to what an earlier change had made, and the next one undoes that
    // change: the version that directly follows the one that is restored.
    const std::uint32_t undone = current->before() + 1;
    const auto change = ReadVersion(VersionFile(profile, undone));
    note.change = fmt::format("undo of {}: {}", undone,
                              change ? change->change() : current->change());
  }
  TaughtVersion version = VersionOf(before.taught(), note);
  if (before.has_before()) version.set_before(before.before());
  const std::uint32_t saved = INTAGLIO_TRY(Save(profile, std::move(machine), version));
  version.mutable_taught()->set_number(saved);
  return version;
}

}  // namespace intaglio
