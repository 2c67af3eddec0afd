#include "api/clip_store.h"

#include "synthesis/control/sensor_guide.h"

namespace morphograph {
namespace {

std::size_t BytesOf(const ClipRequest& request) {
  // A number takes eight bytes, and its text two or more.
  const std::size_t bytes = 1000 + 4 * CanonicalJson(request).size();
  const auto& sensors = request.control.sensors;
  return bytes + (sensors && sensors->guide ? sensors->guide->bytes() : 0);
}

}  // namespace

void ClipStore::Put(const std::string& id, Entry entry) {
  const std::size_t bytes = BytesOf(entry.request);
  const std::lock_guard lock(mutex_);
  if (const auto known = by_id_.find(id); known != by_id_.end()) {
    by_use_.splice(by_use_.begin(), by_use_, known->second);
    return;
  }
  by_use_.push_front({id, std::move(entry), bytes});
  by_id_[id] = by_use_.begin();
  bytes_ += bytes;
  while (by_use_.size() > capacity_ || bytes_ > capacity_bytes_) {
    bytes_ -= by_use_.back().bytes;
    by_id_.erase(by_use_.back().id);
    by_use_.pop_back();
  }
}

std::optional<ClipStore::Entry> ClipStore::Get(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto known = by_id_.find(id);
  if (known == by_id_.end()) return std::nullopt;
  by_use_.splice(by_use_.begin(), by_use_, known->second);
  return known->second->entry;
}

std::size_t ClipStore::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::size_t ClipStore::size() const {
  const std::lock_guard lock(mutex_);
  return by_use_.size();
}

}  // namespace morphograph
