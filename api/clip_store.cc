#include "api/clip_store.h"

namespace morphograph {

void ClipStore::Put(const std::string& id, Entry entry) {
  const std::lock_guard lock(mutex_);
  if (const auto known = by_id_.find(id); known != by_id_.end()) {
    by_use_.splice(by_use_.begin(), by_use_, known->second);
    return;
  }
  by_use_.emplace_front(id, std::move(entry));
  by_id_[id] = by_use_.begin();
  if (by_use_.size() > capacity_) {
    by_id_.erase(by_use_.back().first);
    by_use_.pop_back();
  }
}

std::optional<ClipStore::Entry> ClipStore::Get(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto known = by_id_.find(id);
  if (known == by_id_.end()) return std::nullopt;
  by_use_.splice(by_use_.begin(), by_use_, known->second);
  return known->second->second;
}

std::size_t ClipStore::size() const {
  const std::lock_guard lock(mutex_);
  return by_use_.size();
}

}  // namespace morphograph
