#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/nci/nci_read.h"
#include "engrave/drawing/svg/svg_read.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/image/image_file.h"
#include "engrave/io/csv.h"
#include "engrave/io/whole_file.h"
#include "engrave/mesh/import/mesh_import.h"
#include "tests/engrave/mesh/mesh_file.h"
#include "tests/test_folder.h"

// The limits of the time and memory that any file may cost any reader: every seed of the
// fuzzers, and every broken file, is given to every reader under that reader's extension,
// in a process of its own.

namespace intaglio {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxSeconds = 2;  // of processor time, so that others may be busy
constexpr long kMaxKilobytes = 512 << 10;
constexpr rlim_t kHangSeconds = 8;
// The sanitizers take several times the memory and the time, and have other questions.
#ifdef __SANITIZE_ADDRESS__
constexpr bool kMeasured = false;
#else
constexpr bool kMeasured = true;
#endif

struct Reader {
  const char* extension;
  Status (*read)(const fs::path& file);
};

Status ReadAsMesh(const fs::path& file) {
  return mesh::ImportMesh(file).map([](const auto&) {});
}
Status ReadAsPoints(const fs::path& file) {
  return formats::ReadPoints(file).map([](const auto&) {});
}
Status ReadAsCsv(const fs::path& file) {
  return io::ReadCsv(file).map([](const auto&) {});
}

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 28;

template <typename Read>
Status ReadDrawing(const fs::path& file, const Read& read) {
  const auto text = io::ReadWholeFile(file, kMaxFileBytes);
  if (!text) return tl::unexpected(text.error());
  const auto drawing = read(*text, drawing::ReadOptions{}, file.string());
  return drawing ? Status() : tl::unexpected(drawing.error());
}
Status ReadAsDxf(const fs::path& file) { return ReadDrawing(file, drawing::ReadDxf); }
Status ReadAsSvg(const fs::path& file) { return ReadDrawing(file, drawing::ReadSvg); }
Status ReadAsHpgl(const fs::path& file) { return ReadDrawing(file, drawing::ReadHpgl); }
Status ReadAsNci(const fs::path& file) { return ReadDrawing(file, drawing::ReadNci); }

/// Reads bytes of any format; the file name is added to the error here.
Status ReadAsImage(const fs::path& file) {
  const auto text = io::ReadWholeFile(file, kMaxFileBytes);
  if (!text) return tl::unexpected(text.error());
  const auto picture = image::ParseImage(*text);
  if (picture) return {};
  return Fail(picture.error().code, file.string() + ": " + picture.error().message);
}

constexpr std::array<Reader, 21> kReaders = {
    {{"stl", ReadAsMesh},   {"obj", ReadAsMesh},   {"ply", ReadAsMesh},
     {"3mf", ReadAsMesh},   {"gltf", ReadAsMesh},  {"glb", ReadAsMesh},
     {"dae", ReadAsMesh},   {"3ds", ReadAsMesh},   {"ply", ReadAsPoints},
     {"xyz", ReadAsPoints}, {"txt", ReadAsPoints}, {"cft", ReadAsPoints},
     {"scl", ReadAsPoints}, {"dxf", ReadAsPoints}, {"none", ReadAsPoints},
     {"csv", ReadAsCsv},    {"dxf", ReadAsDxf},    {"svg", ReadAsSvg},
     {"plt", ReadAsHpgl},   {"nci", ReadAsNci},    {"png", ReadAsImage}}};

double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// What is wrong with an error: it must name the file, and perhaps the place in it, then
/// the problem; then the remedy.
std::string FaultOf(const Error& error, const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t at = error.message.find(name);
  if (at == std::string::npos) return "does not name the file";
  const std::size_t problem = error.message.find(": ", at + name.size());
  if (problem == std::string::npos) return "names no problem";
  if (error.message.find_first_of(";:", problem + 2) == std::string::npos) {
    return "names no remedy";
  }
  return {};
}

/// Runs every reader in turn and writes one line per error. The last line names the
/// reader at work.
void ReadInEveryWay(const fs::path& seed, const fs::path& folder, int report) {
  const auto print = [&](const std::string& text) {
    [[maybe_unused]] const auto written = write(report, text.data(), text.size());
  };
  for (const Reader& reader : kReaders) {
    const fs::path file = folder / fmt::format("seed.{}", reader.extension);
    fs::remove(file);
    fs::create_symlink(seed, file);
    print(fmt::format("{}", reader.extension));
    const double before = ProcessorSeconds();
    const Status status = reader.read(file);
    const double seconds = ProcessorSeconds() - before;
    if (const std::string fault = status ? "" : FaultOf(status.error(), file);
        !fault.empty()) {
      print(fmt::format(": the error \"{}\" {}", status.error().message, fault));
    }
    if (kMeasured && seconds > kMaxSeconds) print(fmt::format(": took {} s", seconds));
    print("\n");
  }
}

struct Outcome {
  std::string report;
  int status = 0;
  long peak_kilobytes = 0;
};

Outcome InAProcess(const fs::path& seed, const fs::path& folder) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return {"no pipe", -1, 0};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    const rlimit limit{kHangSeconds, kHangSeconds};
    setrlimit(RLIMIT_CPU, &limit);
    try {
      ReadInEveryWay(seed, folder, ends[1]);
    } catch (const std::exception& thrown) {
      const std::string text = fmt::format(": threw {}", thrown.what());
      [[maybe_unused]] const auto written = write(ends[1], text.data(), text.size());
      _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  Outcome outcome;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    outcome.report.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  rusage usage{};
  wait4(child, &outcome.status, 0, &usage);
  outcome.peak_kilobytes = usage.ru_maxrss;
  return outcome;
}

/// The folders of seeds, and that of the broken files.
std::vector<fs::path> Folders() {
  std::vector<fs::path> folders;
  const fs::path source = INTAGLIO_SOURCE_DIR;
  for (const auto& entry : fs::directory_iterator(source / "tests/fuzz/corpus")) {
    folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  folders.push_back(source / "tests/data/broken");
  return folders;
}

class ReaderBounds : public testing::TestWithParam<fs::path> {};

TEST_P(ReaderBounds, HoldForEveryFileAndReader) {
  const fs::path folder = test::FreshFolder();
  std::string expected;
  for (const Reader& reader : kReaders) expected += fmt::format("{}\n", reader.extension);
  long peak_kilobytes = 0;
  for (const auto& seed : fs::directory_iterator(GetParam())) {
    std::ifstream in(seed.path(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    // The seeds of meshes begin with a byte that picks the format.
    for (const std::string& bytes :
         {whole, whole.substr(std::min<std::size_t>(1, whole.size())),
          whole.substr(0, whole.size() / 2)}) {
      std::ofstream(folder / "bytes", std::ios::binary) << bytes;
      const Outcome outcome = InAProcess(folder / "bytes", folder);
      const std::string name =
          fmt::format("{}, {} bytes", seed.path().string(), bytes.size());
      EXPECT_EQ(outcome.report, expected) << name;
      EXPECT_EQ(outcome.status, 0) << name << ": status or signal";
      peak_kilobytes = std::max(peak_kilobytes, outcome.peak_kilobytes);
      if (kMeasured) {
        EXPECT_LE(outcome.peak_kilobytes, kMaxKilobytes) << name;
      }
    }
  }
  RecordProperty("peak_kilobytes", std::to_string(peak_kilobytes));
}

INSTANTIATE_TEST_SUITE_P(Folders, ReaderBounds, testing::ValuesIn(Folders()),
                         [](const auto& folder) {
                           return folder.param.filename().string();
                         });

}  // namespace
}  // namespace intaglio
