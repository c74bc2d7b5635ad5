#include "services/job/checks/job_check.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using testing::UnorderedElementsAre;

// Stage move for a focus move in N-BK7 is about 1 / n.
constexpr double kRatio = 0.65;

TEST(CheckJob, GoodJobsAreGood) {
  EXPECT_THAT(CheckAll(GoodJob(), GoodMachine(), kRatio), IsEmpty());
}

TEST(CheckJob, SixMistakesAreReportedAllAtOnce) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_placement()->set_fit_height_mm(2000);
  job.mutable_models(0)->set_file("/nowhere/cube.stl");
  job.clear_glass();
  job.mutable_discretization()->set_min_spacing_mm(std::nan(""));
  job.mutable_laser()->set_rate_hz(60);
  job.mutable_motion()->set_max_speed_mm_s(100);
  EXPECT_THAT(
      CheckAll(job, GoodMachine(), kRatio),
      UnorderedElementsAre(
          IsFinding("models[0].placement.fit_height_mm", "2000 is outside 0.1..1000"),
          IsFinding("models[0].file", "/nowhere/cube.stl does not exist"),
          IsFinding("glass", "is missing"),
          IsFinding("discretization.min_spacing_mm", "nan is outside 0.02..10"),
          IsFinding("laser.rate_hz",
                    "60 is none of the rates of els-03: 1 2 5 10 25 50 100 200"),
          IsFinding("motion.max_speed_mm_s", "100 is above the speed of els-03, 80")));
}

TEST(CheckJob, CracksMustBeDistinguishedWhateverMayBeMoved) {
  JobSpec job = GoodJob();
  job.mutable_discretization()->set_min_spacing_mm(0.1);
  job.mutable_motion()->set_tolerance_um(25);
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio), IsEmpty());
  job.mutable_motion()->set_tolerance_um(26);
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio),
              ElementsAre(IsFinding("motion.tolerance_um",
                                    "26 is above a quarter of the minimum spacing, 25")));
}

TEST(CheckJob, ACrackMustStillBeAtItsPlaceWhateverItsDepthMayBe) {
  JobSpec job = GoodJob();
  const double half_um = 500 * GoodMachine().lenses(0).crack_length_mm();
  job.mutable_motion()->set_depth_tolerance_um(half_um);
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio), IsEmpty());
  job.mutable_motion()->set_depth_tolerance_um(half_um + 1);
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio),
              ElementsAre(IsFinding("motion.depth_tolerance_um",
                                    "is above half of the length of a crack")));
}

TEST(CheckJob, AProfileThatIsNoneIsReported) {
  JobSpec job = GoodJob();
  job.mutable_motion()->set_profile(static_cast<MotionProfile>(99));
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio),
              ElementsAre(IsFinding("motion.profile", "99 is not a profile, 0..8")));
}

TEST(CheckJob, AnEmptyJobReportsAllThatIsRequired) {
  EXPECT_THAT(CheckJob(JobSpec()),
              UnorderedElementsAre(IsFinding("models", "missing"),
                                   IsFinding("block.size_mm", "missing"),
                                   IsFinding("glass", "missing"),
                                   IsFinding("discretization.min_spacing_mm", "missing"),
                                   IsFinding("machine_file", "missing")));
}

TEST(CheckJob, ErrorsCarryTheOffendingValue) {
  JobSpec job = GoodJob();
  job.mutable_block()->set_margin_mm(-1);
  const auto errors = CheckJob(job);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].code, ErrorCode::kInvalidValue);
  EXPECT_EQ(errors[0].value, "-1");
}

TEST(CheckJob, FindingsCarryTheirField) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->set_file("/nowhere/cube.stl");
  job.mutable_models(0)->mutable_placement()->set_fit_height_mm(2000);
  job.mutable_block()->set_margin_mm(-1);
  const auto found = CheckAll(job, GoodMachine(), kRatio);
  ASSERT_EQ(found.size(), 3u);
  std::vector<std::string> of_models, others;
  for (const Finding& finding : found) {
    EXPECT_THAT(finding.message, StartsWith(finding.field + ": "));
    (Concerns(finding, "models") ? of_models : others).push_back(finding.field);
  }
  EXPECT_THAT(of_models, UnorderedElementsAre("models[0].placement.fit_height_mm",
                                              "models[0].file"));
  EXPECT_THAT(others, ElementsAre("block.margin_mm"));
  EXPECT_TRUE(Concerns(Finding({}, "models"), "models"));
  EXPECT_FALSE(Concerns(Finding({}, "models_of_others"), "models"));
  EXPECT_FALSE(Concerns(Finding({}, "machine.models"), "models"));
}

struct Mistake {
  const char* path;
  const char* what;
  std::function<void(JobSpec&)> make;
};

TEST(CheckJob, EachMistakeIsFoundByItself) {
  const std::vector<Mistake> mistakes = {
      {"models[0].file", "is no",
       [](JobSpec& j) { j.mutable_models(0)->set_file("/tmp"); }},
      {"models[0].file", "has an unknown extension",
       [](JobSpec& j) { j.mutable_models(0)->set_file(__FILE__); }},
      {"models[0].file", "missing",
       [](JobSpec& j) { j.mutable_models(0)->clear_file(); }},
      {"models[0].placement.fit_block", "true",
       [](JobSpec& j) {
         j.mutable_models(0)->mutable_placement()->set_fit_block(false);
       }},
      {"models[0].placement.fit_height_mm", "more than the 24 mm",
       [](JobSpec& j) {
         j.mutable_models(0)->mutable_placement()->set_fit_height_mm(24.5);
       }},
      {"models[0].placement.fit_size_mm", "more than the 44 mm",
       [](JobSpec& j) {
         j.mutable_models(0)->mutable_placement()->set_fit_size_mm(44.5);
       }},
      {"models[0].placement.scale_ratio.y", "0 is outside",
       [](JobSpec& j) {
         auto& scale = *j.mutable_models(0)->mutable_placement()->mutable_scale_ratio();
         scale.set_x(2), scale.set_z(2);
       }},
      {"block.margin_mm", "leaves no space",
       [](JobSpec& j) { j.mutable_block()->set_margin_mm(15); }},
      {"block.size_mm.x", "does not fit in the travel",
       [](JobSpec& j) { j.mutable_block()->mutable_size_mm()->set_x(176); }},
      {"lens.focal_length_mm", "it has 43 70",
       [](JobSpec& j) { j.mutable_lens()->set_focal_length_mm(50); }},
      {"ordering.layers.layer_thickness_mm", "less than the layer distance",
       [](JobSpec& j) {
         j.mutable_ordering()->mutable_layers()->set_layer_thickness_mm(0.2);
       }},
      {"motion.max_acceleration_mm_s2", "7000",
       [](JobSpec& j) { j.mutable_motion()->set_max_acceleration_mm_s2(7001); }},
      {"laser.wavelength_nm", "532",
       [](JobSpec& j) { j.mutable_laser()->set_wavelength_nm(1064); }},
      {"laser.pulse_energy_mj", "30",
       [](JobSpec& j) { j.mutable_laser()->set_pulse_energy_mj(31); }},
      {"models[0].pulse_energy_mj", "30",
       [](JobSpec& j) { j.mutable_models(0)->set_pulse_energy_mj(31); }},
      {"models[0].min_spacing_mm", "is of a cloud of points",
       [](JobSpec& j) { j.mutable_models(0)->set_min_spacing_mm(1); }},
      {"models[0].even.light", "is no direction",
       [](JobSpec& j) { j.mutable_models(0)->mutable_even()->mutable_light(); }},
      {"models[0].even.sparse_distance_mm", "is below the distance of nearest points",
       [](JobSpec& j) {
         EvenMethod& even = *j.mutable_models(0)->mutable_even();
         even.set_curvature_radius_mm(1), even.set_distance_mm(0.5);
         even.set_sparse_distance_mm(0.4);
       }},
      {"models[0].curves.layer_distance_mm", "must be positive for 2 layers",
       [](JobSpec& j) {
         j.mutable_models(0)->set_file(INTAGLIO_SOURCE_DIR "/deploy/jobs/badge.svg");
         j.mutable_models(0)->mutable_curves()->set_layer_count(2);
         j.mutable_models(0)->mutable_curves()->set_layer_distance_mm(0);
       }},
      {"models[0].objects", "is an object of a mesh file",
       [](JobSpec& j) {
         j.mutable_models(0)->clear_file();
         j.mutable_models(0)->add_points_mm()->set_x(1);
         j.mutable_models(0)->add_objects("head");
       }},
      {"models[0].min_spacing_mm", "is below discretization.min_spacing_mm",
       [](JobSpec& j) {
         j.mutable_models(0)->clear_file();
         j.mutable_models(0)->add_points_mm()->set_x(1);
         j.mutable_models(0)->set_min_spacing_mm(0.02);
       }},
      {"block.quarter_turns", "outside 0..3",
       [](JobSpec& j) { j.mutable_block()->set_quarter_turns(4); }},
      {"laser.channels[0]", "outside 1..4",
       [](JobSpec& j) { j.mutable_laser()->add_channels(5); }},
      {"laser.channels[1]", "twice",
       [](JobSpec& j) {
         j.mutable_laser()->add_channels(2);
         j.mutable_laser()->add_channels(2);
       }},
  };
  for (const Mistake& mistake : mistakes) {
    JobSpec job = GoodJob();
    mistake.make(job);
    EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio),
                ElementsAre(IsFinding(mistake.path, mistake.what)));
  }
}

TEST(CheckJob, ClippedModelsMayBeLargerThanTheBlock) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_placement()->set_fit_height_mm(100);
  job.mutable_block()->set_clip(true);
  EXPECT_THAT(CheckAll(job, GoodMachine(), kRatio), IsEmpty());
}

TEST(CheckJobOnMachine, DepthTakesAsMuchTravelAsTheGlassMakesOfIt) {
  MachineSpec machine = GoodMachine();
  // Top margin at 27 mm; the deepest point at 3 mm is 27 mm under the face at 30 mm.
  machine.mutable_z()->set_travel_min_mm(30 - 27 * 0.65 - 0.01);
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, 0.65), IsEmpty());
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, 1.0),
              ElementsAre(IsFinding("block.size_mm.z", "does not fit in the travel")));
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine), IsEmpty());
}

TEST(CheckMachine, AnEmptyProfileReportsAllThatIsRequired) {
  std::vector<std::string> missing;
  for (const Error& error : CheckMachine(MachineSpec())) {
    if (error.code == ErrorCode::kMissing) missing.push_back(error.message);
  }
  EXPECT_THAT(missing, UnorderedElementsAre(StartsWith("name:"), StartsWith("x:"),
                                            StartsWith("y:"), StartsWith("z:"),
                                            StartsWith("block_origin_mm:"),
                                            StartsWith("laser:"), StartsWith("lenses:"),
                                            StartsWith("laser_line.protocol:"),
                                            StartsWith("motion_line.protocol:")));
}

TEST(CheckMachine, ManyMistakesAtOnce) {
  MachineSpec machine = GoodMachine();
  machine.set_name("els 03");
  machine.mutable_x()->set_travel_max_mm(-5);
  machine.mutable_y()->set_max_jerk_mm_s3(0);
  machine.mutable_laser()->set_rates_hz(2, 0.5);
  machine.mutable_lenses(1)->set_name("f43");
  machine.mutable_motion_line()->set_baud(300);
  EXPECT_THAT(CheckMachine(machine),
              UnorderedElementsAre(
                  IsFinding("name", "els 03"),
                  IsFinding("x.travel_min_mm", "not below x.travel_max_mm"),
                  IsFinding("y.max_jerk_mm_s3", "0 is outside 1..1000000000"),
                  IsFinding("laser.rates_hz[2]", "0.5 is outside 1..50000"),
                  IsFinding("lenses[1].name", "earlier lens"),
                  IsFinding("motion_line.baud", "300 is outside 1200..4000000")));
}

TEST(CheckMachine, ATriggerIsOneOfTheEnumeration) {
  MachineSpec machine = GoodMachine();
  machine.set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  EXPECT_THAT(CheckMachine(machine), ::testing::IsEmpty());
  machine.set_pulse_trigger(static_cast<PulseTriggerKind>(7));
  EXPECT_THAT(CheckMachine(machine),
              ElementsAre(IsFinding("pulse_trigger", "7 is no trigger")));
}

TEST(CheckMachine, AnExpectedSerialNumberIsOneThatAControllerCanReport) {
  MachineSpec machine = GoodMachine();
  for (const std::string& good :
       {std::string("A"), std::string("ST 7/2"), std::string(64, 'x')}) {
    machine.mutable_laser_line()->set_serial_number(good);
    machine.mutable_motion_line()->set_serial_number(good);
    EXPECT_THAT(CheckMachine(machine), IsEmpty()) << good;
  }
  machine.mutable_laser_line()->set_serial_number("");
  machine.mutable_motion_line()->set_serial_number("A\n03");
  EXPECT_THAT(CheckMachine(machine),
              UnorderedElementsAre(
                  IsFinding("laser_line.serial_number", "\"\" is not 1 to 64 printable"),
                  IsFinding("motion_line.serial_number", "\"A\\n03\" is not 1 to 64")));
  machine = GoodMachine();
  machine.mutable_motion_line()->set_serial_number(std::string(65, 'x'));
  EXPECT_THAT(CheckMachine(machine),
              ElementsAre(IsFinding("motion_line.serial_number", "remove the line")));
}

TEST(CheckMachine, ADeviceIsOfAFormThatCanBeOpened) {
  MachineSpec machine = GoodMachine();
  machine.mutable_laser_line()->set_device("tcp:192.168.7.20:5000");
  machine.mutable_motion_line()->set_device("serial:/dev/ttyUSB1");
  EXPECT_THAT(CheckMachine(machine), IsEmpty());
  machine.mutable_laser_line()->set_device("tcp:laser-box:5000");
  machine.mutable_motion_line()->set_device("wifi:1");
  EXPECT_THAT(
      CheckMachine(machine),
      UnorderedElementsAre(IsFinding("laser_line.device", "\"laser-box\" is neither"),
                           IsFinding("motion_line.device", "\"wifi:1\": it begins")));
}

TEST(JoinErrors, OneALine) {
  const Error joined =
      JoinErrors({{ErrorCode::kMissing, "a: b", "1"}, {ErrorCode::kIo, "c: d", "2"}});
  EXPECT_EQ(joined.message, "a: b\nc: d");
  EXPECT_EQ(joined.code, ErrorCode::kMissing);
}

TEST(CheckJob, APicturesPointsAreAtLeastASpacingApart) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_halftone()->set_distance_mm(0.25);
  const auto errors = CheckJobOnMachine(job, GoodMachine());
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_THAT(errors[0].message, HasSubstr("models[0].halftone.distance_mm: 0.25 is"));
  job.mutable_models(0)->mutable_halftone()->set_distance_mm(0.3);
  EXPECT_TRUE(CheckJobOnMachine(job, GoodMachine()).empty());
}

TEST(CheckJob, ATonesCurveRises) {
  JobSpec job = GoodJob();
  HalftoneMethod& halftone = *job.mutable_models(0)->mutable_halftone();
  for (const double from : {0.0, 0.5, 0.5}) halftone.add_curve()->set_from(from);
  const auto errors = CheckJobOnMachine(job, GoodMachine());
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_THAT(
      errors[0].message,
      HasSubstr("models[0].halftone.curve[2].from: 0.5 is not above the previous one"));
  halftone.mutable_curve(2)->set_from(1);
  EXPECT_TRUE(CheckJobOnMachine(job, GoodMachine()).empty());
  halftone.mutable_curve(2)->set_to(1.5);
  EXPECT_THAT(CheckJob(job)[0].message, HasSubstr("models[0].halftone.curve[2].to: 1.5"));
}

}  // namespace
}  // namespace intaglio
