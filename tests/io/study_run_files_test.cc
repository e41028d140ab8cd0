// The files of the runs of a study: read as they were written, or not at all.
#include "io/study/study_run_files.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "io/study/study_folder.h"
#include "io/text/byte_stream.h"
#include "io/text/check_sum.h"
#include "support/folder_test.h"

namespace tetraction {
namespace {

class StudyTrackFile : public testing_support::FolderTest {
 protected:
  static MotionTrack track() {
    MotionTrack track;
    track.end = 0.5;
    track.count = 100;
    track.rest = Vector::LinSpaced(6, -1.0, 1.0 / 3.0);
    for (int k = 1; k <= 3; ++k) track.positions.emplace_back(track.rest * k);
    track.probes = {{"tip", 2, {0.0, 0.1}, {1.0, 2.0, 3.0, 4.0}}};
    return track;
  }

  // A file with a right seal around anything.
  std::string sealed(const std::string& bytes) const {
    ByteWriter seal;
    seal.put<std::uint64_t>(bytes.size());
    seal.put<std::uint64_t>(check_sum(bytes));
    return file("forged.bin", "tetraction track 1\n" + seal.bytes() + bytes);
  }
};

TEST_F(StudyTrackFile, IsReadAsItWasWritten) {
  const std::string place = path("a.bin");
  const MotionTrack written = track();
  write_study_track(place, written, "digest");
  const auto read = read_study_track(place, "digest");
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->end, written.end);
  EXPECT_EQ(read->count, written.count);
  EXPECT_EQ(read->rest, written.rest);
  ASSERT_EQ(read->positions.size(), 3U);
  EXPECT_EQ(read->positions[2], written.positions[2]);
  EXPECT_FALSE(read->is_whole());
  ASSERT_NE(read->probe("tip"), nullptr);
  EXPECT_EQ(read->probe("tip")->times, written.probes[0].times);
  EXPECT_EQ(read->probe("tip")->values, written.probes[0].values);
  EXPECT_EQ(read_study_track(place, "another digest"), nullptr);
  EXPECT_EQ(read_study_track(path("none.bin"), "digest"), nullptr);
}

TEST_F(StudyTrackFile, IsNotReadIfItIsDamaged) {
  const std::string place = path("a.bin");
  write_study_track(place, track(), "digest");
  const std::string whole = testing_support::contents(place);
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    file("a.bin", whole.substr(0, size));
    EXPECT_EQ(read_study_track(place, "digest"), nullptr) << size;
  }
  file("a.bin", whole + "x");
  EXPECT_EQ(read_study_track(place, "digest"), nullptr);
  for (std::size_t i = 0; i < whole.size(); i += 5) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 4);
    file("a.bin", changed);
    EXPECT_EQ(read_study_track(place, "digest"), nullptr) << i;
  }
}

TEST_F(StudyTrackFile, ImpossibleCountsAreRefused) {
  const auto forged = [&](std::uint64_t count, std::uint64_t positions, std::uint64_t width) {
    const MotionTrack track = StudyTrackFile::track();
    ByteWriter bytes;
    bytes.put_text("digest");
    bytes.put(track.end);
    bytes.put(count);
    bytes.put_all(track.rest.data(), 6);
    bytes.put(positions);
    bytes.put_all(track.rest.data(), 6);
    bytes.put<std::uint64_t>(1);
    bytes.put_text("tip");
    bytes.put(width);
    bytes.put_all(track.probes[0].times.data(), 2);
    bytes.put_all(track.probes[0].values.data(), 4);
    return read_study_track(sealed(bytes.bytes()), "digest");
  };
  EXPECT_NE(forged(100, 1, 2), nullptr);
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  EXPECT_EQ(forged(0, 1, 2), nullptr);
  EXPECT_EQ(forged(kHuge, 1, 2), nullptr);
  EXPECT_EQ(forged(100, kHuge, 2), nullptr);
  EXPECT_EQ(forged(100, 1, 3), nullptr);
  EXPECT_EQ(forged(100, 1, (std::uint64_t{1} << 63U) + 2), nullptr);
  EXPECT_EQ(read_study_track(sealed(""), "digest"), nullptr);
}

using StudyRowFile = testing_support::FolderTest;

TEST_F(StudyRowFile, BelongsToOneRun) {
  StudyPlan plan;
  plan.variants.resize(1);
  plan.variants[0].name = "new name";
  PlannedRun run;
  run.step = 0.5;
  run.solver = "newton";
  run.settings = {{"solver.tolerance", "1e-6"}};
  run.directory = "folder";
  run.role = StudyRole::kVariant;
  StudyRow row;
  row.status = RunStatus::kFinished;
  row.variant = "old name";
  row.step = 0.5;
  row.solver = "newton";
  row.settings = "solver.tolerance=1e-6";
  row.directory = "folder";
  const auto read = [&](const StudyRow& written) {
    write_study_row(path("row.json"), written, "digest");
    return read_study_row(path("row.json"), plan, run, "digest");
  };
  const auto same = read(row);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->variant, "new name");
  EXPECT_EQ(same->role, StudyRole::kVariant);
  EXPECT_FALSE(read_study_row(path("row.json"), plan, run, "another digest"));
  for (const auto& change : std::vector<void (*)(StudyRow&)>{
           [](StudyRow& other) { other.step = 0.25; },
           [](StudyRow& other) { other.integrator = Integrator::kVerlet; },
           [](StudyRow& other) { other.solver = "ceres"; },
           [](StudyRow& other) { other.settings.clear(); },
           [](StudyRow& other) { other.directory = "elsewhere"; },
           [](StudyRow& other) { other.status = RunStatus::kCancelled; }}) {
    StudyRow other = row;
    change(other);
    EXPECT_FALSE(read(other));
  }
}

TEST_F(StudyRowFile, TimesOfAChoiceAreTakenIfTheyCanBeTrue) {
  const auto times = [&](const std::string& choice) {
    file("study.json", R"({"choice": )" + choice + "}");
    return times_of_choice(folder_.string(), "d");
  };
  const auto of_verlet = [&](const std::string& seconds) {
    return times(R"({"digest": "d", "seconds_per_step": {"verlet": )" + seconds + "}}");
  };
  EXPECT_EQ(of_verlet("0.25"), (std::map<Integrator, double>{{Integrator::kVerlet, 0.25}}));
  EXPECT_EQ(of_verlet("0"), (std::map<Integrator, double>{{Integrator::kVerlet, 0.0}}));
  for (const char* seconds : {"-1", "-1e-300", "1e300", "1e999", "1e7", "18446744073709551615",
                              "null", "true", "\"1\"", "[1]", "{}"}) {
    EXPECT_TRUE(of_verlet(seconds).empty()) << seconds;
  }
  for (const char* choice : {"3", "null", "[]", "{}", R"({"digest": 3})", R"({"digest": "d"})",
                             R"({"digest": "d", "seconds_per_step": [1]})",
                             R"({"digest": "other", "seconds_per_step": {"verlet": 1}})",
                             R"({"digest": ["d"], "seconds_per_step": {"verlet": 1}})"}) {
    EXPECT_TRUE(times(choice).empty()) << choice;
  }
}

}  // namespace
}  // namespace tetraction
