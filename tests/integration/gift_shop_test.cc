// The gift shop's day at the command line: a photo, a text, an STL in inches, and twenty
// names of which one cannot be written; each is looked at with `preview`, engraved, and
// handed over with its picture.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::ContainsRegex;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;
using testing::TextIn;

/// A grey photo: a bright disc whose edge fades, on black.
void WritePhoto(const fs::path& file) {
  constexpr int kSide = 60;
  std::vector<std::uint8_t> grey(kSide * kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double r = std::hypot(x - 29.5, y - 29.5) / 28;
      grey[static_cast<std::size_t>(y * kSide + x)] =
          static_cast<std::uint8_t>(r > 1 ? 0 : 255 * (1 - r * r));
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = kSide;
  image.format = PNG_FORMAT_GRAY;
  ASSERT_TRUE(
      png_image_write_to_file(&image, file.c_str(), 0, grey.data(), kSide, nullptr));
}

/// An STL of a tetrahedron whose base is an inch wide, in inches as some programs write.
void WriteInchStl(const fs::path& file) {
  std::ofstream(file) << R"(solid pyramid
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0.3 0.3 1
endloop
endfacet
facet normal 1 1 1
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0.3 0.3 1
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 1 0
vertex 0 0 0
vertex 0.3 0.3 1
endloop
endfacet
endsolid pyramid
)";
}

void WriteNames(const fs::path& file, const std::string& last) {
  std::ofstream out(file);
  out << "name\n";
  for (int i = 1; i < 20; ++i) out << "Name " << i << "\n";
  out << last << "\n";
}

/// Width and height of a PNG, and whether it has an alpha channel.
png_image HeaderOf(const fs::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, file.c_str())) << file;
  png_image_free(&image);
  return image;
}

class GiftShop : public ::testing::Test {
 protected:
  GiftShop() { setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1); }

  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(120s);
  }
  std::vector<std::string> InShop(std::vector<std::string> words) const {
    for (const std::string& word :
         {std::string("--domain"), std::string("47"), std::string("--tag"),
          "gifts" + std::to_string(getpid())}) {
      words.push_back(word);
    }
    return words;
  }
  static std::vector<std::string> Joined(std::vector<std::string> a,
                                         const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }
  /// A preview: it ends with 0, and page, picture and figures are there.
  std::string Preview(const std::string& name, const std::vector<std::string>& job) {
    const fs::path out = folder_ / name;
    const Ended ended = Type(Joined({"preview", "--out", out.string()}, job));
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    for (const char* file : {"preview.html", "preview.png", "preview.json"}) {
      EXPECT_TRUE(fs::exists(out / file)) << file;
    }
    for (const char* line : {"piece ", "points ", "time ", "verdict "}) {
      EXPECT_THAT(ended.output, HasSubstr(std::string("\n") + line)) << ended.output;
    }
    return ended.output;
  }
  /// Engraved and proved, with a picture for the customer.
  void Engrave(const std::string& name, const std::vector<std::string>& job) {
    const fs::path out = folder_ / name;
    const Ended ended = Type(Joined(
        {"run", "--lockstep", "--no-record", "--customer-picture", "--out", out.string()},
        job));
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_THAT(TextIn(out / "report.json"), HasSubstr("\"verdict\""));
    EXPECT_TRUE(fs::exists(out / "views.png"));
    const png_image picture = HeaderOf(out / "customer.png");
    EXPECT_GE(std::max(picture.width, picture.height), 2000u);
  }

  fs::path folder_ = test::FreshFolder();
  int typed_ = 0;
};

TEST_F(GiftShop, EngravesAPhoto) {
  const fs::path photo = folder_ / "couple.png";
  WritePhoto(photo);
  const std::vector<std::string> job = {photo, "--block", "50", "20",
                                        "60",  "--size",  "40"};
  const std::string shown = Preview("preview", job);
  // It stands upright, facing the viewer: wide and high, and thin.
  EXPECT_THAT(shown, HasSubstr("READY"));
  std::vector<std::string> run = job;
  run.front() = "--model";
  run.insert(run.begin() + 1, photo);
  Engrave("photo", run);
}

// In one command, beside each other; the size is that of the photo.
TEST_F(GiftShop, EngravesAPhotoAndAName) {
  const fs::path photo = folder_ / "cat.png";
  WritePhoto(photo);
  const std::vector<std::string> job = {photo,  "--size",    "20", "--text",
                                        "MIMI", "--spacing", "0.2"};
  const std::string shown = Preview("preview", Joined(job, {"--text-place", "below"}));
  EXPECT_THAT(shown, HasSubstr("the object (20.0 x 0.0 x 27.0 mm)"))
      << "20 mm, 2 mm between, and 5 mm";
  EXPECT_THAT(shown, Not(HasSubstr("overlap")));
  Engrave("cat", job);
  EXPECT_THAT(Preview("centre", Joined(job, {"--text-place", "centre"})),
              HasSubstr("the text and the models overlap in a volume of"));
}

TEST_F(GiftShop, EngravesAText) {
  const std::vector<std::string> job = {
      "--text", "Anna & Ben", "--text-height", "4", "--block", "60", "20", "40"};
  Preview("preview", job);
  Engrave("text", Joined(job, {"--picture-name", "Anna & Ben"}));
}

TEST_F(GiftShop, AsksWhetherAnStlIsInInches) {
  const fs::path stl = folder_ / "pyramid.stl";
  WriteInchStl(stl);
  const std::vector<std::string> block = {"--block", "60", "60", "60"};
  const Ended asked = Type(
      Joined({"preview", "--out", (folder_ / "asked").string(), stl.string()}, block));
  EXPECT_THAT(asked.output, HasSubstr("inches"));
  EXPECT_THAT(asked.output, HasSubstr("--unit 25.4"));
  EXPECT_THAT(asked.output, Not(HasSubstr("verdict     READY\n")));
  const std::vector<std::string> inches = Joined(block, {"--unit", "25.4"});
  const std::string shown = Preview("preview", Joined({stl.string()}, inches));
  EXPECT_THAT(shown, HasSubstr("25.4 x 25.4 x "));
  Engrave("pyramid", Joined({"--mesh", stl.string(), "--spacing", "0.5"}, inches));
}

TEST_F(GiftShop, EngravesTwentyNames) {
  const fs::path names = folder_ / "names.csv", job = folder_ / "name.textproto";
  std::ofstream(job) << R"(name: "key ring for {name}"
block { size_mm { x: 40 y: 12 z: 20 } }
glass: "K9"
discretization { min_spacing_mm: 0.2 }
laser { rate_hz: 200 }
models { text { text: "{name}" font: "DejaVu Sans" height_mm: 3 } }
)";
  Running up(Program("intaglio"),
             InShop({"up", "--folder", folder_ / "shop", "--speed", "20", "--warm-up",
                     "1", "--block", "40", "12", "20"}),
             folder_ / "up.txt");
  ASSERT_TRUE(Eventually(
      [&] { return up.Output().find("the shop is open") != std::string::npos; }, 60s))
      << up.Output();

  // U+10FFFD is in no font: nothing is submitted before every name can be written.
  WriteNames(names, "\xF4\x8F\xBF\xBD");
  const std::vector<std::string> submit = {"submit", job, "--series", names};
  const Ended refused = Type(InShop(submit));
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("U+10FFFD"));
  EXPECT_THAT(refused.output, HasSubstr("21")) << "the line of the file";
  EXPECT_THAT(Type(InShop({"list"})).output, Not(HasSubstr("key ring")));

  // A name that is too long for its block.
  WriteNames(names, "Maximiliane Konstantinopolitanska");
  const Ended wide = Type(InShop(submit));
  EXPECT_EQ(wide.exit_code, 2) << wide.output;
  EXPECT_THAT(wide.output, HasSubstr("shrink_to_fit"));
  EXPECT_THAT(Type(InShop({"list"})).output, Not(HasSubstr("key ring")));

  WriteNames(names, "Zo\xC3\xAB");
  std::vector<std::string> submit_for_program = submit;
  submit_for_program.push_back("--json");
  const Ended submitted = Type(InShop(submit_for_program));
  EXPECT_EQ(submitted.exit_code, 0) << submitted.output;
  EXPECT_THAT(submitted.output, HasSubstr("20 jobs submitted"));
  EXPECT_THAT(submitted.output, ContainsRegex("\"jobs\": *\\[[^]]*19,[^]]*20[^]]*\\]"));

  // The first piece is engraved, and its folder has what the customer gets.
  ASSERT_TRUE(Eventually([&] { return Type(InShop({"arm", "1"})).exit_code == 0; }, 60s));
  const Ended watched = Type(InShop({"watch", "1"}));
  EXPECT_EQ(watched.exit_code, 0) << watched.output;
  EXPECT_TRUE(Eventually(
      [&] {
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "shop")) {
          if (entry.path().filename() == "customer.png") return true;
        }
        return false;
      },
      60s));
  const Ended listed = Type(InShop({"list"}));
  EXPECT_THAT(listed.output, HasSubstr("key ring for Name 1"));
  EXPECT_THAT(listed.output, HasSubstr("key ring for Zo\xC3\xAB"));
  up.Signal(SIGINT);
  EXPECT_EQ(up.WaitForEnd(20s).exit_code, 0);
}

}  // namespace
}  // namespace intaglio
