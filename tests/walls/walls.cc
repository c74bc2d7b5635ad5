#include "tests/walls/walls.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
constexpr int kMaxLines = 400;
constexpr int kMaxFiles = 39;
constexpr std::size_t kMaxBuildColumns = 100;
constexpr char kBuildFile[] = "CMakeLists.txt";

// What each folder may include of the product, besides itself.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"engrave/core", {}},
    {"engrave/io", {"engrave/core"}},
    {"engrave/mesh", {"engrave/core", "engrave/io"}},
    {"engrave/mesh/files", {"engrave/core", "engrave/io", "engrave/mesh"}},
    {"engrave/mesh/import",
     {"engrave/core", "engrave/io", "engrave/mesh", "engrave/mesh/files"}},
    {"engrave/drawing/dxf", {"engrave/core", "engrave/io", "engrave/drawing"}},
    {"engrave/drawing/svg", {"engrave/core", "engrave/io", "engrave/drawing"}},
    {"engrave/curve", {"engrave/core"}},
    {"engrave/drawing",
     {"engrave/core", "engrave/curve", "engrave/io", "engrave/contour",
      "engrave/contour/region"}},
    {"engrave/image", {"engrave/core"}},
    {"engrave/discretize", {"engrave/core", "engrave/discretize/spacing"}},
    {"engrave/discretize/spacing", {"engrave/core"}},
    {"engrave/discretize/mesh",
     {"engrave/core", "engrave/mesh", "engrave/discretize/spacing"}},
    {"engrave/discretize/drawing",
     {"engrave/core", "engrave/drawing", "engrave/mesh", "engrave/discretize/spacing"}},
    {"engrave/discretize/picture",
     {"engrave/core", "engrave/image", "engrave/mesh", "engrave/discretize/spacing"}},
    {"engrave/optics", {"engrave/core"}},
    {"engrave/machine", {"engrave/core", "engrave/galvo", "engrave/optics"}},
    {"engrave/sort/beam", {"engrave/core"}},
    {"engrave/sort", {"engrave/core", "engrave/motion*", "engrave/sort/beam"}},
    {"engrave/motion/axis", {"engrave/core"}},
    {"engrave/drive", {"engrave/core"}},
    {"engrave/course", {"engrave/core"}},
    {"engrave/calibrate",
     {"engrave/core", "engrave/image", "engrave/machine", "engrave/motion"}},
    {"engrave/contour", {"engrave/core"}},
    {"engrave/contour/region", {"engrave/core", "engrave/contour"}},
    {"engrave/contour/milling",
     {"engrave/core", "engrave/contour", "engrave/contour/region"}},
    {"engrave/contour/files",
     {"engrave/core", "engrave/curve", "engrave/io", "engrave/drawing", "engrave/contour",
      "engrave/contour/region", "engrave/contour/milling"}},
    {"engrave/mark", {"engrave/core", "engrave/io"}},
    {"engrave/matrix_code", {"engrave/core"}},
    {"engrave/galvo", {"engrave/core", "engrave/mark"}},
    {"engrave/galvo/files", {"engrave/core", "engrave/io", "engrave/galvo"}},
    {"engrave/post", {"engrave/core", "engrave/io", "engrave/contour"}},
    {"engrave/motion", {"engrave/core", "engrave/drive", "engrave/motion/axis"}},
    {"engrave/formats", {"engrave/core", "engrave/io"}},
    {"engrave/proof",
     {"engrave/core", "engrave/formats", "engrave/mark", "engrave/mesh"}},
    {"engrave/render", {"engrave/core", "engrave/drawing", "engrave/io"}},
    {"materials_db", {"engrave/*"}},
    {"proto", {}},
    {"services/platform/bus", {"engrave/core", "idl"}},
    {"services/platform/link", {"engrave/core", "engrave/io"}},
    {"services/platform/recording", {"engrave/core", "engrave/io"}},
    {"services/platform/command_line", {"engrave/core", "engrave/io"}},
    {"services/platform/text_format", {"engrave/core", "engrave/io"}},
    {"services/platform/fields", {"engrave/core", "proto"}},
    {"services/platform/access", {"engrave/core", "engrave/io"}},
    {"services/platform/web", {"engrave/core"}},
    {"services/platform/security",
     {"engrave/core", "engrave/io", "services/platform/bus", "idl"}},
    {"services/platform/host/threads", {"engrave/core"}},
    {"services/platform/host/times", {}},
    {"services/platform/host/version",
     {"engrave/core", "engrave/io", "services/platform/bus", "idl", "proto"}},
    {"services/platform/host/safety", {"engrave/core", "services/platform/bus", "idl"}},
    {"services/platform/host/peers",
     {"engrave/core", "services/platform/bus", "services/platform/host/safety", "idl"}},
    {"services/platform/host/process",
     {"engrave/core", "services/platform/bus", "services/platform/command_line",
      "services/platform/link", "services/platform/host/peers",
      "services/platform/host/version", "idl"}},
    // proto has schemas alone, below everything: a stage's task and outcome are messages.
    {"services/platform/host/stage",
     {"engrave/core", "engrave/mark", "services/platform/bus",
      "services/platform/host/process", "services/platform/host/threads", "idl",
      "proto"}},
    {"services/job/methods", {"engrave/*", "proto", "services/platform/fields"}},
    // Warnings are messages of both kinds.
    {"services/job/verdict", {"engrave/core", "idl", "proto"}},
    {"services/job",
     {"engrave/*", "materials_db", "proto", "services/job/course", "services/job/methods",
      "services/platform/fields", "services/platform/host/threads",
      "services/platform/link", "services/platform/text_format"}},
    // What is mounted, as a sample of the bus.
    {"services/job/mounted",
     {"engrave/core", "idl", "services/job", "services/platform/bus"}},
    {"services/job/models",
     {"engrave/*", "proto", "services/job", "services/job/methods",
      "services/job/reading", "services/job/verdict", "services/platform/command_line",
      "services/platform/fields", "services/platform/text_format"}},
    {"services/job/reading",
     {"engrave/core", "engrave/image", "services/platform/command_line"}},
    {"services/job/marks",
     {"engrave/*", "proto", "services/job", "services/job/course",
      "services/job/models"}},
    // Contours of a job, from the bytes of its files to marks.
    {"services/job/course",
     {"engrave/*", "proto", "services/job", "services/job/methods", "services/job/models",
      "services/platform/fields"}},
    {"services/client",
     {"engrave/*", "proto", "idl", "services/drivers", "services/job",
      "services/job/marks", "services/job/models", "services/job/mounted",
      "services/job/verdict", "services/platform/*", "services/history",
      "services/virtual_engraver/truth"}},
    {"services/console",
     {"engrave/*", "materials_db", "proto", "idl", "services/client", "services/history",
      "services/job", "services/job/reading", "services/console/webhooks",
      "services/platform/*"}},
    {"services/console/webhooks",
     {"engrave/core", "engrave/io", "proto", "services/job", "services/platform/*"}},
    {"services/client/preview",
     {"engrave/*", "proto", "services/client", "services/job", "services/job/methods",
      "services/platform/fields", "services/job/models", "services/job/verdict",
      "services/platform/text_format"}},
    {"services/cli",
     {"engrave/*", "materials_db", "proto", "idl", "services/backup", "services/client",
      "services/client/preview", "services/job", "services/job/course",
      "services/job/marks", "services/job/methods", "services/job/models",
      "services/job/verdict", "services/platform/*", "services/history",
      "services/replayer", "services/scene", "services/sql",
      "services/virtual_engraver/truth"}},
    {"services/job_service",
     {"engrave/*", "materials_db", "proto", "idl", "services/job", "services/job/course",
      "services/job/marks", "services/job/models", "services/job/mounted",
      "services/job/verdict", "services/platform/*", "services/history", "services/sql"}},
    {"services/*",
     {"engrave/*", "materials_db", "proto", "idl", "services/job", "services/job/course",
      "services/job/marks", "services/job/models", "services/job/mounted",
      "services/job/reading", "services/job/verdict", "services/platform/*",
      "services/history"}},
    // Recordings as standard viewers show them.
    {"services/scene",
     {"engrave/core", "engrave/machine", "proto", "services/job",
      "services/platform/recording"}},
    {"services/recorder",
     {"engrave/core", "engrave/io", "idl", "proto", "services/platform/*",
      "services/scene"}},
    // Drivers of controllers, for the programs that hold a line to one: a controller may
    // move the stage and switch the laser.
    {"services/drivers",
     {"engrave/core", "engrave/io", "engrave/motion", "engrave/mark", "engrave/galvo*",
      "engrave/contour", "engrave/course", "engrave/post", "idl", "proto", "services/job",
      "services/platform/host/threads", "services/platform/link"}},
    // What the synchronizer and the marker have in common.
    {"services/cell",
     {"engrave/core", "engrave/formats", "engrave/io", "idl", "proto",
      "services/platform/bus", "services/platform/host/process",
      "services/platform/host/safety", "services/platform/host/stage"}},
    // Motion by hand, for the program that holds the line.
    {"services/cell/manual",
     {"engrave/core", "idl", "services/drivers", "services/platform/bus"}},
    // The sibling of the synchronizer, for machines that mark.
    {"services/marker",
     {"engrave/*", "idl", "proto", "services/cell", "services/cell/manual",
      "services/drivers", "services/job", "services/job/marks", "services/platform/*"}},
    {"services/motion_bridge",
     {"engrave/*", "idl", "proto", "services/cell/manual", "services/drivers",
      "services/job", "services/platform/*"}},
    {"services/synchronizer",
     {"engrave/*", "idl", "proto", "services/cell", "services/drivers", "services/job",
      "services/platform/*"}},
    // The stand-in of a cell's laser is the laser of the virtual engraver, whose pulses
    // end as they did in the recording: a second model of it could not prove the first.
    {"services/replayer",
     {"engrave/core", "engrave/io", "idl", "proto", "services/platform/bus",
      "services/platform/link", "services/platform/recording",
      "services/virtual_engraver"}},
    // A library that reads the job service's database; below client, above platform.
    {"services/history",
     {"engrave/core", "engrave/io", "idl", "proto", "services/platform/host/times",
      "services/sql"}},
    // One dialect of SQL, a file or a server; below everything that keeps a queue.
    {"services/sql", {}},
    // What a shop keeps, into one file and back.
    {"services/backup",
     {"engrave/core", "engrave/io", "services/history", "services/platform/host/times"}},
    {"services/virtual_engraver",
     {"engrave/core", "engrave/formats", "proto", "services/platform/command_line",
      "services/platform/link", "services/virtual_engraver/truth"}},
    // The laser controller of the virtual engraver behind real outputs: of a second one
    // nobody would know that it keeps the same rules.
    {"services/reference_controller",
     {"engrave/core", "engrave/io", "proto", "services/platform/command_line",
      "services/platform/fields", "services/platform/link",
      "services/platform/text_format", "services/virtual_engraver"}},
    {"services/virtual_engraver/truth",
     {"engrave/core", "engrave/io", "proto", "services/platform/fields",
      "services/platform/text_format"}},
};

// Headers of libraries that have to stay in one place.
struct Kept {
  std::string prefix;
  bool whole_name;  // a header of the standard library, not a folder of one
  std::vector<std::string> folders;
};
const std::vector<Kept> kKept = {
    {"CLI/", false, {"services/platform/command_line"}},
    {"curl/", false, {"services/console/webhooks"}},
    {"assimp/", false, {"engrave/mesh/import"}},
    {"boost/", false, {"services/platform/web"}},
    {"gpiod", false, {"services/reference_controller"}},
    {"sodium", false, {"services/platform/access"}},
    {"hb", false, {"engrave/drawing"}},
    {"lcms2", false, {"engrave/image"}},
    {"dds/", false, {"services/platform/bus"}},
    {"SQLiteCpp",
     false,
     {"materials_db", "services/backup", "services/history", "services/sql"}},
    {"sqlite3",
     false,
     {"materials_db", "services/backup", "services/history", "services/sql"}},
    {"libpq-fe.h", true, {"services/sql"}},
    {"google/protobuf", false, {"services/"}},
    {"zint.h", true, {"engrave/matrix_code"}},
    {"spdlog", false, {"services/"}},
    {"thread", true, {"services/"}},
    {"chrono", true, {"services/"}},
};

/// The room that a file is in: the innermost folder above it that has a row of its own,
/// else the folder below engrave/ or services/, else the one at the top.
std::string FolderOf(const std::string& path) {
  for (auto end = path.rfind('/'); end != std::string::npos && end > 0;
       end = path.rfind('/', end - 1)) {
    const std::string folder = path.substr(0, end);
    if (kMayInclude.contains(folder)) return folder;
  }
  const auto first = path.find('/');
  if (first == std::string::npos) return "";
  std::string top = path.substr(0, first);
  if (top != "engrave" && top != "services") return top;
  const auto second = path.find('/', first + 1);
  return second == std::string::npos ? top : path.substr(0, second);
}

bool Matches(const std::string& pattern, const std::string& folder) {
  return pattern.ends_with('*')
             ? folder.starts_with(pattern.substr(0, pattern.size() - 1))
             : folder == pattern;
}

bool MayInclude(const std::string& from, const std::string& to) {
  if (from == to) return true;
  const auto exact = kMayInclude.find(from);
  const auto found = exact != kMayInclude.end() ? exact : kMayInclude.find("services/*");
  return std::any_of(found->second.begin(), found->second.end(),
                     [&](const std::string& pattern) { return Matches(pattern, to); });
}

// Rooms of a folder in layers, the lowest first: a room includes those of lower layers
// and itself. Rooms that are not named make a layer above these, and what lies in no room
// the highest.
struct Layers {
  std::string folder;  // with its slash
  std::vector<std::set<std::string>> rooms;
};
const std::vector<Layers> kLayers = {
    // A family of controllers knows the interface, lockstep and itself: neither another,
    // nor the tables, which name them all.
    {"services/drivers/", {{"interface"}, {"lockstep"}}},
    {"services/job/",
     {{"drive", "fields", "head", "methods", "reading", "verdict"},
      {"machine"},
      {"beams"},
      {"convert", "mounted"},
      {"checks", "models", "plan", "quality"},
      {"course", "files"},
      {"marks", "teach"}}},
};

/// "grbl" of services/drivers/grbl/grbl_line.h; empty: in no room.
std::string RoomOf(const Layers& layers, const std::string& path) {
  const auto begin = layers.folder.size();
  const auto end = path.find('/', begin);
  return end == std::string::npos ? "" : path.substr(begin, end - begin);
}

std::size_t LayerOf(const Layers& layers, const std::string& room) {
  const auto layer = std::ranges::find_if(
      layers.rooms, [&](const auto& rooms) { return rooms.contains(room); });
  return static_cast<std::size_t>(layer - layers.rooms.begin()) + (room.empty() ? 1 : 0);
}

bool LiesBelow(const std::string& included, const std::string& path) {
  for (const Layers& layers : kLayers) {
    if (!path.starts_with(layers.folder) || !included.starts_with(layers.folder))
      continue;
    const std::string from = RoomOf(layers, path), to = RoomOf(layers, included);
    if (from != to && LayerOf(layers, to) >= LayerOf(layers, from)) return false;
  }
  return true;
}

bool IsOurs(const std::string& folder) {
  for (const char* top : {"engrave/", "services/", "materials_db", "proto", "idl"}) {
    if (folder.starts_with(top)) return true;
  }
  return false;
}

class Inspector {
 public:
  explicit Inspector(const fs::path& root) : root_(root) {}

  void Inspect(const fs::path& file) {
    const std::string path = file.lexically_relative(root_).string();
    const std::string folder = FolderOf(path);
    std::ifstream in(file);
    int lines = 0;
    bool once = false;
    for (std::string line; std::getline(in, line); ++lines) {
      once = once || line == "#pragma once";
      if (line.find("dds_") != std::string::npos && folder != "services/platform/bus" &&
          line.find("//") == std::string::npos) {
        Report(path, "names dds_ outside services/platform/bus: " + line);
      }
      CheckInclude(path, folder, IncludedBy(line));
    }
    ++files_in_[file.parent_path().lexically_relative(root_).string()];
    if (lines > kMaxLines)
      Report(path, "has " + std::to_string(lines) + " lines, 400 are the end");
    if (file.extension() == ".h" && !once) Report(path, "has no #pragma once");
  }

  /// A CMakeLists.txt.
  void InspectBuild(const fs::path& file) {
    static const std::regex kTwoSources("[^#]*\\.cc\\s+[\\w/]+\\.cc\\b.*");
    static const std::regex kSource("\\s+([\\w./-]+\\.cc)\\)?");
    const std::string path = file.lexically_relative(root_).string();
    std::ifstream in(file);
    std::string before;  // the source of the line above; empty: there is none
    for (std::string line; std::getline(in, line);) {
      if (line.size() > kMaxBuildColumns) Report(path, "has a longer line: " + line);
      if (std::regex_match(line, kTwoSources))
        Report(path, "has two sources in a line: " + line);
      std::smatch source;
      const bool is_source = std::regex_match(line, source, kSource);
      if (is_source && source[1] < before)
        Report(path, "is not sorted: " + before + " stands before " + source[1].str());
      before = is_source ? source[1].str() : "";
    }
  }

  std::vector<std::string> Take() {
    for (const auto& [folder, count] : files_in_) {
      if (count <= kMaxFiles) continue;
      Report(folder, "has " + std::to_string(count) +
                         " sources and headers; divide it: " + std::to_string(kMaxFiles) +
                         " are allowed");
    }
    return std::move(violations_);
  }

 private:
  void Report(const std::string& path, const std::string& what) {
    violations_.push_back(path + ": " + what);
  }

  void CheckInclude(const std::string& path, const std::string& folder,
                    const std::string& included) {
    if (included.empty()) return;
    const std::string to = FolderOf(included);
    if ((IsOurs(to) && !MayInclude(folder, to)) || !LiesBelow(included, path))
      Report(path, "may not include " + included);
    for (const Kept& kept : kKept) {
      const bool named =
          kept.whole_name ? included == kept.prefix : included.starts_with(kept.prefix);
      const bool allowed =
          std::any_of(kept.folders.begin(), kept.folders.end(),
                      [&](const std::string& f) { return folder.starts_with(f); });
      if (named && !allowed) Report(path, "may not include " + included);
    }
  }

  fs::path root_;
  std::map<std::string, int> files_in_;  // by folder
  std::vector<std::string> violations_;
};

}  // namespace

std::vector<std::string> Violations(const fs::path& root) {
  Inspector inspector(root);
  for (const char* top : {"engrave", "materials_db", "proto", "services"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cc") inspector.Inspect(entry.path());
    }
  }
  for (const char* top :
       {"deploy", "engrave", "idl", "materials_db", "proto", "services", "tests"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().filename() == kBuildFile) inspector.InspectBuild(entry.path());
    }
  }
  if (fs::exists(root / kBuildFile)) inspector.InspectBuild(root / kBuildFile);
  return inspector.Take();
}

}  // namespace intaglio::walls
