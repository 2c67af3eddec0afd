#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>

namespace morphograph {

/// Flags that do not go together, found after parsing: exit status 2, like any other wrong usage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the verb that was given does; set when its flags have been read.
using Work = std::function<void()>;

// One verb each: adds its flags to the program and sets `work` when it is the one given. The work prints to standard output;
// it throws UsageError for wrong usage and anything else when it fails.
void AddTrain(CLI::App* program, Work* work);
void AddInspect(CLI::App* program, Work* work);
void AddSynthesize(CLI::App* program, Work* work);
void AddEvaluate(CLI::App* program, Work* work);
void AddKeyframes(CLI::App* program, Work* work);
void AddStudy(CLI::App* program, Work* work);
void AddServe(CLI::App* program, Work* work);
void AddSensors(CLI::App* program, Work* work);
void AddMarkers(CLI::App* program, Work* work);
void AddReconstruct(CLI::App* program, Work* work);

}  // namespace morphograph
