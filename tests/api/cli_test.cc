// The command line through the real program.
#include <gmock/gmock.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "datasets/bvh_reader.h"
#include "graph/model_io.h"
#include "tests/support/child_process.h"
#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string ReadFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Outcome {
  int status = -1;
  std::string out, err;
};

class CliTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new testing::TemporaryFolder;
    for (const auto& [name, text] : testing::SmallWalkFiles()) shared_->Write("data/" + name, text);
    SaveModel(*testing::SmallModel(), shared_->path() / "walk.mgm");
  }
  static void TearDownTestSuite() { delete shared_; }

  // Arguments are the tests' own words; paths hold no quotes.
  Outcome Run(const std::string& arguments) {
    const std::string command = "cd '" + folder_.path().string() + "' && '" MORPHOGRAPH_PROGRAM "' " + arguments +
                                " > out.txt 2> err.txt < /dev/null";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(Path("out.txt")), ReadFile(Path("err.txt"))};
    fs::remove(Path("out.txt"));
    fs::remove(Path("err.txt"));
    return outcome;
  }
  fs::path Path(const std::string& name) const { return folder_.path() / name; }
  static std::string Model() { return "'" + (shared_->path() / "walk.mgm").string() + "'"; }
  static std::string Data() { return "'" + (shared_->path() / "data").string() + "'"; }
  static std::string Clip() { return "'" + (shared_->path() / "data/walk_brisk_000.bvh").string() + "'"; }
  std::vector<std::string> Listing() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      names.push_back(fs::relative(entry.path(), folder_.path()).string());
    std::sort(names.begin(), names.end());
    return names;
  }
  // A failure is told in one line and leaves nothing behind.
  void ExpectFailure(const std::string& arguments, int status, const std::string& why) {
    const std::vector<std::string> before = Listing();
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, status) << arguments << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why)) << arguments;
    if (status == 1) {
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
    EXPECT_EQ(Listing(), before) << arguments;
  }

  static testing::TemporaryFolder* shared_;
  testing::TemporaryFolder folder_;
};
testing::TemporaryFolder* CliTest::shared_ = nullptr;

TEST_F(CliTest, HelpAndVersionAreNoErrors) {
  EXPECT_EQ(Run("--help").status, 0);
  EXPECT_EQ(Run("synthesize --help").status, 0);
  EXPECT_THAT(Run("--version").out, HasSubstr("morphograph 0."));
}

TEST_F(CliTest, WrongUsageIsStatus2) {
  ExpectFailure("", 2, "subcommand");
  ExpectFailure("dance", 2, "dance");
  ExpectFailure("inspect", 2, "model");
  ExpectFailure("inspect " + Model() + " --json --dot", 2, "dot");
  ExpectFailure("synthesize --model " + Model() + " --out a.bvh", 2, "--duration");
  ExpectFailure("synthesize --model " + Model() + " --duration 2 --steps 3 --out a.bvh", 2, "duration");
  ExpectFailure("synthesize --model " + Model() + " --duration 2", 2, "--out");
  ExpectFailure("synthesize --model " + Model() + " --duration=-2 --out a.bvh", 2, "/duration");
  ExpectFailure("synthesize --model " + Model() + " --duration two --out a.bvh", 2, "two");
  ExpectFailure("train --data x", 2, "--out");
  ExpectFailure("serve --port 99999", 2, "--port");
  ExpectFailure("keyframes " + Clip() + " --method learned", 2, "--labels");
  ExpectFailure("serve --model " + Model() + " --database postgres://x --port 0", 2, "sqlite");
  ExpectFailure("train --data " + Data() + " --action dance --out m.mgm --quiet", 2, "--action: 'dance'");
}

TEST_F(CliTest, SeedsAreUnsigned64BitIntegers) {
  for (const std::string seed : {"-1", "18446744073709551616", "1.5", "1e3", "x"})
    ExpectFailure("synthesize --model " + Model() + " --steps 2 --seed=" + seed + " --out a.bvh", 2, "seed");
  EXPECT_EQ(Run("synthesize --model " + Model() + " --steps 2 --seed 18446744073709551615 --out a.bvh --report a.json").status, 0);
  EXPECT_THAT(ReadFile(Path("a.json")), HasSubstr("\"seed\":18446744073709551615"));
}

TEST_F(CliTest, SynthesizeGivesTheSameBytesForTheSameSeed) {
  const std::string command = "synthesize --model " + Model() + " --duration 3 --seed 42 --out ";
  ASSERT_EQ(Run(command + "a.bvh").status, 0);
  ASSERT_EQ(Run(command + "b.bvh").status, 0);
  EXPECT_EQ(ReadFile(Path("a.bvh")), ReadFile(Path("b.bvh")));
  EXPECT_NEAR(ParseBvh(ReadFile(Path("a.bvh")), "a").frame_count() / 30.0, 3, 0.1);
}

TEST_F(CliTest, FlagsOutrankTheRequestFile) {
  folder_.Write("request.json", R"({"model":"walk","steps":2,"seed":1,"style":"slow","output":{"unit":"cm"}})");
  ASSERT_EQ(Run("synthesize --model " + Model() + " --request request.json --out a.bvh").status, 0);
  ASSERT_EQ(Run("synthesize --model " + Model() + " --steps 2 --seed 1 --style slow --unit cm --out b.bvh").status, 0);
  EXPECT_EQ(ReadFile(Path("a.bvh")), ReadFile(Path("b.bvh")));
  ASSERT_EQ(Run("synthesize --model " + Model() + " --request request.json --duration 4 --style brisk --out c.bvh --report c.json").status, 0);
  const json report = json::parse(ReadFile(Path("c.json")));
  EXPECT_EQ(report["style"], "brisk");
  EXPECT_NEAR(report["duration"], 4, 0.1);
}

TEST_F(CliTest, CountMakesOneClipASeed) {
  ASSERT_EQ(Run("synthesize --model " + Model() + " --steps 2 --seed 7 --count 3 --out made/clips --report made/reports").status, 0);
  EXPECT_THAT(Listing(), ElementsAre("made", "made/clips", "made/clips/000.bvh", "made/clips/001.bvh", "made/clips/002.bvh",
                                     "made/reports", "made/reports/000.report.json", "made/reports/001.report.json",
                                     "made/reports/002.report.json"));
  ASSERT_EQ(Run("synthesize --model " + Model() + " --steps 2 --seed 8 --out one.bvh").status, 0);
  EXPECT_EQ(ReadFile(Path("made/clips/001.bvh")), ReadFile(Path("one.bvh")));
}

TEST_F(CliTest, ARequestThatAsksForSomethingIsMetAndSummedUp) {
  folder_.Write("way.json", R"({"model":"as a server calls it","seed":3,"style":"brisk","path":{"points":[[0,0],[0,4]],"tolerance":0.2}})");
  const std::string make = "synthesize --model " + Model() + " --request way.json ";
  ASSERT_EQ(Run(make + "--out one.bvh --report one.json").status, 0);
  const json report = json::parse(ReadFile(Path("one.json")));
  ASSERT_FALSE(report["constraints"].empty());
  for (const json& outcome : report["constraints"]) EXPECT_EQ(outcome["met"], true) << outcome;
  const Outcome many = Run(make + "--count 4 --out many --report many/reports");
  ASSERT_EQ(many.status, 0) << many.err;
  const json summary = json::parse(ReadFile(Path("many/summary.json")));
  EXPECT_EQ(summary["asked"], 4);
  EXPECT_LE(summary["path_deviation"]["mean"], 0.2);
  EXPECT_EQ(ReadFile(Path("many/000.bvh")), ReadFile(Path("one.bvh")));
  EXPECT_EQ(json::parse(ReadFile(Path("many/reports/000.report.json"))), report);
  // Clips that were asked for nothing in particular have nothing to sum up.
  ASSERT_EQ(Run("synthesize --model " + Model() + " --steps 2 --count 2 --out plain").status, 0);
  EXPECT_FALSE(fs::exists(Path("plain/summary.json")));
  // Without --model the file's model must be the embedded one.
  ExpectFailure("synthesize --request way.json --out a.bvh", 1, "/model");
  folder_.Write("tight.json", R"({"style":"brisk","path":{"points":[[0,0],[0,1.5],[1.5,1.5],[1.5,3],[0,3],[0,4.5]],"tolerance":0.01}})");
  ExpectFailure("synthesize --model " + Model() + " --request tight.json --out a.bvh", 1, "/path");
}

TEST_F(CliTest, FailuresSayWhereAndLeaveNothingBehind) {
  folder_.Write("broken.bvh", "HIERARCHY\nROOT hips\n{\n  OFFSET 0 zero 0\n}\n");
  folder_.Write("empty.bvh", "");
  folder_.Write("broken.json", "{\"model\": \"walk\",\n \"steps\": }");
  folder_.Write("later.json", "{\"path\": {}}");
  folder_.Write("damaged.mgm", ReadFile(shared_->path() / "walk.mgm").substr(0, 1000));
  const std::string make = "synthesize --model " + Model() + " --seed 1 ";
  ExpectFailure("inspect nothing.mgm", 1, "nothing.mgm");
  ExpectFailure("inspect damaged.mgm", 1, "damaged.mgm");
  ExpectFailure("inspect broken.bvh", 1, "broken.bvh");
  ExpectFailure("evaluate broken.bvh", 1, "broken.bvh:4:");
  ExpectFailure("evaluate empty.bvh", 1, "empty.bvh");
  ExpectFailure("evaluate nowhere.bvh --json", 1, "nowhere.bvh");
  ExpectFailure("keyframes broken.bvh", 1, "broken.bvh:4:");
  ExpectFailure("train --data broken.bvh --out m.mgm --quiet", 1, "broken.bvh:4:");
  ExpectFailure("train --data nowhere --out m.mgm --quiet", 1, "nowhere");
  ExpectFailure(make + "--request broken.json --out a.bvh", 1, "line 2");
  ExpectFailure(make + "--request later.json --out a.bvh", 1, "/path");
  ExpectFailure(make + "--request none.json --out a.bvh", 1, "none.json");
  ExpectFailure(make + "--steps 2 --style moonwalk --out a.bvh", 1, "brisk");
  ExpectFailure(make + "--duration 601 --out a.bvh", 1, "600");
  ExpectFailure(make + "--steps 2 --out missing/a.bvh", 1, "missing/a.bvh");
  ExpectFailure(make + "--steps 2 --out a.bvh --report missing/a.json", 1, "missing/a.json");
  ExpectFailure(make + "--steps 2 --count 2 --out new/folder --report broken.json", 1, "broken.json");
  ExpectFailure("serve --model damaged.mgm --port 0", 1, "damaged.mgm");
}

TEST_F(CliTest, StudyWritesAPageAndJsonThatDoNotDependOnThreads) {
  const std::string study = "study --quick --quiet --data " + Data() + " --seed 3 ";
  ASSERT_EQ(Run(study + "--jobs 1 --out one/new").status, 0);
  ASSERT_EQ(Run(study + "--jobs 2 --out two").status, 0);
  EXPECT_THAT(Listing(), ElementsAre("one", "one/new", "one/new/index.html", "one/new/study.json", "two", "two/index.html", "two/study.json"));
  json one = json::parse(ReadFile(Path("one/new/study.json"))), two = json::parse(ReadFile(Path("two/study.json")));
  EXPECT_EQ(one["times"]["jobs"], 1);
  EXPECT_EQ(two["times"]["jobs"], 2);
  one.erase("times");
  two.erase("times");
  EXPECT_EQ(one, two);
  EXPECT_EQ(one["data"]["clips"], 12);
  EXPECT_EQ(one["data"]["styles"][0]["name"], "brisk");
  EXPECT_EQ(one["seed"], 3);
  // The mixture alone misses by itself; what was learned from one step to the next is told apart from it.
  const json& transitions = one["sections"]["transitions"]["data"]["clean"];
  EXPECT_NEAR(transitions["none"]["relative_error"].get<double>(), 1, 1e-9);
  EXPECT_GT(transitions["edges"].size(), 0u);
  // Two clips of the twelve are left out of the base, and looked for in it by four accelerometers.
  const json& sensors = one["sections"]["sensors"]["data"];
  EXPECT_EQ(sensors["test_clips"].size(), 2u);
  EXPECT_LT(sensors["ways"]["kernels"]["error_cm"]["mean"], sensors["ways"]["nearest"]["error_cm"]["mean"]);
  EXPECT_LT(sensors["ways"]["kernels"]["jerk_ratio"], sensors["ways"]["nearest"]["jerk_ratio"]);
  EXPECT_THAT(ReadFile(Path("two/index.html")), HasSubstr("id=\"transitions\""));
}

TEST_F(CliTest, StudySaysWhatItCannotDoAndLeavesNothingBehind) {
  folder_.Write("file", "precious");
  folder_.Write("short/one.bvh", ReadFile(shared_->path() / "data/walk_brisk_000.bvh").substr(0, 5000));
  folder_.Write("labels.json", R"({"some_other_clip": [{"frame": 3, "label": "left_strike"}]})");
  // A second of one walk teaches nothing.
  MotionClip clip = testing::SmallWalks().front().second;
  folder_.Write("little/a_brisk_001.bvh", WriteBvh(ExportClip(clip.Slice(0, 30))));
  ExpectFailure("study --out s", 2, "--data");
  ExpectFailure("study --data " + Data(), 2, "--out");
  ExpectFailure("study --data " + Data() + " --out s --seed=-1", 2, "--seed");
  ExpectFailure("study --data " + Data() + " --out s --jobs 1000", 2, "--jobs");
  const std::string quiet = "study --quick --quiet --out s --data ";
  ExpectFailure(quiet + "nowhere", 1, "nowhere");
  ExpectFailure(quiet + "short", 1, "one.bvh");
  ExpectFailure(quiet + "little", 1, "enough examples");
  ExpectFailure(quiet + Data() + " --labels none.json", 1, "none.json");
  ExpectFailure(quiet + Data() + " --labels labels.json", 1, "labels.json");
  ExpectFailure(quiet + Data() + " --manifest none.json", 1, "none.json");
  ExpectFailure("study --quick --quiet --data " + Data() + " --out file", 1, "file: is a file, not a folder");
  ExpectFailure("study --quick --quiet --data " + Data() + " --out file/in", 1, "file");
  EXPECT_EQ(ReadFile(Path("file")), "precious");
}

TEST_F(CliTest, AFailureLeavesAnExistingFileWhole) {
  folder_.Write("a.bvh", "precious");
  ExpectFailure("synthesize --model " + Model() + " --steps 2 --style moonwalk --out a.bvh", 1, "moonwalk");
  ExpectFailure("synthesize --model " + Model() + " --steps 2 --out a.bvh --report missing/a.json", 1, "missing");
  EXPECT_EQ(ReadFile(Path("a.bvh")), "precious");
}

TEST_F(CliTest, OutputKeepsWhatIsNoFile) {
  const std::string make = "synthesize --model " + Model() + " --steps 2 --seed 3 --out ";
  ASSERT_EQ(Run(make + "a.bvh").status, 0);
  const std::string clip = ReadFile(Path("a.bvh"));
  // A pipe passes the clip on and stays a pipe; a link stays, and its file changes; a mode stays.
  ASSERT_EQ(::mkfifo(Path("pipe").c_str(), 0600), 0);
  const int reader = ::open(Path("pipe").c_str(), O_RDWR | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  ::fcntl(reader, F_SETPIPE_SZ, 1 << 20);
  ASSERT_EQ(Run(make + "pipe").status, 0);
  std::string passed(clip.size() + 1, '\0');
  passed.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::read(reader, passed.data(), passed.size()))));
  ::close(reader);
  EXPECT_EQ(passed, clip);
  EXPECT_TRUE(fs::is_fifo(Path("pipe")));
  folder_.Write("real.bvh", "old");
  fs::permissions(Path("real.bvh"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real.bvh", Path("link.bvh"));
  ASSERT_EQ(Run(make + "link.bvh").status, 0);
  EXPECT_TRUE(fs::is_symlink(Path("link.bvh")));
  EXPECT_EQ(ReadFile(Path("real.bvh")), clip);
  EXPECT_EQ(fs::status(Path("real.bvh")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  ASSERT_EQ(Run(make + "/dev/null --report /dev/null").status, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(CliTest, OneFileCannotTakeTwoOutputs) {
  folder_.Write("same", "precious");
  fs::create_symlink("same", Path("link"));
  ExpectFailure("synthesize --model " + Model() + " --steps 2 --out same --report ./same", 2, "same file");
  ExpectFailure("synthesize --model " + Model() + " --steps 2 --out same --report link", 2, "same file");
  ExpectFailure("train --data " + Data() + " --out d/training.json --report d", 2, "training.json");
  EXPECT_EQ(ReadFile(Path("same")), "precious");
}

TEST_F(CliTest, TrainsAModelAndReportsIt) {
  ASSERT_EQ(Run("train --data " + Data() + " --out a.mgm --jobs 1 --report report --quiet").out, "");
  const Outcome second = Run("train --data " + Data() + " --out b.mgm --jobs 2");
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("walk"));
  EXPECT_THAT(second.err, HasSubstr("reading clips"));          // plain lines where there is no terminal
  EXPECT_THAT(second.err, ::testing::Not(HasSubstr("\033")));
  const json report = json::parse(ReadFile(Path("report/training.json")));
  // Starts and ends of both styles, all of synthetic walks: made, out of standing.
  EXPECT_GE(report["starts_and_ends"].size(), 6u);
  for (const json& entry : report["starts_and_ends"]) {
    EXPECT_EQ(entry["learned_from"], "standing") << entry;
    EXPECT_GE(entry["examples"], 2) << entry;
  }
  EXPECT_EQ(report["clips"], 12);
  EXPECT_GE(report["model"]["primitives"].size(), 4u);
  // Neither threads nor the file's name are in the model.
  const json a = json::parse(Run("inspect a.mgm --json").out), b = json::parse(Run("inspect b.mgm --json").out);
  EXPECT_EQ(a["primitives"], b["primitives"]);
  EXPECT_EQ(a["edges"], b["edges"]);
  EXPECT_THAT(Run("inspect a.mgm --dot").out, ::testing::StartsWith("digraph"));
  EXPECT_THAT(Run("inspect a.mgm").out, HasSubstr("log marginal"));
}

TEST_F(CliTest, EvaluateGivesOneObjectAClip) {
  const Outcome one = Run("evaluate " + Clip() + " --json");
  ASSERT_EQ(one.status, 0) << one.err;
  const json evaluation = json::parse(one.out);
  EXPECT_EQ(evaluation["clip"], "walk_brisk_000");
  EXPECT_TRUE(evaluation["quality"]["contact_distance"].is_number());
  EXPECT_FALSE(evaluation["contacts"].empty());
  const Outcome all = Run("evaluate " + Data() + " --json --reference " + Data());
  ASSERT_EQ(all.status, 0) << all.err;
  EXPECT_EQ(std::count(all.out.begin(), all.out.end(), '\n'), 12);
  EXPECT_GE(json::parse(all.out.substr(0, all.out.find('\n')))["reference"]["windows"], 64);
  EXPECT_THAT(Run("evaluate " + Clip()).out, HasSubstr("walk_brisk_000"));
}

TEST_F(CliTest, EvaluateSaysWhySetsCannotBeCompared) {
  const Outcome one = Run("evaluate " + Clip() + " --json --reference " + Clip());
  ASSERT_EQ(one.status, 0) << one.err;
  const json evaluation = json::parse(one.out);
  EXPECT_TRUE(evaluation["quality"]["contact_distance"].is_number());
  EXPECT_TRUE(evaluation["reference"].is_null());
  EXPECT_THAT(evaluation["reference_problem"].get<std::string>(), ::testing::StartsWith("the clips yield too few windows"));
  EXPECT_THAT(Run("evaluate " + Clip() + " --reference " + Clip()).out, HasSubstr("not compared with the reference: the clips"));
  EXPECT_THAT(Run("evaluate " + Data() + " --reference " + Clip()).out, HasSubstr("the reference yield"));
}

TEST_F(CliTest, FramesCountAsInTheFile) {
  // A rest pose in front, as captures often begin with: every later frame of the file is one more.
  const std::string text = ReadFile(shared_->path() / "data/walk_brisk_000.bvh");
  const std::size_t count_at = text.find("Frames: ") + 8, rows_at = text.find('\n', text.find("Frame Time:")) + 1;
  const int frames = std::stoi(text.substr(count_at));
  const std::string first_row = text.substr(rows_at, text.find('\n', rows_at) - rows_at);
  std::string rest;
  for (long i = std::count(first_row.begin(), first_row.end(), ' '); i >= 0; --i) rest += i > 0 ? "0 " : "0\n";
  std::string with_rest = text;
  with_rest.insert(rows_at, rest);
  with_rest.replace(count_at, std::to_string(frames).size(), std::to_string(frames + 1));
  folder_.Write("a.bvh", text);
  folder_.Write("b.bvh", with_rest);
  const json plain = json::parse(Run("evaluate a.bvh --json").out), later = json::parse(Run("evaluate b.bvh --json").out);
  EXPECT_EQ(plain["first_frame"], 0);
  EXPECT_EQ(later["first_frame"], 1);
  EXPECT_EQ(later["frames"], plain["frames"]);
  EXPECT_EQ(later["curves"]["frame_rate"], 30);
  EXPECT_EQ(later["contacts"][3]["from"].get<int>(), plain["contacts"][3]["from"].get<int>() + 1);
  EXPECT_EQ(later["contacts"][3]["to"].get<int>(), plain["contacts"][3]["to"].get<int>() + 1);
  const json keyframes = json::parse(Run("keyframes a.bvh --json").out), shifted = json::parse(Run("keyframes b.bvh --json").out);
  EXPECT_EQ(shifted["keyframes"][3]["frame"].get<int>(), keyframes["keyframes"][3]["frame"].get<int>() + 1);
}

TEST_F(CliTest, LabelledExamplesSayWhereStepsBegin) {
  // Labels of a few clips, as somebody would mark them, teach where the steps of all clips begin.
  json labels;
  for (const std::string stem : {"walk_brisk_000", "walk_slow_000", "walk_slow_001"}) {
    const json found = json::parse(Run("keyframes '" + (shared_->path() / "data" / (stem + ".bvh")).string() + "' --json").out);
    for (const json& keyframe : found["keyframes"]) labels[stem].push_back(keyframe);
  }
  const auto train = [&](const std::string& keyframes) {
    folder_.Write("set.json", R"({"name": "labelled", "action": "stroll", "keyframes": ")" + keyframes + "\"}");
    return "train --data " + Data() + " --manifest set.json --out m.mgm --quiet";
  };
  folder_.Write("labels.json", labels.dump());
  const Outcome trained = Run(train("labels.json"));
  ASSERT_EQ(trained.status, 0) << trained.err;
  const json model = json::parse(Run("inspect m.mgm --json").out);
  int steps = 0;
  for (const json& primitive : model["primitives"]) steps += primitive["name"] == "left_stroll" ? primitive["examples"].get<int>() : 0;
  EXPECT_GT(steps, 40);  // twelve clips of 14 steps, half of them left ones
  fs::remove(Path("m.mgm"));
  // What is labelled counts, and is needed.
  ExpectFailure(train("none.json"), 1, "none.json");
  for (auto& [stem, list] : labels.items()) {
    for (json& keyframe : list) keyframe["label"] = "left_stance";
  }
  folder_.Write("left.json", labels.dump());
  ExpectFailure(train("left.json"), 1, "no kind of step");
  folder_.Write("other.json", R"({"nobody": [{"frame": 3, "label": "left_stance"}]})");
  ExpectFailure(train("other.json"), 1, "other.json");
  folder_.Write("jump.json", R"({"walk_slow_000": [{"frame": 30, "label": "take_off"}]})");
  ExpectFailure(train("jump.json"), 1, "jump.json: none of its labels");
}

TEST_F(CliTest, NamesThatAreNoUtf8AreTranscoded) {
  for (const auto& entry : fs::directory_iterator(shared_->path() / "data")) {
    std::string text = ReadFile(entry.path());
    const std::size_t at = text.find("JOINT Spine");
    ASSERT_NE(at, std::string::npos);
    text.insert(at + 6, "R\xFC""cken_");
    folder_.Write("caf\xE9/" + entry.path().filename().string(), text);
  }
  const Outcome trained = Run("train --data 'caf\xE9' --out m.mgm --quiet");
  ASSERT_EQ(trained.status, 0) << trained.err;
  ASSERT_EQ(Run("synthesize --model m.mgm --steps 2 --seed 1 --out a.bvh").status, 0);
  EXPECT_THAT(ReadFile(Path("a.bvh")), HasSubstr("R\xC3\xBC""cken_Spine"));
  EXPECT_THAT(json::parse(Run("inspect m.mgm --json").out)["command"].get<std::string>(), HasSubstr("caf\xC3\xA9"));
}

TEST_F(CliTest, EmptyFilesAreToldSo) {
  folder_.Write("empty", "");
  ExpectFailure("synthesize --model " + Model() + " --request empty --out a.bvh", 1, "empty: is empty");
  ExpectFailure("inspect empty", 1, "empty: is empty");
  ExpectFailure("keyframes " + Clip() + " --method learned --labels empty", 1, "empty: is empty");
  ExpectFailure("train --data " + Data() + " --manifest empty --out m.mgm --quiet", 1, "empty: is empty");
}

TEST_F(CliTest, ErrorsNameTheFilesAtFault) {
  folder_.Write("set/a_walk.bvh", ReadFile(shared_->path() / "data/walk_brisk_000.bvh"));
  folder_.Write("set/b_broken.bvh", "HIERARCHY\nROOT hips\n{\n  OFFSET 0 zero 0\n}\n");
  folder_.Write("set/c_broken.bvh", "HIERARCHY\n");
  ExpectFailure("evaluate set", 1, "b_broken.bvh:4:");
  ExpectFailure("train --data set --out m.mgm --quiet", 1, "c_broken.bvh");
  // One that is sound, but cannot be put on the first one's skeleton: it has no legs.
  folder_.Write("two/a.bvh", ReadFile(shared_->path() / "data/walk_brisk_000.bvh"));
  folder_.Write("two/b.bvh", "HIERARCHY\nROOT pole\n{ OFFSET 0 0 0 CHANNELS 3 Xrotation Yrotation Zrotation End Site { OFFSET 0 1 0 } }\n"
                "MOTION\nFrames: 3\nFrame Time: 0.1\n0 0 0\n0 0 1\n0 0 2\n");
  const Outcome unfit = Run("train --data two --out m.mgm --quiet");
  EXPECT_EQ(unfit.status, 1);
  EXPECT_THAT(unfit.err, HasSubstr("morphograph: b: cannot be put on the skeleton of a: "));
  EXPECT_THAT(unfit.err, ::testing::Not(HasSubstr("Retarget:")));
}

TEST_F(CliTest, KeyframesAlternate) {
  const Outcome found = Run("keyframes " + Clip() + " --json");
  ASSERT_EQ(found.status, 0) << found.err;
  std::string last;
  int landings = 0;
  const json parsed = json::parse(found.out);
  for (const json& keyframe : parsed["keyframes"]) {
    const std::string label = keyframe["label"];
    EXPECT_TRUE(keyframe["frame"].is_number_integer());
    if (label != "left_stance" && label != "right_stance") continue;
    EXPECT_NE(label, last);
    last = label;
    ++landings;
  }
  EXPECT_GE(landings, 12);
}

TEST_F(CliTest, ServesTheSameBytesThatSynthesizeWritesUntilToldToStop) {
  ASSERT_EQ(Run("synthesize --model " + Model() + " --duration 3 --seed 42 --out a.bvh").status, 0);
  testing::ChildProcess server("'" MORPHOGRAPH_PROGRAM "' serve --port 0 --threads 2 --model " + Model());
  const int port = testing::ServedPort(&server);
  EXPECT_EQ(testing::Ask(port, "GET", "/readyz").status, 200);
  const auto clip = testing::Ask(port, "POST", "/v1/clips", "", R"({"model":"walk","seed":42,"duration":3})");
  EXPECT_EQ(clip.body, ReadFile(Path("a.bvh")));
  server.Signal(SIGTERM);
  const int status = server.Wait();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(CliTest, AnInterruptedCommandLeavesNothingBehind) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    testing::ChildProcess command("'" MORPHOGRAPH_PROGRAM "' synthesize --model " + Model() +
                                  " --duration 2 --count 1000000 --out '" + Path("made/clips").string() + "' --report '" +
                                  Path("made/reports").string() + "' 2> /dev/null");
    for (int i = 0; i < 1000 && Listing().size() < 10; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_GE(Listing().size(), 10u) << "nothing was written";
    command.Signal(signal);
    const int status = command.Wait();
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << status;
    EXPECT_THAT(Listing(), IsEmpty());
  }
}

TEST_F(CliTest, ReconstructsWhatVirtualSensorsRead) {
  std::ofstream(Path("places.json")) << R"([{"joint": "left_wrist"}, {"joint": "right_wrist"}, {"joint": "left_ankle"}, {"joint": "right_ankle"}])";
  const Outcome sensors = Run("sensors " + Clip() + " --placements places.json --rate 60 --out readings.csv");
  ASSERT_EQ(sensors.status, 0) << sensors.err;
  EXPECT_THAT(ReadFile(Path("readings.csv")), ::testing::StartsWith("time,left_wrist.x,left_wrist.y,left_wrist.z,right_wrist.x"));
  const Outcome clip = Run("reconstruct --model " + Model() + " --method graph --input readings.csv --out made.bvh --report made.json --truth " + Clip());
  ASSERT_EQ(clip.status, 0) << clip.err;
  const json about = json::parse(ReadFile(Path("made.json"))).at("reconstruction");
  EXPECT_EQ(about.at("method"), "graph");
  // This model keeps no recordings, so that walks of its own have to do.
  EXPECT_LT(about.at("errors").at("position_rms_cm").at("mean").get<double>(), 10);
  EXPECT_GT(ParseBvh(ReadFile(Path("made.bvh")), "made.bvh").frame_count(), 60);
  // This walk begins with 0.6 s of standing: too short to be found, but it can be told.
  const std::string again = "reconstruct --model " + Model() + " --method graph --input readings.csv --out aligned.bvh --report aligned.json";
  const Outcome aligned = Run(again + " --align --standing 0,0.55");
  ASSERT_EQ(aligned.status, 0) << aligned.err;
  EXPECT_THAT(aligned.out, HasSubstr("aligned by standing from 0.00 to 0.55 s: left_wrist by "));
  EXPECT_EQ(json::parse(ReadFile(Path("aligned.json"))).at("reconstruction").at("alignment").at("sensors").size(), 4u);
  ExpectFailure("reconstruct --model " + Model() + " --method graph --input readings.csv --out b.bvh --align --standing 2,3", 1, "nobody stands there");
  ExpectFailure("reconstruct --model " + Model() + " --method graph --input readings.csv --out b.bvh --standing 0,0.55", 2, "--align");
  ExpectFailure("reconstruct --model " + Model() + " --method graph --input readings.csv --out b.bvh --align --standing 0.55,0", 2, "--standing");
}

TEST_F(CliTest, WritesMarkersAndTheirPlaces) {
  const Outcome markers = Run("markers " + Clip() + " --out markers.csv --write-placements places.json");
  ASSERT_EQ(markers.status, 0) << markers.err;
  EXPECT_THAT(ReadFile(Path("markers.csv")), HasSubstr("left_heel.x,left_heel.y,left_heel.z"));
  EXPECT_GT(json::parse(ReadFile(Path("places.json"))).at("placements").size(), 30u);
  ASSERT_EQ(Run("markers " + Clip() + " --principal 6 --out markers.csv --write-placements places.json").status, 0);
  EXPECT_EQ(json::parse(ReadFile(Path("places.json"))).at("placements").size(), 6u);
  ExpectFailure("markers " + Clip() + " --principal 60 --out markers.csv", 1, "60 of 41 markers");
}

TEST_F(CliTest, ReconstructsFromDamagedReadingsAndSaysSo) {
  std::ofstream(Path("places.json")) << R"([{"joint": "left_wrist"}, {"joint": "right_wrist"}, {"joint": "left_ankle"}, {"joint": "right_ankle"}])";
  ASSERT_EQ(Run("sensors " + Clip() + " --placements places.json --rate 60 --out sound.csv").status, 0);
  std::istringstream sound(ReadFile(Path("sound.csv")));
  std::ofstream damaged(Path("damaged.csv")), in_ms(Path("ms.csv"));
  std::string line;
  std::getline(sound, line);
  damaged << line << '\n';
  in_ms << line << '\n';
  for (int row = 0; std::getline(sound, line); ++row) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 13u);
    in_ms << std::to_string(1000 * std::stod(cells[0])) << line.substr(line.find(',')) << '\n';
    for (std::size_t c = 4; c < 7; ++c) cells[c] = "nan";                              // one sensor is dead
    if (row >= 20 && row < 50) cells[1] = cells[2] = cells[3] = "";                    // a gap of half a second
    damaged << cells[0];
    for (std::size_t c = 1; c < cells.size(); ++c) damaged << ',' << cells[c];
    damaged << '\n';
  }
  damaged.close();
  in_ms.close();
  const Outcome made = Run("reconstruct --model " + Model() + " --method olng --input damaged.csv --out again.bvh --report again.json");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("'right_wrist' says nothing at all; it is left out"));
  EXPECT_THAT(made.out, HasSubstr("'left_wrist' is silent from"));
  EXPECT_EQ(json::parse(ReadFile(Path("again.json"))).at("reconstruction").at("dead_sensors"), json::array({"right_wrist"}));
  ExpectFailure("reconstruct --model " + Model() + " --method olng --input ms.csv --out c.bvh", 1, "times are in seconds");
  ExpectFailure("reconstruct --model " + Model() + " --method olng --stream --placements places.json --report c.json", 2, "\"notes\"");
}

TEST_F(CliTest, SaysWhatIsWrongWithReadingsAndPlacements) {
  std::ofstream(Path("places.json")) << R"([{"joint": "tail"}])";
  ExpectFailure("sensors " + Clip() + " --placements places.json --rate 60 --out r.csv", 1, "places.json: the skeleton has no joint 'tail'");
  ExpectFailure("sensors " + Clip() + " --placements places.json --out r.csv", 2, "--rate");
  std::ofstream(Path("bad.csv")) << "time,left_wrist.x,left_wrist.y,left_wrist.z\n0,1,2,3\n0.1,1,zwei,3\n";
  ExpectFailure("reconstruct --model " + Model() + " --method olng --input bad.csv --out a.bvh", 1, "bad.csv:3:7");
  ExpectFailure("reconstruct --model " + Model() + " --method magic --input bad.csv --out a.bvh", 2, "magic");
  ExpectFailure("reconstruct --model " + Model() + " --input bad.csv --out a.bvh", 2, "--method");
}

}  // namespace
}  // namespace morphograph
