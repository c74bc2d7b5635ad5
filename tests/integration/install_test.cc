// cmake --install into a folder that is then moved: what is there, and that it works
// without the source tree, from another working directory and for another user.

#include <fmt/ranges.h>
#include <fnmatch.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using testing::Running;

/// The patterns of what deploy/debian/*.install takes from the installation, "usr/bin/x".
std::vector<std::string> PackagedPatterns() {
  std::vector<std::string> patterns;
  for (const auto& entry :
       fs::directory_iterator(fs::path(INTAGLIO_SOURCE_DIR) / "deploy/debian")) {
    if (entry.path().extension() != ".install") continue;
    std::istringstream lines(testing::TextIn(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      const std::string pattern = line.substr(0, line.find(' '));
      if (pattern.starts_with("usr/")) patterns.push_back(pattern);
    }
  }
  return patterns;
}

/// Whether debhelper takes `file` for `pattern`: the file or a folder that it is in.
bool IsTakenFor(const std::string& pattern, fs::path file) {
  for (; !file.empty(); file = file.parent_path()) {
    if (fnmatch(pattern.c_str(), file.c_str(), FNM_PATHNAME) == 0) return true;
  }
  return false;
}

class Installation : public ::testing::Test {
 protected:
  void SetUp() override {
    const fs::path first = folder_ / "first";
    const Ended installed = Run(
        INTAGLIO_CMAKE, {"--install", INTAGLIO_BUILD_DIR, "--prefix", first.string()});
    ASSERT_EQ(installed.exit_code, 0) << installed.output;
    fs::rename(first, moved_);
    fs::create_directory(home_);
  }
  Ended Run(const fs::path& program, const std::vector<std::string>& arguments) {
    Running run(program, arguments, folder_ / "output.txt");
    return run.WaitForEnd(60s);
  }
  /// A command of the moved installation, of a person with an empty home folder, typed in
  /// it. `bin`: the folder of the programs.
  Ended Type(std::vector<std::string> words, const fs::path& bin) {
    std::vector<std::string> all = {"-i",
                                    "-C",
                                    home_.string(),
                                    "HOME=" + home_.string(),
                                    "PATH=/usr/bin:/bin",
                                    (bin / "intaglio").string()};
    all.insert(all.end(), words.begin(), words.end());
    return Run("/usr/bin/env", all);
  }
  Ended Type(std::vector<std::string> words) {
    return Type(std::move(words), moved_ / "bin");
  }
  static std::set<std::string> NamesIn(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      names.insert(entry.path().filename().string());
    return names;
  }

  fs::path folder_ = test::FreshFolder();
  fs::path moved_ = folder_ / "moved", home_ = folder_ / "home";
};

TEST_F(Installation, HasAllThatBelongsToIt) {
  const std::set<std::string> programs = {"intaglio",
                                          "intaglio-console",
                                          "intaglio-discretizer",
                                          "intaglio-job-service",
                                          "intaglio-marker",
                                          "intaglio-mesh-reader",
                                          "intaglio-motion-bridge",
                                          "intaglio-picture-reader",
                                          "intaglio-recorder",
                                          "intaglio-reference-controller",
                                          "intaglio-sorter",
                                          "intaglio-synchronizer",
                                          "virtual-engraver"};
  EXPECT_EQ(NamesIn(moved_ / "bin"), programs);
  for (const char* kind : {"boards", "machines", "jobs", "truth"}) {
    EXPECT_EQ(NamesIn(moved_ / "share/intaglio" / kind),
              NamesIn(fs::path(INTAGLIO_SOURCE_DIR) / "deploy" / kind));
  }
  // The build writes the schemas.
  auto documents = NamesIn(fs::path(INTAGLIO_SOURCE_DIR) / "docs");
  documents.insert("schemas");
  EXPECT_EQ(NamesIn(moved_ / "share/doc/intaglio/docs"), documents);
  std::set<std::string> pages;
  for (const std::string& program : programs) {
    pages.insert(program + ".1");
    EXPECT_TRUE(fs::exists(moved_ / "share/bash-completion/completions" / program));
    EXPECT_TRUE(fs::exists(moved_ / "share/zsh/site-functions" / ("_" + program)));
    EXPECT_TRUE(
        fs::exists(moved_ / "share/fish/vendor_completions.d" / (program + ".fish")));
  }
  pages.insert({"intaglio-run.1", "intaglio-submit.1", "intaglio-recording.1"});
  EXPECT_THAT(NamesIn(moved_ / "share/man/man1"), IsSupersetOf(pages));
}

// What no pattern names fails in deploy/package (dh_missing), and so does a pattern that
// names nothing (dh_install).
TEST_F(Installation, EveryFileIsInAPackage) {
  std::map<std::string, int> taken;
  for (const std::string& pattern : PackagedPatterns()) taken[pattern] = 0;
  ASSERT_GE(taken.size(), 10u);
  for (const auto& entry : fs::recursive_directory_iterator(moved_)) {
    if (entry.is_directory() && !entry.is_symlink()) continue;
    const fs::path file = "usr" / entry.path().lexically_relative(moved_);
    bool packaged = false;
    for (auto& [pattern, count] : taken) {
      if (!IsTakenFor(pattern, file)) continue;
      packaged = true;
      ++count;
    }
    EXPECT_TRUE(packaged) << file << " is installed and in no package: name it in "
                          << "deploy/debian/intaglio.install";
  }
  for (const auto& [pattern, count] : taken)
    EXPECT_GT(count, 0) << "deploy/debian: " << pattern << " is not installed";
}

// Documents refer to each other, to example jobs and to message schemas; sources are not
// installed.
TEST_F(Installation, DocumentsReferToInstalledFiles) {
  const fs::path documents = moved_ / "share/doc/intaglio";
  const std::regex link(R"(\]\(([^)#: ]+)(#[^)]*)?\))");
  int checked = 0;
  for (const auto& entry : fs::recursive_directory_iterator(documents)) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = testing::TextIn(entry.path());
    for (std::sregex_iterator at(text.begin(), text.end(), link), end; at != end; ++at) {
      const std::string target = (*at)[1];
      const std::regex of_sources("(\\.\\./)+(idl|services|engrave|tests)(/.*)?");
      if (std::regex_match(target, of_sources)) continue;
      EXPECT_TRUE(fs::exists(entry.path().parent_path() / target))
          << entry.path() << ": " << target;
      ++checked;
    }
  }
  EXPECT_GT(checked, 100);
}

// The mesh is an OBJ, so the mesh reader is found as well; the material base is made in
// the home folder.
TEST_F(Installation, EngravesASuppliedJobAfterItWasMoved) {
  const Ended run = Type({"run", "sample", "--lockstep", "--out", "knot"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(fs::exists(home_ / "knot/views.png"));
  EXPECT_TRUE(fs::exists(home_ / ".local/share/intaglio/materials.db"));
  const std::string report = testing::TextIn(home_ / "knot/job.json");
  EXPECT_THAT(report, HasSubstr((moved_ / "share/intaglio/jobs/sample.obj").string()));
  EXPECT_THAT(report, Not(HasSubstr(INTAGLIO_SOURCE_DIR "/deploy")));
}

TEST_F(Installation, ListsItsProfiles) {
  const Ended unknown =
      Type({"discretize", "sample", "--machine", "els-30", "--out", "x.ply"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean els-03?"));
  std::vector<std::string> supplied;
  for (const auto& file :
       fs::directory_iterator(INTAGLIO_SOURCE_DIR "/deploy/machines")) {
    if (file.path().extension() == ".textproto")
      supplied.push_back(file.path().stem().string());
  }
  std::ranges::sort(supplied);
  EXPECT_THAT(unknown.output,
              HasSubstr(fmt::format("supplied profiles: {}", fmt::join(supplied, ", "))));
}

// A program alone has no supplied files: it names the folder where it expects them.
TEST_F(Installation, AProgramAloneNamesWhatIsMissing) {
  const fs::path alone = folder_ / "alone" / "bin";
  fs::create_directories(alone);
  fs::copy_file(moved_ / "bin/intaglio", alone / "intaglio");
  const Ended missing = Type({"run", "sample"}, alone);
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.output,
              HasSubstr((folder_ / "alone/share/intaglio/jobs").string()));
  EXPECT_THAT(missing.output, HasSubstr("INTAGLIO_SHARE"));
}

TEST_F(Installation, WithoutTheVirtualEngraverItsPackageIsNamed) {
  fs::remove(moved_ / "bin/virtual-engraver");
  const Ended run = Type({"run", "sample", "--lockstep", "--out", "knot"});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("intaglio-virtual-engraver"));
}

TEST_F(Installation, ManualPagesHaveNothingThatManComplainsOf) {
  if (!fs::exists("/usr/bin/man"))
    GTEST_SKIP() << "no /usr/bin/man: install the package man-db";
  for (const std::string& page : NamesIn(moved_ / "share/man/man1")) {
    const Ended shown =
        Run("/usr/bin/man", {"--warnings", "-E", "UTF-8", "-Tutf8", "-l",
                             (moved_ / "share/man/man1" / page).string()});
    EXPECT_EQ(shown.exit_code, 0) << shown.output;
    EXPECT_THAT(shown.output, Not(HasSubstr("warning:"))) << page;
    // Defaults are those of the reader, not of whoever built it.
    EXPECT_THAT(testing::TextIn(moved_ / "share/man/man1" / page),
                Not(HasSubstr("Default: /")))
        << page;
    EXPECT_THAT(shown.output, HasSubstr("User Commands"));
  }
}

TEST_F(Installation, BashCompletesWhatTheProgramUnderstands) {
  std::ofstream(folder_ / "complete.sh") << R"(set -u
source "$1/share/bash-completion/completions/intaglio"
offer() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _intaglio; echo "${COMPREPLY[*]:-}"; }
offer intaglio sub
offer intaglio recording e
offer intaglio run --lockst
)";
  const Ended ended = Run("/bin/bash", {folder_ / "complete.sh", moved_.string()});
  EXPECT_EQ(ended.output, "submit\nexport\n--lockstep\n");
  for (const std::string& name : NamesIn(moved_ / "share/bash-completion/completions")) {
    const Ended checked =
        Run("/bin/bash", {"-n", moved_ / "share/bash-completion" / "completions" / name});
    EXPECT_EQ(checked.exit_code, 0) << checked.output;
  }
}

}  // namespace
}  // namespace intaglio
