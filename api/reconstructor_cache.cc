#include "api/reconstructor_cache.h"

#include <algorithm>

namespace morphograph {

std::shared_ptr<const Reconstructor> ReconstructorCache::Find(const std::string& key) {
  const std::lock_guard lock(entries_mutex_);
  const auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& known) { return known.key == key; });
  if (entry == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, entry);
  return entries_.front().reconstructor;
}

std::shared_ptr<const Reconstructor> ReconstructorCache::Get(const std::shared_ptr<const MotionGraph>& graph, ReconstructionMethod method,
                                                             const std::vector<Placement>& sensors) {
  const std::string key = graph->hash() + ' ' + std::string(MethodName(method)) + ' ' + PlacementsJson(sensors);
  if (auto known = Find(key)) return known;
  const std::lock_guard making(making_mutex_);
  if (auto known = Find(key)) return known;  // another request has made it meanwhile
  const std::shared_ptr<const Reconstructor> made = MakeReconstructor(graph, method, sensors);
  const std::lock_guard lock(entries_mutex_);
  entries_.push_front({key, made});
  if (entries_.size() > places_) entries_.pop_back();
  return made;
}

}  // namespace morphograph
