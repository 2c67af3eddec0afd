// The program: picks the verb, turns what went wrong into an exit status.
//   0 done; 1 the work failed, one line says why; 2 wrong usage.
#include <cstdio>
#include <iostream>
#include <new>

#include "api/cli/command.h"
#include "api/problem.h"
#include "api/training.h"
#include "synthesis/motion_synthesizer.h"

namespace {

int Fail(int status, const std::string& why) {
  std::cout.flush();
  // One line, whatever the reason holds.
  std::string line = why;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  std::fprintf(stderr, "morphograph: %s\n", line.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace morphograph;
  CLI::App program("Learns walking from motion capture and makes new walks of it.", "morphograph");
  program.set_version_flag("--version", "morphograph " MORPHOGRAPH_VERSION);
  program.require_subcommand(1);
  Work work;
  for (const auto add : {AddTrain, AddInspect, AddSynthesize, AddEvaluate, AddKeyframes, AddStudy, AddSensors, AddMarkers, AddReconstruct, AddServe})
    add(&program, &work);
  // CLI11 would only say that a subcommand is missing.
  const auto is_given = [&](const CLI::App* verb) { return verb->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && program.get_subcommands(is_given).empty())
    return Fail(2, "there is no verb '" + std::string(argv[1]) + "'; --help lists them");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;  // --help and --version are no errors
  }
  try {
    work();
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0) return Fail(1, "standard output cannot be written");
    return 0;
  } catch (const UsageError& error) {
    return Fail(2, error.what());
  } catch (const TrainingUsageError& error) {
    return Fail(2, "train: --" + error.pointer().substr(1) + ": " + error.what());
  } catch (const ProblemError& error) {
    return Fail(1, ProblemLine(error.problem()));
  } catch (const UnsatisfiableRequest& error) {
    std::string why;
    for (const UnmetField& field : error.unmet())
      why += (why.empty() ? "" : "; ") + field.pointer + (field.pointer.empty() ? "" : ": ") + field.detail;
    return Fail(1, why);
  } catch (const std::bad_alloc&) {
    return Fail(1, "out of memory");
  } catch (const std::exception& error) {
    return Fail(1, error.what());
  } catch (...) {
    return Fail(1, "failed for an unknown reason");
  }
}
