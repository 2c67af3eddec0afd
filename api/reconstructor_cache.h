#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "synthesis/sensors/reconstruction.h"

namespace morphograph {

/// Reconstructors that were made lately. Making one takes seconds and some hundred megabytes; requests with the same model, method and placements share it.
/// Safe from any thread; one is made at a time.
class ReconstructorCache {
 public:
  /// @param places  kept at a time, the least lately used goes first.
  explicit ReconstructorCache(std::size_t places = 4) : places_(places) {}

  std::shared_ptr<const Reconstructor> Get(const std::shared_ptr<const MotionGraph>& graph, ReconstructionMethod method,
                                           const std::vector<Placement>& sensors);

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const Reconstructor> reconstructor;
  };
  std::shared_ptr<const Reconstructor> Find(const std::string& key);

  const std::size_t places_;
  std::mutex entries_mutex_, making_mutex_;
  std::list<Entry> entries_;  // the latest first
};

}  // namespace morphograph
